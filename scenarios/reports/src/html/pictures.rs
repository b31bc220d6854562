//! The snapshots of a run, inside the page.

use std::collections::BTreeSet;
use std::time::Duration;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD as BASE64;
use maud::{Markup, html};

use super::{markup, words};
use crate::report::SnapshotReport;

/// A snapshot with its PNG file.
#[derive(Clone, Debug)]
pub struct Picture {
    /// The report's entry for it.
    pub snapshot: SnapshotReport,
    /// The file.
    pub png: Vec<u8>,
}

/// The section with the pictures, all linked to their files. Those that fit into this many bytes are shown, early
/// events first. Empty if there are none.
pub(super) fn section(pictures: &[Picture], room: usize) -> Markup {
    let fitting = fitting(pictures, room);
    let in_time = || pictures.iter().enumerate();
    let shown: Vec<&Picture> = in_time().filter(|(place, _)| fitting.contains(place)).map(|(_, one)| one).collect();
    let hidden: Vec<&Picture> = in_time().filter(|(place, _)| !fitting.contains(place)).map(|(_, one)| one).collect();
    let figure = |Picture { snapshot, png }: &Picture| {
        let caption = caption(snapshot);
        let source = format!("data:image/png;base64,{}", BASE64.encode(png));
        html! {
            figure {
                a href=(snapshot.file) {
                    img src=(source) width="1600" height="900" alt=(caption) decoding="sync";
                }
                figcaption { (caption) }
            }
        }
    };
    let content = html! {
        @if !pictures.is_empty() {
            p.quiet { "Each picture links to its file beside this page, in full size." }
            div.pictures { @for picture in shown { (figure(picture)) } }
            @if !hidden.is_empty() {
                p { "Not shown here, to keep this page small:" }
                ul {
                    @for Picture { snapshot, .. } in hidden {
                        li { a href=(snapshot.file) { (snapshot.file) } ": " (caption(snapshot)) }
                    }
                }
            }
        }
    };
    markup::section("pictures", "Pictures", content)
}

/// The pictures that fit into this many bytes: those of events before those taken by the clock, each in order of time.
fn fitting(pictures: &[Picture], room: usize) -> BTreeSet<usize> {
    let mut order: Vec<usize> = (0..pictures.len()).collect();
    order.sort_by_key(|place| pictures[*place].snapshot.by_clock);
    let mut bytes = 0;
    let fits = |place: &usize| {
        // Four characters per three bytes, and the caption.
        bytes += pictures[*place].png.len().div_ceil(3) * 4 + 600;
        bytes <= room
    };
    order.into_iter().take_while(fits).collect()
}

fn caption(snapshot: &SnapshotReport) -> String {
    format!("{} · {}", words::time(Duration::from_secs_f64(snapshot.time_s)), snapshot.why)
}
