//! Components as processes: how they answer, and what outages do to them.

mod outages;
mod processes;
