//! The property files that come with the program.

/// The shipped files, by name: phi1 and phi2 as the paper prints them, and a variant of phi2 in which already being at
/// the charging station also answers.
pub const SHIPPED: [(&str, &str); 3] = [
    ("phi1", include_str!("../properties/phi1.scope")),
    ("phi2", include_str!("../properties/phi2.scope")),
    ("phi2_or_there", include_str!("../properties/phi2_variant.scope")),
];
