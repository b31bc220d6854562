//! A sensor that counts people in view.

use skills::Datum;

use crate::Surroundings;
use crate::lines::Lines;

/// Lengths are in millimeters, so that states can be compared.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct People {
    within_mm: u32,
    only: Vec<String>,
    count: usize,
    nearest_mm: u32,
}

impl People {
    pub(crate) fn new(within_m: f64, only: &[String]) -> Self {
        let within_mm = millimeters(within_m);
        Self { within_mm, only: only.to_vec(), count: 0, nearest_mm: within_mm }
    }

    pub(crate) fn restart(&mut self) {
        self.count = 0;
        self.nearest_mm = self.within_mm;
    }

    pub(crate) fn look(&mut self, surroundings: &dyn Surroundings, is_blind: bool, lines: &mut Lines<'_>) {
        let distances = if is_blind { Vec::new() } else { surroundings.people_in_view(&self.only) };
        let distances = distances.into_iter().map(millimeters).filter(|distance_mm| *distance_mm <= self.within_mm);
        let distances: Vec<u32> = distances.collect();
        self.nearest_mm = distances.iter().copied().min().unwrap_or(self.within_mm);
        if self.count != distances.len() {
            self.count = distances.len();
            lines.publish("counted", [("count", self.count())]);
        }
    }

    pub(crate) fn handle(&self, client: &str, lines: &mut Lines<'_>) {
        let nearest_m = Datum::from(f64::from(self.nearest_mm) / 1000.0);
        lines.answer(client, [("count", self.count()), ("nearest_m", nearest_m)]);
    }

    fn count(&self) -> Datum {
        Datum::from(self.count as f64)
    }

    pub(crate) fn location(&self) -> String {
        match self.count {
            0 => "nobody".to_owned(),
            count => format!("{count} in view"),
        }
    }
}

fn millimeters(meters: f64) -> u32 {
    (meters * 1000.0).round() as u32
}
