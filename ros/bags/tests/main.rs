//! What users of the crate see, in bags that are made here byte by byte; `foreign.py` reads those of other programs.

mod clock;
mod contents;
mod contradictions;
mod damage;
mod events;
mod following;
mod mappings;
mod messages;
mod on_board;
mod order;
mod packing;
mod reading;
mod recorder;
#[cfg(feature = "sqlite")]
mod sqlite;
mod writer;
