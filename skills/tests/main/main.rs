//! Tests from outside the crate: the clauses of the recommendation, messages about broken files, the seven skills.

#![expect(clippy::unwrap_used, reason = "a test that panics has failed, and says where")]

mod answers;
mod appendix_d;
mod between_machines;
mod bombs;
mod broken_machines;
mod chance;
mod choice;
mod conversation;
mod diagnostics;
#[path = "../../../diagnostics/tests/xml/disturbed.rs"]
mod disturbed;
mod eighth_skill;
mod large;
mod layout;
#[path = "../../../channels/tests/system/lockstep.rs"]
mod lockstep;
mod mutations;
mod original;
mod properties;
mod seven_skills;
mod spec_3_core;
mod spec_4_content;
mod spec_5_data;
mod spec_6_4_invoke;
mod spec_6_send;
#[cfg(feature = "ecmascript")]
mod spec_b_2_engine;
mod stage;
mod system;
mod whole_system;
