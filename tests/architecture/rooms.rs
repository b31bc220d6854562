//! The crates of the workspace, called rooms, and which of them use which.

use std::collections::{BTreeMap, BTreeSet};

use super::crate_name;
use crate::workspace::metadata;

/// Each room with the packages that it depends on, also those behind features, by the names that the code uses.
/// Dependencies of tests and build scripts do not count.
pub(super) struct Rooms(BTreeMap<String, BTreeSet<String>>);

impl Rooms {
    /// The rooms of this workspace.
    pub(super) fn read() -> Self {
        let mut rooms = BTreeMap::new();
        for package in &metadata(&["--no-deps"]).packages {
            let used: BTreeSet<String> = package.normal_dependencies().map(crate_name).collect();
            rooms.insert(crate_name(&package.name), used);
        }
        Self(rooms)
    }

    pub(super) fn contains(&self, name: &str) -> bool {
        self.0.contains_key(name)
    }

    /// The rooms that depend on a package directly.
    pub(super) fn users(&self, package: &str) -> Vec<&str> {
        let users = self.0.iter().filter(|(_, used)| used.contains(package));
        users.map(|(room, _)| room.as_str()).collect()
    }

    /// The rooms that a room uses directly.
    fn used(&self, room: &str) -> Vec<&str> {
        self.0[room].iter().map(String::as_str).filter(|used| self.contains(used)).collect()
    }

    /// The rooms that a room uses, directly or through others.
    pub(super) fn reached(&self, room: &str) -> BTreeSet<&str> {
        let (mut open, mut found) = (self.used(room), BTreeSet::new());
        while let Some(next) = open.pop() {
            if found.insert(next) {
                open.extend(self.used(next));
            }
        }
        found
    }

    /// The floor of each room: how many rooms are on the longest way down, including itself.
    fn floors(&self) -> BTreeMap<&str, usize> {
        let mut rooms: Vec<&str> = self.0.keys().map(String::as_str).collect();
        // A room reaches more than each of the rooms that it uses, so these come first.
        rooms.sort_by_key(|room| self.reached(room).len());
        let mut floors: BTreeMap<&str, usize> = BTreeMap::new();
        for room in rooms {
            let below = self.used(room).into_iter().map(|used| floors[used]).max();
            floors.insert(room, below.unwrap_or_default() + 1);
        }
        floors
    }

    /// One line per room, the highest floor first: its floor, its name, and the rooms that it uses, except those that
    /// it reaches through others.
    pub(super) fn figure(&self) -> String {
        let floors = self.floors();
        let top = floors.values().copied().max().unwrap_or_default();
        let width = floors.keys().map(|room| room.len()).max().unwrap_or_default();
        let mut lines = Vec::new();
        for floor in (1..=top).rev() {
            let rooms = floors.iter().filter(|(_, of)| **of == floor).map(|(room, _)| *room);
            for (place, room) in rooms.enumerate() {
                let number = if place == 0 { floor.to_string() } else { String::new() };
                let through: BTreeSet<&str> = self.used(room).iter().flat_map(|used| self.reached(used)).collect();
                let uses: Vec<&str> = self.used(room).into_iter().filter(|used| !through.contains(used)).collect();
                lines.push(match &uses[..] {
                    [] => format!("{number:>2}  {room}"),
                    uses => format!("{number:>2}  {room:<width$} ─► {}", uses.join(", ")),
                });
            }
        }
        lines.join("\n")
    }
}
