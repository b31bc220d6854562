//! The sequence of random numbers of a machine.

/// The next number of the sequence, in [0, 1) with 53 bits: SplitMix64 (Steele, Lea and Flood, 2014).
pub(crate) fn next(position: &mut u64) -> f64 {
    *position = position.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let mut mixed = (*position ^ (*position >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    mixed ^= mixed >> 31;
    (mixed >> 11) as f64 / (1_u64 << 53) as f64
}
