//! Runtime monitors over the channels of a system.
