//! Pages in the browser.

use std::ffi::OsStr;

use crate::output::note;

/// Opens a page in the browser. A missing browser is not an error; a message reports it.
pub(crate) fn open(page: &(impl AsRef<OsStr> + ?Sized)) {
    let page = page.as_ref();
    if let Err(error) = opener::open_browser(page) {
        note(&format!("cannot open {} in a browser: {error}", page.display()));
    }
}
