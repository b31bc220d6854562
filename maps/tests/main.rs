//! The project's own maps, the house and the museum: their files are what is drawn from plans in meters, and keep the
//! properties that scenarios rely on.

mod house;
mod museum;
mod pen;
mod plan;
