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

/// The pictures of a page, all linked to their files. Those that fit into a number of bytes are shown, those of
/// violations first.
pub(super) struct Album<'p> {
    pictures: &'p [Picture],
    fitting: BTreeSet<usize>,
}

impl<'p> Album<'p> {
    pub(super) fn new(pictures: &'p [Picture], room: usize) -> Self {
        let mut order: Vec<usize> = (0..pictures.len()).collect();
        // Events before what was taken by the clock, each in order of time.
        order.sort_by_key(|place| (pictures[*place].snapshot.violated.is_none(), pictures[*place].snapshot.by_clock));
        let mut bytes = 0;
        let fits = |place: &usize| {
            // Four characters per three bytes, and the caption.
            bytes += pictures[*place].png.len().div_ceil(3) * 4 + 600;
            bytes <= room
        };
        Self { pictures, fitting: order.into_iter().take_while(fits).collect() }
    }

    /// The picture of the violation of this property; empty if there is none.
    pub(super) fn violation(&self, property: &str) -> Markup {
        let picture = self.pictures.iter().position(|one| one.snapshot.violated.as_deref() == Some(property));
        html! {
            @if let Some(place) = picture {
                @let picture = &self.pictures[place];
                @if self.fitting.contains(&place) { (figure(picture)) }
                @else { p { "Picture: " (link(picture)) } }
            }
        }
    }

    /// The section with the other pictures; empty if there are none.
    pub(super) fn section(&self) -> Markup {
        let others = || self.pictures.iter().enumerate().filter(|(_, one)| one.snapshot.violated.is_none());
        let (shown, hidden): (Vec<_>, Vec<_>) = others().partition(|(place, _)| self.fitting.contains(place));
        let content = html! {
            @if others().next().is_some() {
                @if !shown.is_empty() {
                    p.quiet { "Each picture links to its file beside this page, in full size." }
                }
                div.pictures { @for (_, picture) in shown { (figure(picture)) } }
                @if !hidden.is_empty() {
                    p { "Not shown here, to keep this page small:" }
                    ul { @for (_, picture) in hidden { li { (link(picture)) } } }
                }
            }
        };
        markup::section("pictures", "Pictures", content)
    }
}

fn figure(Picture { snapshot, png }: &Picture) -> Markup {
    let caption = caption(snapshot);
    let source = format!("data:image/png;base64,{}", BASE64.encode(png));
    html! {
        figure {
            a href=(snapshot.file) { img src=(source) width="1600" height="900" alt=(caption) decoding="sync"; }
            figcaption { (caption) }
        }
    }
}

fn link(Picture { snapshot, .. }: &Picture) -> Markup {
    html! { a href=(snapshot.file) { (snapshot.file) } ": " (caption(snapshot)) }
}

fn caption(snapshot: &SnapshotReport) -> String {
    format!("{} · {}", words::time(Duration::from_secs_f64(snapshot.time_s)), snapshot.why)
}
