# Recipes for `just`; each is a script or a command that works without it.

# Format, lints and tests of the crates that have changed, or of those named: just fast steward-bt
fast *PACKAGES:
    .ci/fast {{PACKAGES}}

# Everything that must hold before a change lands; about 25 minutes on two cores.
gate:
    .ci/run

# Runs a scenario with the release binary: just scenario battery_fault --seed 2
scenario NAME *ARGUMENTS:
    cargo scenario {{NAME}} {{ARGUMENTS}}

# Benchmarks: just bench -p steward-bt
bench *ARGUMENTS:
    cargo bench {{ARGUMENTS}}
