//! Tests of whole pictures.
//!
//! With `STEWARD_DRAW_SAMPLES=FOLDER`, the sample pictures are written to that folder.

use std::path::PathBuf;

use image::AnimationDecoder;
use image::codecs::gif::GifDecoder;
use resvg::usvg;

use super::frame::{Frame, Monitor, Verdict};
use super::geometry::Area;
use super::page::{self, Page};
use super::sample::{
    charging_frame, crowded_frame, empty_frame, everything, frame, large_tree, mapless_frame, phi1, phi2,
};
use super::{ANIMATION_SIZE_PX, GifWriter, Renderer, svg};

fn samples() -> Vec<(&'static str, Frame)> {
    let mut six = frame();
    six.monitors = vec![phi1(), phi2(), phi1(), phi2(), phi1(), phi2()];
    let mut three = frame();
    three.monitors.push(phi1());
    let mut large = frame();
    large.tree = large_tree();
    large.monitors = vec![phi1(); 9];
    let mut loops = frame();
    loops.monitors = vec![everything(), phi2()];
    let mut crowded_tree = mapless_frame();
    crowded_tree.tree = large_tree();
    vec![
        ("sample", frame()),
        ("mapless", mapless_frame()),
        ("mapless_large_tree", crowded_tree),
        ("loops", loops),
        ("empty", empty_frame()),
        ("charging", charging_frame()),
        ("crowded", crowded_frame()),
        ("three_monitors", three),
        ("six_monitors", six),
        ("large_tree", large),
    ]
}

fn texts(svg: &str) -> Vec<(String, Area)> {
    Renderer::new().texts(svg).unwrap()
}

#[test]
fn texts_stay_on_the_page_and_do_not_overlap() {
    for (name, frame) in samples() {
        for page in [Page::Snapshot, Page::Animation] {
            let (width, height) = page.size_px();
            let whole = Area::new(0.0, 0.0, f64::from(width), f64::from(height));
            let texts = texts(&page::draw(&frame, page));
            assert!(texts.len() > 15, "{name} has {} texts", texts.len());
            for (i, (text, area)) in texts.iter().enumerate() {
                assert!(whole.encloses(area), "{name}, {page:?}: {text:?} leaves the page: {area:?}");
                for (other, other_area) in &texts[..i] {
                    assert!(!area.overlaps(other_area), "{name}, {page:?}: {text:?} overlaps {other:?}");
                }
            }
        }
    }
}

#[test]
fn numbers_are_finite_and_the_text_is_valid_xml() {
    for (name, frame) in samples() {
        let picture = svg(&frame);
        let document = usvg::roxmltree::Document::parse(&picture).unwrap();
        for node in document.descendants() {
            for attribute in node.attributes() {
                let value = attribute.value();
                assert!(!value.contains("NaN") && !value.contains("inf"), "{name}: {value}");
            }
        }
    }
}

#[test]
fn markup_in_names_is_displayed_as_text() {
    let mut marked = frame();
    marked.scenario = "<script>&\"'".into();
    let picture = svg(&marked);
    assert!(picture.contains("&lt;script&gt;&amp;\"'"));
    assert!(texts(&picture).iter().any(|(text, _)| text == "<script>&\"'"));
}

#[test]
fn everything_in_a_frame_is_in_the_picture() {
    let picture = svg(&frame());
    let texts: Vec<String> = texts(&picture).into_iter().map(|(text, _)| text).collect();
    let expected = [
        "battery_fault",
        "seed 7",
        "67.02 s",
        "tick 67 of the tree",
        "charging station",
        "destination",
        "start",
        "level set to 10 %",
        "9.6 %",
        "30 % recharge",
        "20 % unsafe",
        "GotoRechargingStation",
        "phi1",
        "violated · tick 67",
        "undecided",
        "failure",
        "start for the station",
        "timer := θ",
        "5 m",
    ];
    for words in expected {
        assert!(texts.iter().any(|text| text == words), "{words:?} is missing from {texts:?}");
    }
}

#[test]
fn monitors_that_do_not_fit_are_counted() {
    let (_, large) = samples().pop().unwrap();
    let texts = texts(&page::draw(&large, Page::Animation));
    let shown = texts.iter().filter(|(text, _)| text == "phi1").count();
    let hidden = texts.iter().find_map(|(text, _)| text.strip_prefix('+')?.strip_suffix(" more")?.parse().ok());
    assert_eq!(shown + hidden.unwrap_or(0_usize), 9);
}

/// If there are many monitors, names and verdicts are shown; if there are too many even for that, the violated ones are
/// still shown.
#[test]
fn no_violated_monitor_is_hidden() {
    let many = |count: usize| {
        let monitor = |place: usize| Monitor {
            name: format!("phi{place}"),
            description: "what it says ".repeat(9),
            verdict: if place + 1 == count { Verdict::Violated } else { Verdict::HoldsSoFar },
            ..frame().monitors[0].clone()
        };
        let frame = Frame { monitors: (0..count).map(monitor).collect(), ..frame() };
        texts(&svg(&frame)).into_iter().map(|(text, _)| text).collect::<Vec<_>>()
    };
    let texts = many(14);
    assert!((0..14).all(|place| texts.contains(&format!("phi{place}"))), "{texts:?}");
    let texts = many(100);
    assert!(texts.iter().any(|text| text.ends_with(" more")), "{texts:?}");
    assert!(texts.contains(&"phi99".to_owned()) && texts.contains(&"violated".to_owned()), "{texts:?}");
}

#[test]
fn the_same_frame_gives_the_same_bytes() {
    let draw = || Renderer::new().png(&page::draw(&frame(), Page::Animation)).unwrap();
    assert!(draw() == draw());
}

#[test]
fn the_sample_looks_as_before() {
    let golden = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/goldens/sample.png");
    let drawn = Renderer::new().png(&page::draw(&frame(), Page::Animation)).unwrap();
    if std::env::var_os("STEWARD_UPDATE_GOLDENS").is_some() {
        std::fs::write(&golden, &drawn).unwrap();
    }
    let pixels = |file: &[u8]| image::load_from_memory(file).map(|picture| picture.into_rgb8()).ok();
    if std::fs::read(&golden).map_or(true, |golden| pixels(&golden) != pixels(&drawn)) {
        let path = std::env::temp_dir().join("steward_draw_sample.png");
        std::fs::write(&path, &drawn).unwrap();
        panic!(
            "the picture differs from {}: look at {}, and if it is right, run the test again with \
             STEWARD_UPDATE_GOLDENS=1",
            golden.display(),
            path.display()
        );
    }
}

#[test]
fn a_file_that_is_not_a_picture_is_refused() {
    let error = Renderer::new().png("<svg").unwrap_err();
    assert_eq!(error.to_string(), "cannot read the picture");
    assert!(std::error::Error::source(&error).is_some(), "why it is not a picture");
}

#[test]
fn an_animation_is_a_gif_with_all_of_its_frames() {
    let renderer = Renderer::new();
    let mut moved = frame();
    moved.scene.as_mut().unwrap().robot = maps::pose(-7.2, 6.5, 1.8);
    let write = || {
        let mut gif = GifWriter::new(Vec::new(), std::time::Duration::from_millis(100));
        for frame in [&frame(), &moved, &moved] {
            gif.push(&renderer, frame).unwrap();
        }
        gif.finish().unwrap()
    };
    let bytes = write();
    assert!(bytes == write());
    let shown = GifDecoder::new(std::io::Cursor::new(bytes)).unwrap().into_frames().collect_frames().unwrap();
    assert_eq!(shown.len(), 4);
    let (width, height) = ANIMATION_SIZE_PX;
    for (shown, frame) in shown.iter().zip([&frame(), &moved, &moved, &moved]) {
        let picture = renderer
            .pixels(&page::draw(frame, Page::Animation), f32::from(width) / Page::Animation.size_px().0 as f32)
            .unwrap();
        assert_eq!((picture.width, picture.height), (width.into(), height.into()));
        // A GIF has few colors, but so has a frame: none is lost.
        let pixels = shown.buffer().pixels().map(|pixel| pixel.0);
        assert!(pixels.eq(picture.colors.into_iter().map(|[red, green, blue]| [red, green, blue, 255])));
    }
}

#[test]
fn samples_are_written_on_request() {
    let Some(folder) = std::env::var_os("STEWARD_DRAW_SAMPLES").map(PathBuf::from) else { return };
    let renderer = Renderer::new();
    for (name, frame) in samples() {
        for page in [Page::Snapshot, Page::Animation] {
            let picture = page::draw(&frame, page);
            let file = folder.join(format!("{name}_{}.svg", page.size_px().0));
            std::fs::write(file.with_extension("png"), renderer.png(&picture).unwrap()).unwrap();
            std::fs::write(file, picture).unwrap();
        }
    }
}

#[test]
fn measured_widths_match_the_renderer() {
    use super::canvas::{Canvas, TextStyle};
    use super::text::Font;

    let samples =
        ["battery_fault", "AVATAR Toy", "a → b ≤ □ θ", "fi ffi fl", "<b>&amp; \"quote\" 漢字", "67.02 s", "Жé…"];
    for font in [Font::regular(13.0), Font::bold(26.0)] {
        for text in samples {
            let mut canvas = Canvas::new();
            canvas.text((10.0, 40.0), text, TextStyle::new(font, super::theme::INK));
            let (_, area) = texts(&canvas.finish(500.0, 60.0)).pop().unwrap();
            let measured = font.width(text);
            assert!(measured > area.width - 0.1, "{text:?} is {} wide, measured {measured}", area.width);
            assert!(measured < area.width * 1.07 + 2.0, "{text:?} is {} wide, measured {measured}", area.width);
        }
    }
}
