//! Proofs about random systems agree with an enumeration of their runs, each judged by the definition.

use crate::cases::{cases, demanded};
use crate::support::classes::Topologies;
use crate::support::proofs::{Proofs, check_proof};

fn agree(first: u64, systems: u64, most: usize) -> Proofs {
    let topologies = Topologies::new();
    let mut proofs = Proofs::default();
    for seed in first..first + systems {
        check_proof(&topologies, seed, most, &mut proofs).unwrap_or_else(|what| panic!("{what}"));
    }
    eprintln!("{proofs}");
    proofs
}

/// Many fields, extreme constants, integers beyond 2⁵³, missing items, lost messages and parts that are trivially true.
#[test]
fn proofs_about_extreme_numbers_agree_with_an_enumeration() {
    let systems = cases(300);
    let proofs = agree(0, systems, 200);
    let enough = [proofs.proved, proofs.violated, proofs.read, proofs.cut_off];
    assert!(enough.iter().all(|count| count * 10 > systems), "{proofs}");
}

#[test]
#[ignore = "long: SYSTEMS=10000 SEED=0 cargo test --release -p steward-monitors proofs_agree_on_demand -- --ignored --nocapture"]
fn proofs_agree_on_demand() {
    let (systems, first) = (demanded("SYSTEMS", 1_000), demanded("SEED", 0));
    let topologies = Topologies::new();
    let mut proofs = Proofs::default();
    for seed in first..first + systems {
        check_proof(&topologies, seed, 5_000, &mut proofs).unwrap_or_else(|what| panic!("{what}"));
        if (seed + 1 - first).is_multiple_of(1_000) {
            println!("{} systems: {proofs}", seed + 1 - first);
        }
    }
    println!("{systems} systems: {proofs}; none wrong");
}
