//! The snapshots of a run, inside the page.

use std::time::Duration;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD as BASE64;
use maud::{Markup, html};

use super::{markup, words};
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
pub(super) fn section(pictures: &[Picture]) -> Markup {
    let mut bytes = 0;
    let fits = |picture: &&Picture| {
        bytes += picture.png.len();
        bytes <= MOST_BYTES
    };
    let (shown, hidden) = pictures.split_at(pictures.iter().take_while(fits).count());
    let figure = |Picture { snapshot, png }: &Picture| {
        let caption = format!("{} · {}", words::time(Duration::from_secs_f64(snapshot.time_s)), snapshot.why);
        let source = format!("data:image/png;base64,{}", BASE64.encode(png));
        html! {
            figure {
                img src=(source) width="1600" height="900" alt=(caption) decoding="sync";
                figcaption { (caption) }
            }
        }
    };
    let content = html! {
        @if !pictures.is_empty() {
            div.pictures {
                @for picture in shown { (figure(picture)) }
                @if !hidden.is_empty() {
                    p.quiet { (words::count(hidden.len(), "picture")) " more lie beside this page." }
                }
            }
        }
    };
    markup::section("pictures", "Pictures", content)
}
