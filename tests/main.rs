//! Whole-system tests: run the real binary as a user would.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

mod architecture;
mod bad_input;
mod bags;
mod campaign;
mod campaign_results;
mod check_command;
mod command_line;
mod components;
mod counterexamples;
mod determinism;
mod devices;
mod documentation;
mod experiments;
mod fault_combinations;
mod faults;
mod guide;
mod leaves;
mod live;
mod localize_command;
mod monitors;
mod navigation;
mod notices;
mod outputs;
mod programs;
mod protocol;
mod prove_command;
mod published;
mod ready_made_monitors;
mod recordings;
mod reference;
mod report_page;
mod reproduce;
mod roaml_models;
mod robot_settings;
mod schedules;
mod schemas;
mod skill_command;
mod skill_errors;
mod steward;
mod stop;
mod tree_command;
mod tree_errors;
mod without_a_map;
mod workspace;
