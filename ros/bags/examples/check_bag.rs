//! Checks properties on a bag, as `steward verify` does: `check_bag BAG MAPPING PROPERTIES`.

#![expect(clippy::print_stdout, reason = "a program for manual use")]

use std::convert::Infallible;
use std::path::{Path, PathBuf};

use bags::{Bag, Events, Found, Mapping};
use channels::Monitor;
use diagnostics::{from_disk, text_from_disk};
use monitors::Outcome;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<PathBuf> = std::env::args_os().skip(1).map(PathBuf::from).collect();
    let [bag, mapping, properties] = arguments.as_slice() else {
        return Err("usage: check_bag BAG MAPPING PROPERTIES".into());
    };
    let read = |path: &Path| from_disk(path);
    let (bag, mapping) = (Bag::open(bag)?, Mapping::load(mapping, &read)?);
    let compiled = mapping.compile(bag.survey(), None, &read)?;
    let text = text_from_disk(properties)?;
    let mut file = monitors::load("properties", &text, &compiled.topology, mapping.tick)?;
    let mut events = Events::new(Box::new(bag.messages_on(mapping.topics())), &mapping, compiled, &read);
    let monitors = file.properties.iter_mut().map(|property| property.monitor.as_mut() as &mut dyn Monitor);
    let present = events.by_ref().filter_map(|found| match found {
        Found::Event(event) => Some(Ok::<_, Infallible>(event)),
        _ => None,
    });
    let Ok(end) = monitors::verify(present, monitors);
    println!("{} messages, {} ticks", end.messages, end.ticks);
    for property in &file.properties {
        println!("{} {}", property.name, Outcome::of(property.monitor.as_ref()));
    }
    events.notes().iter().for_each(|note| eprintln!("{note}"));
    Ok(())
}
