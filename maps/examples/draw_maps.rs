//! Draws the project's own maps into the crate's folder: `cargo run -p steward-maps --example draw_maps`.

use std::path::Path;

use maps::{ImageFormat, house, museum, save_map};

fn main() -> Result<(), maps::Error> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    save_map(&house::draw(), &folder.join(house::YAML_NAME), ImageFormat::Pgm)?;
    save_map(&museum::draw(), &folder.join(museum::YAML_NAME), ImageFormat::Pgm)
}
