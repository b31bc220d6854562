//! Scripts and what they amount to.
