//! Pages in the browser.

use std::path::Path;

use crate::output::note;

/// Opens a page in the browser. A missing browser is not an error; a note says so.
pub(crate) fn open(page: &Path) {
    if let Err(error) = opener::open_browser(page) {
        note(&format!("cannot open {} in a browser: {error}", page.display()));
    }
}
