//! The plan of a small museum of about 12 m × 9 m, through which a robot guides visitors.
//!
//! ```text
//!  ┌────────────────┬──────────────┐
//!  │   paintings       sculptures  │      9 m
//!  │                │              │
//!  ├────────   ─────┼──────────────┤    4.5 m
//!  │ ▪ station      ╎              │
//!  │ desk    foyer  ╎   treasury   │
//!  └────────────────┴──────────────┘      0 m
//! ```
//!
//! The only way into the treasury is a door. The sculpture room and the treasury are dead ends, where the robot has to
//! get past its visitors.

use crate::pen::{Rect, rect};
use crate::plan::{Plan, Position};

pub(super) const MUSEUM: Plan = Plan {
    sheet: rect((-1.0, 13.0), (-1.0, 10.0)),
    rooms: &ROOMS,
    doorways: &DOORWAYS,
    slanted_wall: None,
    boxes: &BOXES,
    rounds: &ROUNDS,
    strokes: &STROKES,
};

const ROOMS: [Rect; 4] = [
    rect((0.0, 6.5), (0.0, 4.5)),    // foyer
    rect((0.0, 6.5), (4.65, 9.0)),   // paintings
    rect((6.65, 12.0), (4.65, 9.0)), // sculptures
    rect((6.65, 12.0), (0.0, 4.5)),  // treasury
];

const DOORWAYS: [Rect; 3] = [
    rect((2.6, 4.1), (4.5, 4.65)), // foyer – paintings
    rect((6.5, 6.65), (5.8, 7.3)), // paintings – sculptures
    rect((6.5, 6.65), (1.4, 2.7)), // foyer – treasury: the door
];

const BOXES: [Rect; 9] = [
    // Foyer: charger, desk, bench.
    rect((0.0, 0.25), (3.4, 3.8)),
    rect((0.0, 0.6), (0.6, 2.2)),
    rect((2.0, 3.2), (0.0, 0.35)),
    // Paintings: a bench, a partition, a cupboard.
    rect((2.4, 4.2), (6.7, 7.1)),
    rect((1.0, 1.15), (5.0, 6.4)),
    rect((5.3, 6.5), (8.6, 9.0)),
    // Sculptures: a square pedestal.
    rect((10.9, 11.5), (5.0, 5.6)),
    // Treasury: showcases.
    rect((8.6, 9.8), (2.1, 2.7)),
    rect((11.5, 12.0), (0.6, 3.6)),
];

const ROUNDS: [(Position, f64); 6] = [
    ((5.4, 3.6), 0.25), // foyer: a pillar, a plant
    ((0.4, 0.25), 0.2),
    ((8.2, 8.1), 0.35), // sculptures: pedestals
    ((10.6, 7.9), 0.35),
    ((9.4, 6.1), 0.4),
    ((7.2, 4.0), 0.25), // treasury: a column
];

const STROKES: [(Position, Position, f64); 2] = [
    ((5.0, 5.0), (5.5, 5.4), 0.1),   // paintings: an easel
    ((10.2, 3.9), (10.9, 4.2), 0.2), // treasury: a chest
];
