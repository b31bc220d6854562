//! The page as a browser sees it: who gets in, what a pilot can do, and how runs and recordings are shown.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

mod access;
mod browser;
mod partners;
mod recordings;
mod sessions;

use cockpit::Cockpit;
use runs::Session;
use scenarios::scenario::find;

use browser::Page;

/// Serves a page until the tests end.
fn served(cockpit: Cockpit) -> Page {
    let page = Page::new(&cockpit.address(), &cockpit.address_for_viewers());
    std::thread::spawn(move || cockpit.serve());
    page
}

/// A session of a scenario.
fn session(scenario: &str, seed: Option<u64>) -> Page {
    let found = find::find(scenario).unwrap();
    served(Cockpit::open(move || Session::new(&found, &[], seed), 0).unwrap())
}
