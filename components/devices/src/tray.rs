//! A tray that carries a box.

use std::collections::VecDeque;

use skills::Datum;

use crate::Surroundings;
use crate::lines::Lines;

const NO_ROOM: &str = "there is no room for the box";

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Tray {
    /// The maximum distance of a box from the robot's edge, in millimeters, so that states can be compared.
    reach_mm: u32,
    /// Pending requests and their clients, in order.
    orders: VecDeque<(String, Order)>,
    /// The box that should be on it.
    load: Option<String>,
    /// Whether that box has fallen.
    is_gone: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Order {
    Take,
    Put,
}

impl Tray {
    pub(crate) fn new(reach_m: f64) -> Self {
        Self { reach_mm: (reach_m * 1000.0).round() as u32, orders: VecDeque::new(), load: None, is_gone: false }
    }

    pub(crate) fn restart(&mut self) {
        self.orders.clear();
    }

    pub(crate) fn handle(&mut self, request: &str, client: &str, lines: &mut Lines<'_>) {
        match request {
            "take" => self.orders.push_back((client.to_owned(), Order::Take)),
            "put" => self.orders.push_back((client.to_owned(), Order::Put)),
            _ => lines.answer(client, [("box", Datum::text(self.load.as_deref().unwrap_or_default()))]),
        }
    }

    pub(crate) fn act(&mut self, surroundings: &mut dyn Surroundings, lines: &mut Lines<'_>) {
        while let Some((client, order)) = self.orders.pop_front() {
            let done = match order {
                Order::Take => self.take(surroundings),
                Order::Put => self.put(surroundings),
            };
            match done {
                Ok(name) => lines.answer(&client, [("box", Datum::text(&name))]),
                Err(reason) => lines.refuse(&client, reason),
            }
        }
    }

    fn take(&mut self, surroundings: &mut dyn Surroundings) -> Result<String, &'static str> {
        if self.load.is_some() {
            return Err("there is already a box on the tray");
        }
        let name = surroundings.take_box(f64::from(self.reach_mm) / 1000.0).ok_or("there is no box in reach")?;
        self.load = Some(name.clone());
        Ok(name)
    }

    fn put(&mut self, surroundings: &mut dyn Surroundings) -> Result<String, &'static str> {
        let name = self.load.take().ok_or("there is no box")?;
        if std::mem::take(&mut self.is_gone) {
            return Err("the box is gone");
        }
        if surroundings.put_down(&name) {
            return Ok(name);
        }
        self.load = Some(name);
        Err(NO_ROOM)
    }

    pub(crate) fn drop_box(&mut self, surroundings: &mut dyn Surroundings) -> Result<(), &'static str> {
        let name = self.load.as_deref().filter(|_| !self.is_gone).ok_or("there is no box on the tray")?;
        self.is_gone = surroundings.drop_box(name);
        if self.is_gone { Ok(()) } else { Err(NO_ROOM) }
    }

    pub(crate) fn location(&self) -> String {
        self.load.as_ref().map_or_else(|| "empty".to_owned(), |name| format!("carries {name}"))
    }
}
