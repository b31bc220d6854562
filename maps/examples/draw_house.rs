//! Draws the project's own map into the crate's folder: `cargo run -p steward-maps --example draw_house`.

use std::path::Path;

use maps::{ImageFormat, house, save_map};

fn main() -> Result<(), maps::Error> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(house::YAML_NAME);
    save_map(&house::draw(), &path, ImageFormat::Pgm)
}
