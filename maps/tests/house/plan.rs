//! The plan of the house: rooms, doorways and furniture, in meters in the `map` frame, on the 0.05 m grid.

use crate::pen::{Rect, rect};
use crate::plan::{Plan, Position};

pub(super) const HOUSE: Plan = Plan {
    sheet: rect((-16.0, 14.0), (-6.0, 18.0)),
    rooms: &ROOMS,
    doorways: &DOORWAYS,
    slanted_wall: Some(SLANTED_WALL),
    boxes: &BOXES,
    rounds: &ROUNDS,
    strokes: &STROKES,
};

const ROOMS: [Rect; 17] = [
    rect((-14.85, 12.85), (5.6, 8.0)),     // the corridor
    rect((-12.4, -10.2), (8.0, 12.0)),     // its branch to the kitchen
    rect((-8.5, -6.5), (8.0, 10.0)),       // the niche with the charging station
    rect((-14.85, -9.25), (12.15, 16.85)), // kitchen
    rect((-14.85, -12.55), (8.15, 12.0)),  // broom closet
    rect((-9.1, -3.0), (10.15, 16.85)),    // bedroom, an L
    rect((-6.35, -3.0), (8.15, 10.15)),    // its other leg
    rect((-2.85, 3.4), (8.15, 12.8)),      // meeting room
    rect((-2.85, 3.4), (12.95, 16.85)),    // study
    rect((3.55, 12.85), (8.15, 16.85)),    // store
    rect((-14.85, -9.0), (0.05, 5.45)),    // workshop
    rect((-14.85, -6.6), (-4.85, -0.1)),   // cellar
    rect((-8.85, -4.2), (0.05, 5.45)),     // office
    rect((-6.45, -4.2), (-4.85, -0.1)),    // bath
    rect((-4.05, 6.3), (-4.85, 5.45)),     // living room
    rect((6.45, 12.85), (0.9, 5.45)),      // guest room
    rect((6.45, 12.85), (-4.85, 0.75)),    // dining room
];

const DOORWAYS: [Rect; 15] = [
    rect((-11.9, -10.7), (12.0, 12.15)), // branch – kitchen
    rect((-12.55, -12.4), (9.0, 10.1)),  // branch – broom closet
    rect((-5.4, -4.2), (8.0, 8.15)),     // corridor – bedroom
    rect((-3.0, -2.85), (14.6, 15.7)),   // bedroom – study
    rect((-1.6, -0.4), (8.0, 8.15)),     // corridor – meeting room
    rect((2.0, 3.1), (12.8, 12.95)),     // meeting room – study
    rect((6.5, 8.5), (8.0, 8.15)),       // corridor – store, a double door
    rect((-10.9, -9.7), (5.45, 5.6)),    // corridor – workshop
    rect((-13.6, -12.5), (-0.1, 0.05)),  // workshop – cellar
    rect((-6.2, -5.1), (5.45, 5.6)),     // corridor – office
    rect((-5.6, -4.5), (-0.1, 0.05)),    // office – bath
    rect((2.0, 3.2), (5.45, 5.6)),       // corridor – living room
    rect((6.3, 6.45), (-2.6, -1.4)),     // living room – dining room
    rect((9.6, 10.7), (5.45, 5.6)),      // corridor – guest room
    rect((11.4, 12.5), (0.75, 0.9)),     // guest room – dining room
];

/// Cuts off the upper right corner of the store.
const SLANTED_WALL: (Position, Position) = ((10.2, 16.85), (12.85, 13.8));

/// Furniture with straight sides.
const BOXES: [Rect; 53] = [
    // Corridor: pilasters, cupboards, a copier, a bench.
    rect((-9.2, -8.9), (5.6, 5.8)),
    rect((-3.9, -2.3), (5.6, 6.0)),
    rect((-0.1, 0.2), (7.8, 8.0)),
    rect((0.6, 1.7), (7.35, 8.0)),
    rect((4.2, 4.5), (5.6, 5.85)),
    rect((4.2, 4.5), (7.75, 8.0)),
    rect((5.4, 7.0), (5.6, 6.05)),
    rect((11.9, 12.85), (6.9, 8.0)),
    rect((-14.85, -14.55), (5.6, 6.9)),
    // The charger in its niche.
    rect((-8.5, -8.25), (8.8, 9.2)),
    // Kitchen: worktop, fridge, sideboard.
    rect((-14.85, -11.4), (16.25, 16.85)),
    rect((-14.85, -14.15), (15.3, 16.0)),
    rect((-9.75, -9.25), (13.6, 14.9)),
    // Broom closet: shelf, box.
    rect((-14.85, -14.4), (8.4, 11.6)),
    rect((-13.4, -12.75), (11.3, 11.9)),
    // Bedroom: bed, wardrobe, chest of drawers.
    rect((-9.1, -7.1), (15.2, 16.85)),
    rect((-6.0, -4.4), (16.25, 16.85)),
    rect((-3.35, -3.0), (9.6, 12.4)),
    // Meeting room: the table's middle, sideboard.
    rect((-1.0, 1.8), (10.0, 11.2)),
    rect((-2.85, -2.45), (8.6, 10.2)),
    // Study: desks, filing cabinet.
    rect((-2.85, -2.1), (13.0, 14.2)),
    rect((0.2, 1.8), (15.3, 16.05)),
    rect((2.9, 3.4), (14.4, 16.2)),
    // Store: shelves, crates by the door.
    rect((4.7, 5.1), (10.6, 15.2)),
    rect((6.6, 7.0), (11.2, 15.8)),
    rect((8.5, 8.9), (10.6, 14.2)),
    rect((3.55, 4.75), (8.15, 8.75)),
    rect((11.55, 12.85), (8.15, 9.35)),
    rect((12.25, 12.85), (9.35, 9.95)),
    // Workshop: bench, machine, tool cabinet.
    rect((-14.85, -14.15), (1.2, 4.6)),
    rect((-12.2, -10.9), (2.2, 3.4)),
    rect((-9.4, -9.0), (2.6, 4.4)),
    // Cellar: crates, shelf.
    rect((-10.6, -9.4), (-3.0, -1.8)),
    rect((-9.4, -8.7), (-2.5, -1.8)),
    rect((-14.6, -11.0), (-4.85, -4.4)),
    // Office: two desks, cupboard.
    rect((-8.85, -8.15), (1.0, 2.6)),
    rect((-4.9, -4.2), (1.2, 2.8)),
    rect((-8.2, -6.9), (5.05, 5.45)),
    // Bath: washbasin, a thin screen.
    rect((-6.45, -6.0), (-3.4, -2.4)),
    rect((-5.3, -5.25), (-4.85, -3.2)),
    // Living room: sofa, low table, dining table, shelf, desk, a thin screen, sideboard.
    rect((-4.05, -3.15), (-3.6, -1.2)),
    rect((-2.2, -1.5), (-2.9, -1.9)),
    rect((3.0, 4.8), (-2.4, -1.3)),
    rect((5.95, 6.3), (0.6, 3.4)),
    rect((-4.05, -3.35), (3.2, 4.8)),
    rect((-1.3, -1.25), (2.8, 5.45)),
    rect((-0.5, 1.3), (-4.85, -4.4)),
    // Guest room: beds, wardrobe.
    rect((6.45, 8.4), (4.1, 5.05)),
    rect((6.45, 8.4), (1.5, 2.45)),
    rect((12.25, 12.85), (2.4, 4.6)),
    // Dining room: table, sideboard, bench.
    rect((8.6, 10.8), (-3.2, -2.1)),
    rect((6.8, 9.6), (0.35, 0.75)),
    rect((11.6, 12.85), (-4.85, -4.2)),
];

/// Round furniture: center and radius.
const ROUNDS: [(Position, f64); 19] = [
    ((-14.45, 7.55), 0.3), // corridor: plant
    ((-1.0, 10.6), 0.6),   // meeting room: the table's ends
    ((1.8, 10.6), 0.6),
    ((-7.2, 12.4), 0.55), // bedroom: table
    ((11.0, 10.9), 0.25), // store: pillars
    ((11.0, 13.4), 0.25),
    ((-6.6, 1.7), 0.5),   // office: round table
    ((-2.3, -4.3), 0.35), // living room: armchair, lamp, column, chairs
    ((2.3, -4.4), 0.1),
    ((4.4, 2.4), 0.2),
    ((3.4, -0.9), 0.2),
    ((4.4, -0.95), 0.2),
    ((3.5, -2.85), 0.2),
    ((12.5, -0.9), 0.3), // dining room: plant, chairs
    ((9.2, -1.7), 0.2),
    ((10.2, -1.65), 0.2),
    ((9.7, -3.65), 0.2),
    ((11.25, -2.65), 0.2),
    ((-13.9, -0.9), 0.3), // cellar: boiler
];

/// Slanted furniture: a stroke from one point to the other and its width.
const STROKES: [(Position, Position, f64); 4] = [
    ((2.7, 8.9), (3.1, 9.9), 0.1),     // meeting room: flip chart
    ((-7.6, -4.2), (-7.0, -3.4), 0.4), // cellar: a board
    ((5.2, -4.4), (5.9, -3.7), 0.5),   // living room: piano
    ((-4.0, 13.1), (-3.5, 13.9), 0.3), // bedroom: armchair
];
