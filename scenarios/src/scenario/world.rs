//! The contents of a scenario's world besides walls: people, doors and boxes.

use std::sync::Arc;
use std::time::Duration;

use diagnostics::document::{Field, FromItem, Item, Key, Table};
use diagnostics::{Problem, Spanned};
use maps::{Cell, OccupancyGrid, Point, Pose, Shape, pose};
use serde_json::{Value, json};
use sim::{Door, Follow, Manners, ObstacleConfig, ObstacleMotion, Opening, Pauses, RouteEnd, Walk};

use crate::coordinates::{POINT, POSE, points};
use crate::error::Complaints;
use crate::faults::Fault;
use crate::names::unknown;

/// The key of the map, which everything about the robot needs.
pub(super) const MAP: &str = "map";

/// Thickness of a door's leaf, in meters. Chosen, not measured.
const LEAF_M: f64 = 0.06;

/// Distance between the points of a route that are checked, in meters: the resolution of the shipped maps.
const LOOK_M: f64 = 0.05;

/// A person, a door or a box, with its location in the file.
pub type WorldBody = Spanned<ObstacleConfig>;

/// Reads `[[people]]`, `[[doors]]` and `[[boxes]]`; their names must be unique.
pub(super) fn read_world(root: Table<'_>) -> Vec<WorldBody> {
    let people = root.tables("people").rules(kinds_of_people);
    let people = people.about("A person who stands, walks along a route, or with `follows` follows the robot.");
    let doors = root.tables("doors").about("A door, which never closes onto the robot.");
    let boxes = root.tables("boxes").about("A box that is not on the map.");
    let mut bodies = read_each(people, "person", read_person);
    bodies.extend(read_each(doors, "door", read_door));
    bodies.extend(read_each(boxes, "box", read_box));
    for (index, body) in bodies.iter().enumerate() {
        if bodies[..index].iter().any(|other| other.value.name == body.value.name) {
            let problem = body.span.problem(format!("there are two bodies named `{}`", body.value.name));
            let help = "people, doors and boxes need different names";
            root.report(problem.with_label("the second one").with_help(help));
        }
    }
    bodies
}

/// Reads the tables. One without a name is named after its kind and number.
fn read_each(
    tables: Field<'_, Vec<Table<'_>>>,
    what: &str,
    read: impl Fn(Table<'_>) -> Option<(Shape, Pose, ObstacleMotion)>,
) -> Vec<WorldBody> {
    let mut number = 0;
    let about = format!("The name in reports. If not given, `{what} 1`, `{what} 2`, …");
    let bodies = tables.needs(MAP).each(|table| {
        number += 1;
        let name = table.text("name").about(&about).filled("not be empty").or(format!("{what} {number}"));
        let (shape, pose, motion) = read(table)?;
        Some(Spanned { value: ObstacleConfig { name, shape, pose, motion }, span: table.span().clone() })
    });
    bodies.or(Vec::new())
}

fn read_person(table: Table<'_>) -> Option<(Shape, Pose, ObstacleMotion)> {
    let at = table.get::<[f64; 2]>("at").about("The person's initial position.").words(POINT).required();
    let radius_m = table.number("radius_m").about("Radius of the body, in meters.").within(0.05..=1.0).default(0.25);
    let speed_mps = table
        .number("speed_mps")
        .about("Walking speed, in meters per second; the maximum speed of a person who follows the robot.");
    let speed_mps = speed_mps.within(0.05..=3.0).default(0.8);
    let follows = table
        .boolean("follows")
        .about("Whether the person follows the robot after meeting it. Such a person has no `route`.");
    let follows = follows.default(false);
    let walk = table.form(!follows).map(|table| ObstacleMotion::Person(read_walk(table, speed_mps)));
    let follow = table.form(follows).map(|table| ObstacleMotion::Follower(read_follow(table, speed_mps)));
    let [x, y] = at?;
    Some((Shape::Disc { radius_m }, pose(x, y, 0.0), walk.or(follow)?))
}

/// Which keys belong to a person that follows the robot, and which do not.
fn kinds_of_people() -> Value {
    let names = |keys: Vec<Key>| keys.into_iter().map(|key| key.path).collect::<Vec<_>>();
    let walking = names(Key::all(|table| read_walk(table, 0.0)));
    let following = names(Key::all(|table| read_follow(table, 0.0)));
    let mut of_followers = vec!["name".to_owned()];
    of_followers.extend(names(Key::all(read_person)).into_iter().filter(|key| !walking.contains(key)));
    json!({
        "if": { "required": ["follows"], "properties": { "follows": { "const": true } } },
        "then": { "propertyNames": { "enum": of_followers } },
        "else": { "propertyNames": { "not": { "enum": following } } },
    })
}

fn read_follow(table: Table<'_>, speed_mps: f64) -> Follow {
    if let Some((_, route)) = table.keys().find(|(key, _)| *key == "route") {
        table.know("route");
        let problem = route.problem("a person who follows the robot cannot have a route");
        table.report(problem.with_label("this route").with_help("leave out either `route` or `follows`"));
    }
    let defaults = Follow::default();
    let meters = |key, about, default| table.number(key).about(about).within(0.1..=20.0).default(default);
    Follow {
        distance_m: meters(
            "distance_m",
            "With `follows`: the distance that the person keeps from the robot's center, in meters.",
            defaults.distance_m,
        ),
        meets_within_m: meters(
            "meets_within_m",
            "With `follows`: the maximum distance from the robot's center at which they meet, in meters. Nothing may \
             be between them.",
            defaults.meets_within_m,
        ),
        speed_mps,
        stands: read_intervals(
            table,
            "stands_s",
            "With `follows`: when the person stands still and falls behind, in seconds. `[from]` lasts to the end of \
             the run.",
        ),
    }
}

fn read_walk(table: Table<'_>, speed_mps: f64) -> Walk {
    let waypoints = table
        .get::<Vec<[f64; 2]>>("route")
        .rules(points)
        .about("The points to which the person walks, each in a straight line. Without any, the person stands still.");
    let waypoints = waypoints.or_empty();
    let ends = [("back", RouteEnd::BackAndForth), ("around", RouteEnd::Loop), ("stop", RouteEnd::Stop)];
    let end = table
        .one_of("then", &ends)
        .about("At the end of the route: walk it `back`, go `around` to its beginning, or `stop`.");
    let end = end.or_first(&ends);
    let seconds = |key, about, default| table.seconds(key).about(about).default(default);
    let sets_out = seconds("sets_out_s", "The time at which the person sets out, in seconds.", Duration::ZERO);
    let pause = seconds("pause_s", "How long the person pauses, in seconds.", Duration::ZERO);
    let places = [("waypoints", Pauses::Waypoints), ("ends", Pauses::Ends)];
    let pauses = table
        .one_of("pauses", &places)
        .about("Where the person pauses: at every point of the route, or only at its `ends`.");
    let pauses = pauses.or_first(&places);
    let gives_way = table.boolean("gives_way").about("Whether the person waits for the robot, or walks into it.");
    let gives_way = gives_way.default(true);
    let defaults = Manners::default();
    let patience = seconds(
        "patience_s",
        "After this time, in seconds, a blocked person steps aside to clear the robot's path, or turns back.",
        defaults.patience,
    );
    Walk {
        waypoints: waypoints.into_iter().map(|[x, y]| Point::new(x, y)).collect(),
        speed_mps,
        end,
        sets_out,
        pause,
        pauses,
        manners: gives_way.then_some(Manners { patience, ..defaults }),
    }
}

fn read_door(table: Table<'_>) -> Option<(Shape, Pose, ObstacleMotion)> {
    let at = read_pose(table, "The middle of the closed door.");
    let length_m = table.number("width_m").about("Its width, in meters.").within(0.1..=20.0).default(1.0);
    let openings = [("slide", Opening::Slide), ("left", Opening::Left), ("right", Opening::Right)];
    let opening = table.one_of("opens", &openings).about("How it opens: it slides, or swings to one side.");
    let opening = opening.or_first(&openings);
    let moving = table.seconds("moves_s").about("How long it takes to open or close, in seconds.");
    let moving = moving.default(Duration::from_secs(2));
    let about = "When it is closed, in seconds. `[from]` lasts to the end of the run.";
    let closed = read_intervals(table, "closed_s", about);
    let every = table.seconds("every_s").above_0();
    let every = every.about("The time after which `closed_s` repeats, in seconds. Without it, it never does.");
    let door = Door { opening, moving, closed, every: every.optional() };
    Some((Shape::Box { length_m, width_m: LEAF_M }, at?, ObstacleMotion::Door(door)))
}

fn read_intervals(table: Table<'_>, key: &str, about: &str) -> Vec<(Duration, Duration)> {
    let intervals = table.get::<Vec<Interval>>(key).about(about).words("[[from, to], …] in seconds").or_empty();
    intervals.into_iter().map(|Interval(from, to)| (from, to)).collect()
}

/// A time interval; it lasts until the end if only the beginning is given.
struct Interval(Duration, Duration);

impl FromItem<'_> for Interval {
    fn wanted() -> String {
        <Vec<f64>>::wanted()
    }

    fn takes() -> Value {
        json!({ "type": "array", "items": { "type": "number", "minimum": 0 }, "minItems": 1, "maxItems": 2 })
    }

    fn from_item(item: &Item<'_>) -> Result<Self, Vec<Problem>> {
        let time = |seconds: f64| Duration::try_from_secs_f64(seconds).ok();
        let interval = match item.get::<Vec<f64>>()?.as_slice() {
            [from] => time(*from).map(|from| Self(from, Duration::MAX)),
            [from, to] if from < to => time(*from).zip(time(*to)).map(|(from, to)| Self(from, to)),
            _ => None,
        };
        interval.ok_or_else(|| {
            let problem = item.span().problem("this is not a time interval");
            let help = "write `[from, to]` in seconds, the second later than the first; or `[from]`, until the end of \
                        the run";
            vec![problem.with_help(help)]
        })
    }
}

fn read_box(table: Table<'_>) -> Option<(Shape, Pose, ObstacleMotion)> {
    let at = read_pose(table, "The middle of the box.");
    let number = |key, about, range, default| table.number(key).about(about).within(range).default(default);
    let length_m = number("length_m", "Length, in meters.", 0.05..=20.0, 0.6);
    let width_m = number("width_m", "Width, in meters.", 0.05..=20.0, 0.4);
    let mass_kg = number("mass_kg", "Mass, in kilograms.", 0.1..=1000.0, 10.0);
    let fixed = table.boolean("fixed").about("Whether it stays where it is. Otherwise, the robot can push it.");
    let motion = if fixed.default(false) { ObstacleMotion::Fixed } else { ObstacleMotion::Movable { mass_kg } };
    Some((Shape::Box { length_m, width_m }, at?, motion))
}

/// `at`: x and y in meters, and a heading in degrees.
fn read_pose(table: Table<'_>, about: &str) -> Option<Pose> {
    let at = table.get::<[f64; 3]>("at").about(about).words(POSE).required();
    at.map(|[x, y, degrees]| pose(x, y, degrees.to_radians()))
}

/// Checks that people walk on free floor, and that everything is on the map.
pub(super) fn check_world(bodies: &[WorldBody], map: &OccupancyGrid, complaints: &mut Complaints) {
    for Spanned { value: body, span } in bodies {
        let at = Point::from(body.pose.translation.vector);
        let mut complain = |message: String, help: &str| {
            complaints.push(span.problem(message).with_label("this one").with_help(help));
        };
        if map.index_of(&at).is_none() {
            complain(
                format!("`{}` is outside the map, at {at}", body.name),
                "x and y are in meters, in the map's frame",
            );
            continue;
        }
        if let (ObstacleMotion::Follower(_), Shape::Disc { radius_m }) = (&body.motion, body.shape)
            && !map.has_room(&at, radius_m)
        {
            let message = format!("`{}` has no room at {at}, with a radius of {radius_m} m", body.name);
            complain(message, "the whole body of a person who follows the robot must be on free floor");
        }
        let ObstacleMotion::Person(walk) = &body.motion else { continue };
        // A person without a route has one corner and no legs: whether the start is free is checked afterwards.
        let closes = walk.end == RouteEnd::Loop && walk.waypoints.len() > 1;
        let again = walk.waypoints.first().filter(|_| closes);
        let corners: Vec<Point> =
            std::iter::once(at).chain(walk.waypoints.iter().copied()).chain(again.copied()).collect();
        if let Some(wall) = corners.windows(2).find_map(|leg| first_wall(map, &leg[0], &leg[1])) {
            let message =
                format!("the route of `{}` leads through a wall at ({:.2}, {:.2})", body.name, wall.x, wall.y);
            complain(message, "a route is straight between its points: add corners");
        } else if first_wall(map, &at, &at).is_some() {
            complain(format!("`{}` is in a wall", body.name), "people must be on free floor");
        }
    }
}

/// Checks that the doors that faults name exist.
pub(super) fn check_doors(faults: &[Arc<Fault>], bodies: &[WorldBody], complaints: &mut Complaints) {
    for door in faults.iter().filter_map(|fault| fault.door()) {
        if !doors(bodies).any(|known| known == door.value) {
            complaints.push(unknown("door", &door, doors(bodies)));
        }
    }
}

pub(super) fn doors(bodies: &[WorldBody]) -> impl Iterator<Item = &str> {
    named(bodies, |motion| matches!(motion, ObstacleMotion::Door(_)))
}

pub(super) fn people(bodies: &[WorldBody]) -> impl Iterator<Item = &str> {
    named(bodies, |motion| matches!(motion, ObstacleMotion::Person(_) | ObstacleMotion::Follower(_)))
}

fn named(bodies: &[WorldBody], is_wanted: fn(&ObstacleMotion) -> bool) -> impl Iterator<Item = &str> {
    let bodies = bodies.iter().map(|body| &body.value);
    bodies.filter(move |body| is_wanted(&body.motion)).map(|body| body.name.as_str())
}

/// Where a line first meets a wall, or leaves the map.
fn first_wall(map: &OccupancyGrid, from: &Point, to: &Point) -> Option<Point> {
    let looks = ((to - from).norm() / LOOK_M).ceil().max(1.0) as usize;
    let places = (0..=looks).map(|look| from + (to - from) * (look as f64 / looks as f64));
    let is_wall =
        |at: &Point| map.index_of(at).and_then(|index| map.cell(index)).is_none_or(|cell| cell == Cell::Occupied);
    places.into_iter().find(is_wall)
}

#[cfg(test)]
mod tests {
    use super::super::{Scenario, find};
    use crate::Error;

    /// The problems of the errand in a world with this addition.
    fn problems(world: &str) -> String {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("world.toml");
        std::fs::write(&path, format!("base = \"scenarios/errand.toml\"\n{world}")).unwrap();
        let found = find::find(path.to_str().unwrap()).unwrap();
        match Scenario::load(&found, &[]) {
            Ok(_) => String::new(),
            Err(Error::BadInput(diagnostics)) => diagnostics.iter().map(|one| in_words(one.as_ref())).collect(),
            Err(other) => other.to_string(),
        }
    }

    /// A diagnostic with all its parts, one per line.
    fn in_words(diagnostic: &dyn miette::Diagnostic) -> String {
        let parts: Vec<String> =
            diagnostic.related().into_iter().flatten().map(|problem| format!("{problem}\n")).collect();
        if parts.is_empty() { format!("{diagnostic}\n") } else { parts.concat() }
    }

    #[test]
    fn people_doors_and_boxes_are_read_with_their_defaults() {
        assert_eq!(
            problems("[[people]]\nat = [-3.0, 6.4]\n[[doors]]\nat = [-11.3, 12.1, 0]\n[[boxes]]\nat = [-3.0, 6.6, 0]"),
            ""
        );
    }

    #[test]
    fn all_errors_are_reported_at_once() {
        let reported = problems(
            "[[people]]\nname = \"Ann\"\nat = [-3.0, 6.4]\nspeed_mps = 9\nrout = [[1, 2]]\n\
             [[boxes]]\nname = \"Ann\"\nat = [-3.0, 6.6, 0]\n[[doors]]\nat = [-11.3, 12.1, 0]\nclosed_s = [[5, 2]]",
        );
        for part in ["speed_mps", "rout", "not a time interval"] {
            assert!(reported.contains(part), "{part}: {reported}");
        }
    }

    #[test]
    fn a_follower_has_no_route_and_needs_room() {
        let ann = "[[people]]\nname = \"Ann\"\nfollows = true\nat = ";
        let follows = "\ndistance_m = 1.5\nmeets_within_m = 3\nspeed_mps = 1\nstands_s = [[60, 90], [120]]";
        assert_eq!(problems(&format!("{ann}[-3.0, 6.4]{follows}")), "");
        let both = problems(&format!("{ann}[-3.0, 6.4]\nroute = [[-5.0, 6.4]]"));
        assert_eq!(both, "a person who follows the robot cannot have a route\n");
        let walks = problems(&format!("{ann}[-3.0, 6.4]\npause_s = 3"));
        assert!(walks.starts_with("unknown key `pause_s`"), "{walks}");
        let stands = problems("[[people]]\nat = [-3.0, 6.4]\nstands_s = [[60, 90]]");
        assert!(stands.starts_with("unknown key `stands_s`"), "{stands}");
        let narrow = problems(&format!("{ann}[-3.0, 8.0]\nradius_m = 0.9"));
        assert!(narrow.contains("`Ann` has no room at"), "{narrow}");
    }

    #[test]
    fn nobody_walks_through_walls_or_off_the_map() {
        let through = problems("[[people]]\nat = [-3.0, 6.4]\nroute = [[-3.0, 60.0]]");
        assert!(through.contains("leads through a wall"), "{through}");
        let off = problems("[[boxes]]\nat = [900.0, 6.6, 0]");
        assert!(off.contains("outside the map"), "{off}");
        let twice =
            problems("[[people]]\nname = \"Ann\"\nat = [-3.0, 6.4]\n[[boxes]]\nname = \"Ann\"\nat = [-5.0, 6.6, 0]");
        assert!(twice.contains("two bodies named `Ann`"), "{twice}");
    }
}
