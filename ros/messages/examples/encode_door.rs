//! Reads the definition of a message, and encodes and decodes one: `cargo run --example encode_door -- FOLDER`, where
//! the folder contains the package `door_msgs`.

use std::path::{Path, PathBuf};

use ros_messages::{Decoder, Folders, Structure, TypeName, Value, Want};

#[expect(clippy::print_stdout, reason = "an example prints its results")]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let paths: Vec<PathBuf> = std::env::args_os().skip(1).map(PathBuf::from).collect();
    let folders = Folders { paths: &paths, read: &|path: &Path| diagnostics::from_disk(path) };
    let name = TypeName::new(Some("door_msgs"), "Door");
    let door = folders.layout(&name)?;
    println!("{}: {}", name.full(), door.type_hash());

    let stamp = Value::Message(vec![Value::Int(1_760_000_000), Value::Int(500_000_000)]);
    let hinge = |angle_rad| Value::Message(vec![Value::Real(angle_rad)]);
    let hinges = Value::List(vec![hinge(0.5), hinge(-0.25)]);
    let message = Value::Message(vec![stamp, Value::Text("kitchen".to_owned()), Value::Int(1), hinges]);
    let bytes = door.encode(&message)?;
    for row in bytes.chunks(16) {
        println!("  {}", row.iter().map(|byte| format!("{byte:02x}")).collect::<Vec<_>>().join(" "));
    }

    let decoded = Decoder::new(&door, &Want::All).decode(&bytes)?;
    let received = Structure::of(&door, &decoded).ok_or("it is a message")?;
    let angles: Vec<f64> = received.parts("hinges").iter().filter_map(|hinge| hinge.number("angle_rad")).collect();
    println!("door {:?}, state {:?}, hinges at {angles:?}", received.text("name"), received.number("state"));
    Ok(())
}
