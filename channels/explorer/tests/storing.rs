//! How the states found are stored.

use crate::store::{Assignment, Packed, Store};

#[test]
fn states_keep_their_numbers_while_slots_grow_wider() {
    let vector = |number: u32| [number % 7, number / 7 % 101, 5, number / 707, number];
    let mut store = Store::new(&vector(0));
    let mut packed = Packed::default();
    let changes = |number: u32| (0..).zip(vector(number)).collect::<Vec<Assignment>>();
    let add = |store: &mut Store, from, changes: &[Assignment], packed: &mut Packed| {
        while let Err(misfit) = store.pack(from, changes, packed) {
            store.insert(packed, 0..packed.len());
            store.widen(misfit);
            store.clear(packed);
        }
    };
    store.clear(&mut packed);
    for number in 0..100_000 {
        add(&mut store, number / 4, &changes(number), &mut packed);
        add(&mut store, number / 5, &changes(number / 2), &mut packed);
        if number % 3 == 0 {
            store.insert(&packed, 0..packed.len());
            store.clear(&mut packed);
        }
    }
    store.insert(&packed, 0..packed.len());
    assert_eq!(store.len(), 100_000);
    let mut slots = Vec::new();
    for number in (0..100_000).rev() {
        store.unpack(number, &mut slots);
        assert_eq!(slots, vector(number));
        store.clear(&mut packed);
        assert_eq!(store.pack(number, &changes(number / 2), &mut packed), Ok(()));
        assert_eq!(store.pack(number, &[(2, 6)], &mut packed), Ok(()));
        assert_eq!(store.pack(number, &[(2, 9)], &mut packed), Err((2, 9)));
        assert_eq!([store.find(&packed, 0), store.find(&packed, 1)], [Some(number / 2), None]);
    }
}
