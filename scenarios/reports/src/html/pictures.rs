//! The snapshots of a run, inside the page.

use std::time::Duration;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD as BASE64;

use super::markup::escape;
use super::words;
use crate::report::SnapshotReport;

/// Pictures beyond this many bytes are named, not shown: the page has to stay one that a phone can open.
const MOST_BYTES: usize = 8 << 20;

/// A snapshot with its PNG file.
#[derive(Clone, Debug)]
pub struct Picture {
    /// What the report says of it.
    pub snapshot: SnapshotReport,
    /// The file.
    pub png: Vec<u8>,
}

/// The section of the pictures; empty if there are none.
pub(super) fn section(pictures: &[Picture]) -> String {
    let mut room = MOST_BYTES;
    let mut shown = 0;
    let mut figures = String::new();
    for Picture { snapshot, png } in pictures {
        let Some(left) = room.checked_sub(png.len()) else { break };
        room = left;
        shown += 1;
        let caption = format!("{} · {}", words::time(Duration::from_secs_f64(snapshot.time_s)), snapshot.why);
        figures += &format!(
            "<figure><img src=\"data:image/png;base64,{}\" width=\"1600\" height=\"900\" alt=\"{1}\" decoding=\"sync\">\
             <figcaption>{1}</figcaption></figure>\n",
            BASE64.encode(png),
            escape(&caption),
        );
    }
    let hidden = pictures.len() - shown;
    if hidden > 0 {
        figures += &format!("<p class=\"quiet\">{} more lie beside this page.</p>\n", words::count(hidden, "picture"));
    }
    match pictures.is_empty() {
        true => String::new(),
        false => format!(
            "<section id=\"pictures\">\n<h2>Pictures</h2>\n<div class=\"pictures\">\n{figures}</div>\n</section>\n"
        ),
    }
}
