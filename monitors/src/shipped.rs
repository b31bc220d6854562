//! The property files that come with the program.

/// The shipped files, by name: phi1 and phi2 as the paper prints them, a variant of phi2 that also accepts being at the
/// charging station as an answer, and phi3, which requires the arrival that phi2 does not.
pub const SHIPPED: [(&str, &str); 4] = [
    ("phi1", include_str!("../properties/phi1.scope")),
    ("phi2", include_str!("../properties/phi2.scope")),
    ("phi2_or_there", include_str!("../properties/phi2_or_there.scope")),
    ("phi3", include_str!("../properties/phi3.scope")),
];
