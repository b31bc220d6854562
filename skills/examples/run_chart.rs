//! Runs your own state chart: `cargo run --example run_chart`.
//!
//! The chart is that of a door lock. Time is simulated, so a minute passes at once.

use std::time::Duration;

use skills::{Chart, Datum, Event, Host, Machine, Note, Outgoing, Undelivered};

const LOCK: &str = include_str!("DoorLock.scxml");

/// The typed digits and their times, in seconds.
const TYPED: [(u64, f64); 6] = [(1, 4711.0), (10, 1.0), (11, 2.0), (12, 3.0), (13, 4711.0), (80, 4711.0)];

/// The world around the chart: receives what it sends and follows its state.
struct Hall {
    now: Duration,
}

#[expect(clippy::print_stdout, reason = "an example that prints to the terminal")]
impl Hall {
    fn say(&self, what: &str) {
        println!("{:3} s  {what}", self.now.as_secs());
    }
}

impl Host for Hall {
    fn send(&mut self, outgoing: &Outgoing) -> Result<(), Undelivered> {
        match (outgoing.target.as_deref(), outgoing.event.as_deref()) {
            (Some("Bolt"), Some(event)) => {
                self.say(&format!("the bolt: {event}"));
                Ok(())
            }
            (target, _) => Err(Undelivered::Unfit(format!("there is no target {target:?}"))), // `error.communication` in the chart
        }
    }

    fn note(&mut self, note: Note) {
        match note {
            Note::Log { label, text } => self.say(&format!("{label}: {text}")),
            other => self.say(&format!("{other:?}")),
        }
    }

    fn entered(&mut self, machine: &Machine) {
        self.say(&machine.active_ids().collect::<Vec<_>>().join(", "));
    }
}

impl Hall {
    /// Lets time pass. Delayed events arrive exactly when they are due.
    fn wait(&mut self, machine: &mut Machine, until: Duration) {
        while let Some(due) = machine.next_timer().filter(|due| *due <= until) {
            self.now = due;
            machine.fire_timers(due, self);
        }
        self.now = until;
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut machine = Machine::new(Chart::load("DoorLock.scxml", LOCK)?);
    let mut hall = Hall { now: Duration::ZERO };
    machine.start(hall.now, &mut hall);
    for (second, digits) in TYPED {
        hall.wait(&mut machine, Duration::from_secs(second));
        hall.say(&format!("somebody types {digits}"));
        let data = Datum::object([("digits", Datum::from(digits))])?;
        machine.handle(Event::external("code").with_data(data), hall.now, &mut hall);
    }
    hall.wait(&mut machine, Duration::from_secs(100));
    Ok(())
}
