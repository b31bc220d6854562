#!/usr/bin/env bash
# The paper's experiments from a fresh clone, as an artifact evaluator would run them: builds the program, runs the
# undisturbed scenario and the three experiments in simulation with 20 seeds each, and prints a table.
# Exit status 0: each claim from the paper holds in every run of its experiment.
# Needs Rust (https://rustup.rs; the toolchain in rust-toolchain.toml is downloaded automatically) and a C compiler.
# FEATURES=dds builds a program with that feature, too: the experiments do not need it.
# Usage: scenarios/reproduce.sh [--seeds N] [--map FILE] [--start X,Y,DEG] [--tree whole|nodes] [--out DIR]
set -euo pipefail
cd "$(dirname "$0")/.."
command -v cargo > /dev/null || { echo "cargo is missing: install Rust from https://rustup.rs" >&2; exit 3; }
cargo build --release --locked ${FEATURES:+--features "$FEATURES"}
exec "${CARGO_TARGET_DIR:-target}/release/steward" reproduce "$@"
