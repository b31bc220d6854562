//! The property files that come with the program.

/// The shipped files, by name: phi1 and phi2 as the paper prints them, a variant of phi2 in which already being at
/// the charging station also answers, and phi3, which asks for the arrival that phi2 leaves open.
pub const SHIPPED: [(&str, &str); 4] = [
    ("phi1", include_str!("../properties/phi1.scope")),
    ("phi2", include_str!("../properties/phi2.scope")),
    ("phi2_or_there", include_str!("../properties/phi2_variant.scope")),
    ("phi3", include_str!("../properties/phi3.scope")),
];
