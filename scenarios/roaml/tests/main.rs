//! Tests of models and machines as files.

mod refused;
mod uc3;

use std::path::Path;

use roaml::Model;

fn load(path: &Path) -> Result<Model, String> {
    Model::load(path, &diagnostics::text_from_disk).map_err(|problems| problems.plain())
}
