//! Skills: an SCXML processor and the machines of the shipped tree.
