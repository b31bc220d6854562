//! How values from other crates are written: as numbers, bit for bit.

use maps::{Cell, OccupancyGrid, Point, Pose, Shape};
use nalgebra::{Complex, Translation2, UnitComplex};

/// A pose as `[x, y, cos, sin]`: meters, and the heading's cosine and sine.
fn numbers(pose: &Pose) -> [f64; 4] {
    [pose.translation.x, pose.translation.y, pose.rotation.re, pose.rotation.im]
}

fn of_numbers([x, y, re, im]: [f64; 4]) -> Pose {
    // Not normalized again, so that the bits stay the same.
    Pose::from_parts(Translation2::new(x, y), UnitComplex::new_unchecked(Complex::new(re, im)))
}

fn byte(cell: Cell) -> u8 {
    match cell {
        Cell::Free => 0,
        Cell::Occupied => 1,
        Cell::Unknown => 2,
    }
}

fn of_byte(byte: u8) -> Option<Cell> {
    [Cell::Free, Cell::Occupied, Cell::Unknown].get(usize::from(byte)).copied()
}

#[derive(serde::Serialize, serde::Deserialize)]
#[serde(remote = "Shape")]
pub(crate) enum ShapeRecord {
    Disc { radius_m: f64 },
    Box { length_m: f64, width_m: f64 },
}

pub(crate) mod pose {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    use super::*;

    pub(crate) fn serialize<S: Serializer>(pose: &Pose, serializer: S) -> Result<S::Ok, S::Error> {
        numbers(pose).serialize(serializer)
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Pose, D::Error> {
        Deserialize::deserialize(deserializer).map(of_numbers)
    }
}

pub(crate) mod pose_if_any {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    use super::*;

    pub(crate) fn serialize<S: Serializer>(pose: &Option<Pose>, serializer: S) -> Result<S::Ok, S::Error> {
        pose.as_ref().map(numbers).serialize(serializer)
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<Pose>, D::Error> {
        Option::deserialize(deserializer).map(|pose| pose.map(of_numbers))
    }
}

pub(crate) mod point_if_any {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    use super::*;

    pub(crate) fn serialize<S: Serializer>(point: &Option<Point>, serializer: S) -> Result<S::Ok, S::Error> {
        point.map(|point| [point.x, point.y]).serialize(serializer)
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<Point>, D::Error> {
        Option::<[f64; 2]>::deserialize(deserializer).map(|point| point.map(Point::from))
    }
}

pub(crate) mod points {
    use serde::{Deserialize, Deserializer, Serializer};

    use super::*;

    pub(crate) fn serialize<S: Serializer>(points: &[Point], serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(points.iter().map(|point| [point.x, point.y]))
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<Point>, D::Error> {
        let points = Vec::<[f64; 2]>::deserialize(deserializer)?;
        Ok(points.into_iter().map(Point::from).collect())
    }
}

pub(crate) mod lasers {
    use std::time::Duration;

    use robot::LaserSpec;
    use serde::{Deserialize, Deserializer, Serializer};

    use super::*;

    /// Name; pose in `base_link`; angle of the first beam and angle between beams, in radians; number of beams; time
    /// between scans; shortest and longest range, in meters.
    type Plain = (String, [f64; 4], f64, f64, usize, Duration, f64, f64);

    pub(crate) fn serialize<S: Serializer>(lasers: &[LaserSpec], serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(lasers.iter().cloned().map(|laser| -> Plain {
            let LaserSpec { name, mount, angle_min_rad, angle_increment_rad, beams, period, range_min_m, range_max_m } =
                laser;
            (name, numbers(&mount), angle_min_rad, angle_increment_rad, beams, period, range_min_m, range_max_m)
        }))
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<LaserSpec>, D::Error> {
        let laser = |plain: Plain| {
            let (name, mount, angle_min_rad, angle_increment_rad, beams, period, range_min_m, range_max_m) = plain;
            let mount = of_numbers(mount);
            LaserSpec { name, mount, angle_min_rad, angle_increment_rad, beams, period, range_min_m, range_max_m }
        };
        Ok(Vec::deserialize(deserializer)?.into_iter().map(laser).collect())
    }
}

pub(crate) mod scans {
    use std::sync::Arc;
    use std::time::Duration;

    use robot::LaserScan;
    use serde::{Deserialize, Deserializer, Serializer};

    /// Time; the index of the laser; one range in meters per beam.
    type Plain = (Duration, usize, Vec<f32>);

    pub(crate) fn serialize<S: Serializer>(scans: &[Arc<LaserScan>], serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(scans.iter().map(|scan| (scan.time, scan.laser, &scan.ranges_m)))
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<Arc<LaserScan>>, D::Error> {
        let scan = |(time, laser, ranges_m): Plain| Arc::new(LaserScan { time, laser, ranges_m });
        Ok(Vec::deserialize(deserializer)?.into_iter().map(scan).collect())
    }
}

pub(crate) mod grid {
    use std::sync::Arc;

    use serde::de::Error;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    use super::*;

    /// Columns, rows, the side of a cell in meters, the pose of the corner of cell (0, 0), and the cells.
    type Plain = (usize, usize, f64, [f64; 4], Vec<u8>);

    pub(crate) fn serialize<S: Serializer>(map: &OccupancyGrid, serializer: S) -> Result<S::Ok, S::Error> {
        let cells = map.cells().iter().copied().map(byte).collect();
        let plain: Plain = (map.width(), map.height(), map.resolution_m(), numbers(&map.origin()), cells);
        plain.serialize(serializer)
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Arc<OccupancyGrid>, D::Error> {
        let (width, height, resolution_m, origin, cells) = Plain::deserialize(deserializer)?;
        let cells: Option<Vec<Cell>> = cells.into_iter().map(of_byte).collect();
        let cells = cells.filter(|cells| Some(cells.len()) == width.checked_mul(height));
        let cells = cells.ok_or_else(|| D::Error::custom("a map must have one cell per column and row"))?;
        Ok(Arc::new(OccupancyGrid::from_cells(width, height, resolution_m, of_numbers(origin), cells)))
    }
}

pub(crate) mod topology {
    use std::sync::Arc;

    use channels::{Capacity, Domain, ProcessId, Shape, Topology};
    use serde::de::Error;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    /// A name, the index of the parent process, whether it is outside the system, and its other names.
    type Process = (String, usize, bool, Vec<String>);

    /// Processes. Channels: the indices of sender and receiver, whether they are synchronous, and the messages that may
    /// pass. Topics: the index of the publisher, and the messages.
    type Plain = (Vec<Process>, Vec<(usize, usize, bool, Domain)>, Vec<(usize, Shape)>);

    pub(crate) fn serialize<S: Serializer>(topology: &Topology, serializer: S) -> Result<S::Ok, S::Error> {
        let process = |id: ProcessId| {
            let (name, whole) = (topology.name(id).to_owned(), topology.whole(id).index());
            (name, whole, topology.is_outside(id), topology.other_names(id).to_vec())
        };
        let channels = topology.channels().map(|id| {
            let channel = topology.get(id);
            let handshake = channel.capacity == Capacity::Zero;
            (channel.source.index(), channel.target.index(), handshake, channel.domain.clone())
        });
        let topics =
            topology.processes().flat_map(|id| topology.topics(id).map(move |topic| (id.index(), topic.clone())));
        let plain: Plain = (topology.processes().map(process).collect(), channels.collect(), topics.collect());
        plain.serialize(serializer)
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Arc<Topology>, D::Error> {
        let (processes, channels, topics) = Plain::deserialize(deserializer)?;
        let mut topology = Topology::default();
        let mut ids: Vec<ProcessId> = Vec::new();
        let unknown = || D::Error::custom("a process that does not exist");
        for (place, (name, whole, is_outside, other_names)) in processes.into_iter().enumerate() {
            let declared = match ids.get(whole) {
                Some(whole) => topology.member(*whole, &name),
                None if whole == place && is_outside => topology.outside(&name),
                None if whole == place => topology.process(&name),
                None => return Err(unknown()),
            };
            let process = declared.map_err(D::Error::custom)?;
            topology.call(process, other_names);
            ids.push(process);
        }
        let end = |place: usize| ids.get(place).copied().ok_or_else(unknown);
        for (source, target, handshake, domain) in channels {
            let capacity = if handshake { Capacity::Zero } else { Capacity::One };
            topology.channel(end(source)?, end(target)?, capacity, domain).map_err(D::Error::custom)?;
        }
        for (publisher, topic) in topics {
            topology.publish(end(publisher)?, topic);
        }
        Ok(Arc::new(topology))
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use channels::{Capacity, Domain, FieldKind, Role, Shape, Topology};
    use serde::{Deserialize, Serialize};

    use super::*;

    #[derive(Debug, Serialize, Deserialize)]
    struct All {
        #[serde(with = "pose")]
        pose: Pose,
        #[serde(with = "points")]
        points: Vec<Point>,
        #[serde(with = "grid")]
        map: Arc<OccupancyGrid>,
        #[serde(with = "topology")]
        topology: Arc<Topology>,
    }

    fn all() -> All {
        let mut topology = Topology::default();
        let tree = topology.process("BT").unwrap();
        let root = topology.member(tree, "BT.0").unwrap();
        let leaf = topology.process("BatteryLevel").unwrap();
        let answers = Domain::new([Shape::new([("level", FieldKind::Optional(Box::new(FieldKind::Real)))])]);
        topology.channel(leaf, root, Capacity::Zero, answers.clone()).unwrap();
        topology.channel(tree, leaf, Capacity::One, answers.clone()).unwrap();
        let [world, monitors] = ["World", "Monitors"].map(|name| topology.outside(name).unwrap());
        topology.channel(world, monitors, Capacity::Zero, answers.clone()).unwrap();
        topology.publish(leaf, Shape::new([("topic", FieldKind::symbols(["news"]))]).with_role(Role::Topic));
        topology.call(leaf, vec!["Main/BatteryLevel".to_owned(), "BatteryLevel".to_owned()]);
        let cells = vec![Cell::Free, Cell::Occupied, Cell::Unknown, Cell::Free, Cell::Free, Cell::Occupied];
        // The bits stay the same even if the rotation is not quite normalized.
        let pose = of_numbers([-0.0, 0.1 + 0.2, 1.0 + f64::EPSILON, 1e-300]);
        All {
            pose,
            points: vec![Point::new(f64::NAN, f64::MIN_POSITIVE / 2.0), Point::new(f64::INFINITY, -1.5)],
            map: Arc::new(OccupancyGrid::from_cells(3, 2, 0.05, pose, cells)),
            topology: Arc::new(topology),
        }
    }

    #[test]
    fn values_are_read_back_bit_for_bit() {
        let written = all();
        let bytes = postcard::to_allocvec(&written).unwrap();
        let read: All = postcard::from_bytes(&bytes).unwrap();
        assert_eq!(postcard::to_allocvec(&read).unwrap(), bytes);
        assert_eq!(numbers(&read.pose).map(f64::to_bits), numbers(&written.pose).map(f64::to_bits));
        assert_eq!(read.points[0].x.to_bits(), f64::NAN.to_bits());
        assert_eq!((read.map, read.topology), (written.map, written.topology));
    }

    #[test]
    fn inconsistent_data_is_refused() {
        let bytes = postcard::to_allocvec(&(3_usize, 2_usize, 0.05, [0.0_f64; 4], vec![0_u8; 5])).unwrap();
        let read = grid::deserialize(&mut postcard::Deserializer::from_bytes(&bytes));
        assert!(read.is_err(), "a cell is missing");
        let processes: Vec<(usize, usize, bool, Domain)> = vec![(0, 1, false, Domain::new([]))];
        let topics: Vec<(usize, Shape)> = Vec::new();
        let bytes =
            postcard::to_allocvec(&(vec![("BT".to_owned(), 0_usize, false, Vec::<String>::new())], processes, topics))
                .unwrap();
        let read = topology::deserialize(&mut postcard::Deserializer::from_bytes(&bytes));
        assert!(read.is_err(), "there is one process");
    }
}
