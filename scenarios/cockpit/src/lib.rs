//! Runs in a browser: one while it goes on, with what a person does to it, and what was recorded of others.
//!
//! [`Cockpit::open`] starts a [session](scenarios::session::Session) on a thread of its own, and
//! [`Cockpit::serve`] shows it to browsers. The page gets what the run's records say, and nothing else; what a person
//! does on it is an act of the session. So the session can be saved as a scenario that gives the same run.
//!
//! All records of a session go to a temporary file, from which the page can show what was. [`Cockpit::replay`] shows
//! recordings in the same way: each is copied to such a file as far as it is written. A [`Board`] shows how many runs
//! of a campaign are done.
//!
//! The run does not wait for browsers. A browser that is too slow misses frames and goes on with the present state.
//!
//! # Who may see it
//!
//! The server listens on the loopback address alone. Page and socket need a secret token, which is part of the printed
//! address; there is one for the pilot and one for viewers. Requests must name the server's own address as host, and
//! sockets must come from its own page: a page of another site, or one whose name is bound to this address, gets
//! nothing. Texts of the user are escaped, and no script runs on the page but its own.

mod board;
mod clock;
mod command;
mod frame;
mod history;
mod moment;
mod outlet;
mod reel;
mod runner;
mod server;
mod side;
mod steered;
mod things;
mod token;

pub use board::{Board, Tally};
pub use server::{Cockpit, Error};
