//! A run in a browser while it goes on: what happens, and what a person does to it.
//!
//! [`Cockpit::open`] starts a [session](scenarios::session::Session) on a thread of its own, and
//! [`Cockpit::serve`] shows it to browsers. The page gets what the run's records say, and nothing else; what a person
//! does on it is an act of the session. So the session can be saved as a scenario that gives the same run.
//!
//! The run does not wait for browsers. A browser that is too slow misses frames and goes on with the present state.
//!
//! # Who may see it
//!
//! The server listens on the loopback address alone. Page and socket need a secret token, which is part of the printed
//! address; there is one for the pilot and one for viewers. Requests must name the server's own address as host, and
//! sockets must come from its own page: a page of another site, or one whose name is bound to this address, gets
//! nothing. Texts of the user are escaped, and no script runs on the page but its own.

mod command;
mod frame;
mod runner;
mod server;
mod things;
mod token;

pub use server::{Cockpit, Error};
