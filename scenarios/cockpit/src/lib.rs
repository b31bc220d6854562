//! Shows runs in a browser: a run that is going on, in which a person can intervene, and recordings of others.
//!
//! [`Cockpit::open`] starts a [session](runs::Session) on its own thread, and [`Cockpit::serve`] shows it
//! to browsers. The page gets what is in the run's records, and nothing else; whatever a person does there is an act of
//! the session. The session can therefore be saved as a scenario that gives the same run.
//!
//! If [partners](runs::Partners) take part, they set the pace: the session goes on as fast as they let it, unless the
//! page pauses it. While a step waits for them, the page still answers. What they did is not in a saved scenario.
//!
//! All records of a session go to a temporary file, from which the page can show the past. [`Cockpit::replay`] shows
//! recordings in the same way: it copies each one to such a file, as far as it has been written. [`Cockpit::follow`]
//! shows what a [`Feed`] sends. A [`Board`] shows the progress of a campaign.
//!
//! The run does not wait for browsers. A browser that is too slow misses frames, then gets the present state.
//!
//! # Who may see it
//!
//! The server listens on the loopback address only. The page and the socket need a secret token, which is part of the
//! printed address; there is one for the pilot and one for viewers. Requests must name the server's own address as
//! their host, and sockets must come from its own page: a page of another site, or one whose name resolves to this
//! address, gets nothing. The user's texts are escaped, and the page runs no scripts but its own.
//!
//! # Inside
//! A `runner` on its own thread takes records from a `Session` (`steered`), or from files that may still grow or a
//! `feed` (`open_recording`). Each run on the page is a `shown_run`: its `history` keeps all records in a
//! `RecordStore`, a temporary file, and a playback shows any moment of it. The `server` passes frames on to pages
//! (`broadcast`), and the pilot's actions back to the runner. A page gets what the records contain (`frame`), and the
//! report's own verdicts and charts (`html/live.rs` in `reports`). Each act is a fault at the current step, so a
//! session is always a scenario. Recordings beside each other are aligned and compared (`beside`). A `Board` shows the
//! progress of a campaign.

mod beside;
mod board;
mod broadcast;
mod clock;
mod command;
mod feed;
mod frame;
mod history;
mod moment;
mod open_recording;
mod runner;
mod server;
mod shown_run;
mod steered;
mod suggestions;

mod things;
mod token;

pub use board::{Board, Tally};
pub use feed::Feed;
pub use server::{Cockpit, Error};
