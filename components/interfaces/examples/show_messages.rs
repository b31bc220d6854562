//! Prints the messages between a component and its clients. In the crate's folder: `cargo run --example show_messages
//! -- examples/arm.toml`.

use std::error::Error;
use std::path::Path;

use diagnostics::from_disk;
use interfaces::Interface;

#[expect(clippy::print_stdout, reason = "an example prints its results")]
fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("which interface?")?;
    match Interface::load(Path::new(&path), &[], &from_disk) {
        Ok(interface) => {
            println!("to the component");
            interface.requests().iter().for_each(|shape| println!("  {shape}"));
            println!("to a client");
            interface.replies()?.iter().for_each(|shape| println!("  {shape}"));
        }
        Err(diagnostics::Error::Problems(problems)) => print!("{}", problems.plain()),
        Err(error) => return Err(error.into()),
    }
    Ok(())
}
