//! Values that were made from files, kept until something else is made of these.

use std::any::{Any, TypeId};
use std::collections::BTreeMap;
use std::mem;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The number of values of one type that are kept under one name: enough for a value and a variant of it, used in turn.
const KEPT: usize = 2;

/// Values by type and name, usually that of a file. They are expensive to make and cheap to clone. Of each type and
/// name, only the values used last are kept.
///
/// ```
/// use std::convert::Infallible;
/// use std::path::Path;
/// use std::sync::Arc;
///
/// use diagnostics::Memo;
///
/// let memo = Memo::default();
/// let upper = |text: &'static str| -> Result<Arc<str>, Infallible> {
///     memo.get(Path::new("a.txt"), text, || Ok(text.to_uppercase().into()))
/// };
/// let (one, again, other) = (upper("one")?, upper("one")?, upper("other")?);
/// assert!(Arc::ptr_eq(&one, &again));
/// assert_eq!(&*other, "OTHER");
/// # Ok::<(), Infallible>(())
/// ```
#[derive(Debug, Default)]
pub struct Memo(Mutex<Slots>);

type Slots = BTreeMap<(TypeId, PathBuf), Slot>;

/// The values of one type and name.
#[derive(Debug, Default)]
struct Slot {
    /// The one used last comes first.
    kept: Vec<Box<dyn Any + Send + Sync>>,
    is_used: bool,
}

/// A shared value, equal to its clones only. Comparing it is cheap, whatever the value.
#[derive(Clone, Debug)]
pub struct Same<T>(pub Arc<T>);

impl<T> PartialEq for Same<T> {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl Memo {
    /// The value that was made under this name from equal inputs, or otherwise a new one, which is kept. `make` must
    /// depend on nothing else. Threads that need the same new value at once may each make it.
    ///
    /// # Errors
    /// That of `make`, which is not kept.
    pub fn get<I, V, E>(&self, name: &Path, inputs: I, make: impl FnOnce() -> Result<V, E>) -> Result<V, E>
    where
        I: PartialEq + Send + Sync + 'static,
        V: Clone + Send + Sync + 'static,
    {
        if let Some(known) = self.find(name, |known: &Arc<(I, V)>| known.0 == inputs) {
            return Ok(known.1.clone());
        }
        let value = make()?;
        self.keep(name, Arc::new((inputs, value.clone())));
        Ok(value)
    }

    /// A kept value of this type and name for which `is_current` holds.
    pub fn find<V: Clone + 'static>(&self, name: &Path, is_current: impl Fn(&V) -> bool) -> Option<V> {
        let slot = (TypeId::of::<V>(), name.to_owned());
        let kept = |slot: &Slot| slot.kept.iter().filter_map(|one| one.downcast_ref().cloned()).collect();
        let kept: Vec<V> = self.slots().get(&slot).map(kept).unwrap_or_default();
        // Not under the lock: this may read files.
        let place = kept.iter().position(is_current)?;
        // Another thread may just have replaced it.
        if let Some(slot) = self.slots().get_mut(&slot).filter(|slot| place < slot.kept.len()) {
            slot.kept.swap(0, place);
            slot.is_used = true;
        }
        kept.into_iter().nth(place)
    }

    /// Keeps a value, in place of the one of this type and name that was not used for longest.
    pub fn keep<V: Send + Sync + 'static>(&self, name: &Path, value: V) {
        let mut slots = self.slots();
        let slot = slots.entry((TypeId::of::<V>(), name.to_owned())).or_default();
        slot.kept.insert(0, Box::new(value));
        slot.kept.truncate(KEPT);
        slot.is_used = true;
    }

    /// Forgets the values whose type and name were not used since this was called last.
    pub fn forget_unused(&self) {
        self.slots().retain(|_, slot| mem::take(&mut slot.is_used));
    }

    fn slots(&self) -> MutexGuard<'_, Slots> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;

    use super::*;

    /// The values that were made for these inputs, one after the other; that for 0 fails.
    fn made(inputs: &[u32]) -> Vec<u32> {
        let (memo, made) = (Memo::default(), RefCell::new(Vec::new()));
        for input in inputs {
            let make = || {
                made.borrow_mut().push(*input);
                if *input == 0 { Err(()) } else { Ok(10 * input) }
            };
            let expected = if *input == 0 { Err(()) } else { Ok(10 * input) };
            assert_eq!(memo.get(Path::new("a"), *input, make), expected);
        }
        made.into_inner()
    }

    #[test]
    fn a_value_is_made_again_once_two_others_were_used_since() {
        assert_eq!(made(&[1, 1, 2, 1, 2, 1]), [1, 2]);
        assert_eq!(made(&[1, 2, 1, 3, 1, 4, 1]), [1, 2, 3, 4], "the one in use stays");
        assert_eq!(made(&[1, 2, 3, 1]), [1, 2, 3, 1]);
    }

    #[test]
    fn a_failure_is_not_kept_and_displaces_nothing() {
        assert_eq!(made(&[1, 2, 0, 0, 1, 2]), [1, 2, 0, 0]);
    }

    #[test]
    fn values_of_other_types_and_names_are_apart() {
        let memo = Memo::default();
        let number = |name: &str, value: u32| memo.get(Path::new(name), (), || Ok::<_, ()>(value));
        assert_eq!([number("a", 1), number("b", 2), number("a", 3)], [Ok(1), Ok(2), Ok(1)]);
        assert_eq!(memo.get(Path::new("a"), (), || Ok::<u64, ()>(4)), Ok(4));
        assert_eq!(memo.get(Path::new("a"), 'c', || Ok::<u32, ()>(5)), Ok(5));
    }

    #[test]
    fn a_name_is_forgotten_once_it_is_no_longer_used() {
        let memo = Memo::default();
        let number = |name: &str, value: u32| memo.get(Path::new(name), (), || Ok::<_, ()>(value));
        assert_eq!([number("a", 1), number("b", 2)], [Ok(1), Ok(2)]);
        memo.forget_unused();
        assert_eq!(number("a", 3), Ok(1));
        memo.forget_unused();
        assert_eq!([number("a", 4), number("b", 5)], [Ok(1), Ok(5)]);
    }

    #[test]
    fn the_same_value_is_not_merely_an_equal_one() {
        let [one, other] = [(); 2].map(|()| Same(Arc::new(1)));
        assert!(one == one.clone() && one != other);
    }
}
