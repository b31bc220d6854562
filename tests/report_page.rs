//! The report as a page: in a browser, at the widths of a phone, a tablet and a desk.
//!
//! The tests use Chromium to check pages; without it, the tests say so and pass (CI installs it). With
//! `STEWARD_SCREENSHOTS` set, screenshots of every page stay in `target/tmp/report_page/`; each takes seconds to draw.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;
use tempfile::tempdir;

use crate::steward::{picture_size, report, steward};

const WIDTHS_PX: [u64; 3] = [390, 768, 1400];
/// A phone should open a page at once.
const MOST_BYTES: usize = 800_000;

/// Checks the page in the browser, and reports its problems to the page around it.
const PROBE: &str = r#"<script>
addEventListener('load', () => {
  const width = document.documentElement.clientWidth, problems = [];
  const seen = element => element.getClientRects().length > 0 && getComputedStyle(element).visibility !== 'hidden';
  const name = element => element.tagName + '.' + (element.getAttribute('class') || '') + ' ' + (element.textContent || '').trim().slice(0, 40);
  if (document.documentElement.scrollWidth > width) problems.push('the page is ' + document.documentElement.scrollWidth + ' px wide');
  for (const element of document.querySelectorAll('body *:not(svg *, .swipe, .swipe *)')) {
    const box = element.getBoundingClientRect();
    if (seen(element) && (box.left < -0.5 || box.right > width + 0.5)) problems.push('leaves the page: ' + name(element));
    if (seen(element) && element.scrollWidth > element.clientWidth + 1 && getComputedStyle(element).display !== 'inline')
      problems.push('is cut: ' + name(element));
  }
  for (const image of document.images) {
    if (!image.complete || image.naturalWidth === 0) problems.push('does not load: ' + image.alt);
    if (!image.closest('a[href]')) problems.push('cannot be opened: ' + image.alt);
  }
  for (const chart of document.querySelectorAll('svg.chart')) {
    if (!seen(chart)) continue;
    const area = chart.getBoundingClientRect(), texts = [];
    for (const text of chart.querySelectorAll('text')) {
      const box = text.getBoundingClientRect();
      if (box.left < area.left - 1 || box.right > area.right + 1 || box.top < area.top - 1 || box.bottom > area.bottom + 1)
        problems.push('leaves its chart: ' + name(text));
      // A halo is the same text at the same position. A box is taller than its letters.
      const trim = box.height * 0.2;
      const letters = { left: box.left + 1, right: box.right - 1, top: box.top + trim, bottom: box.bottom - trim, text };
      const twin = texts[texts.length - 1];
      if (twin && twin.text.textContent === text.textContent && Math.abs(twin.left - letters.left) < 1) continue;
      for (const other of texts)
        if (letters.left < other.right && other.left < letters.right && letters.top < other.bottom && other.top < letters.bottom)
          problems.push('overlap: ' + name(text) + ' / ' + name(other.text));
      texts.push(letters);
    }
  }
  const loaded = performance.getEntriesByType('resource').map(entry => entry.name).filter(entry => !entry.startsWith('data:'));
  const charts = [...document.querySelectorAll('svg.chart')].filter(seen).length;
  const height = document.documentElement.scrollHeight;
  parent.postMessage(JSON.stringify({ width: innerWidth, height, problems, loaded, charts }), '*');
});
</script>"#;

/// A page around the page, in a frame for each width, because a browser's window is never as narrow as a phone. Keeps
/// the probe's reports, one per line, and makes every frame as high as its page.
fn frames() -> String {
    let frame =
        |width| format!("<iframe src=\"probed.html\" style=\"width:{width}px;height:900px;border:0\"></iframe>");
    format!(
        "<!DOCTYPE html><pre id=\"probe\" hidden></pre><script>addEventListener('message', event => {{ \
         document.getElementById('probe').textContent += event.data + '\\n'; \
         for (const frame of document.querySelectorAll('iframe')) \
         if (frame.contentWindow === event.source) frame.style.height = JSON.parse(event.data).height + 'px'; }})\
         </script><div style=\"display:flex;align-items:start;gap:20px\">{}</div>",
        WIDTHS_PX.map(frame).concat()
    )
}

/// The browser, if there is one.
fn browser() -> Option<PathBuf> {
    let named = std::env::var_os("CHROMIUM").map(PathBuf::from);
    let path = std::env::var_os("PATH").unwrap_or_default();
    let found = std::env::split_paths(&path)
        .flat_map(|folder| ["chromium", "chromium-browser", "google-chrome"].map(|name| folder.join(name)))
        .find(|path| path.is_file());
    let browser = named.or(found);
    if browser.is_none() {
        eprintln!("skipped: no Chromium in PATH, and CHROMIUM names none");
    }
    browser
}

/// Opens a page at this size with these additional arguments; returns the browser's output.
fn open(browser: &Path, page: &Path, (width, height): (u32, u32), arguments: &[&str]) -> String {
    let profile = tempdir().unwrap();
    let output = Command::new(browser)
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--hide-scrollbars"])
        .args(["--disable-background-networking", "--disable-component-update", "--disable-sync", "--timeout=30000"])
        .arg(format!("--user-data-dir={}", profile.path().display()))
        .arg(format!("--window-size={width},{height}"))
        .args(arguments)
        .arg(format!("file://{}", page.display()))
        .output()
        .expect("the browser starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// The probe's findings, by width.
fn probe(browser: &Path, frames: &Path) -> BTreeMap<u64, Value> {
    let dom = open(browser, frames, (2700, 1000), &["--dump-dom", "--virtual-time-budget=10000"]);
    let found = dom.split_once("<pre id=\"probe\" hidden=\"\">").and_then(|(_, found)| found.split_once("</pre>"));
    let (found, _) = found.unwrap_or_else(|| panic!("the probe has reported nothing: {dom}"));
    let found = found.replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&");
    let found = found.lines().map(|line| serde_json::from_str::<Value>(line).unwrap());
    found.map(|found| (found["width"].as_u64().unwrap(), found)).collect()
}

/// Checks the page of a run, at every width.
pub(crate) fn look_at(name: &str, page: &Path, charts: u64) {
    let Some(browser) = browser() else { return };
    let folder = page.parent().unwrap();
    let text = std::fs::read_to_string(page).unwrap();
    assert!(text.len() < MOST_BYTES, "{name} has {} bytes", text.len());
    std::fs::write(folder.join("probed.html"), drawn(&text).replace("</body>", &format!("{PROBE}</body>"))).unwrap();
    let page = folder.join("frames.html");
    std::fs::write(&page, frames()).unwrap();
    let found = probe(&browser, &page);
    assert!(found.keys().eq(&WIDTHS_PX), "{name}: the page has the requested widths");
    for (width, found) in &found {
        assert_eq!(found["problems"], Value::Array(Vec::new()), "{name} at {width} px");
        assert_eq!(found["loaded"], Value::Array(Vec::new()), "{name} at {width} px loads something");
        assert_eq!(found["charts"], charts, "{name} at {width} px");
    }
    if std::env::var_os("STEWARD_SCREENSHOTS").is_some() {
        let height = found.values().filter_map(|found| found["height"].as_u64()).max().unwrap();
        keep_screenshots(name, &browser, &page, (2700, u32::try_from(height).unwrap() + 20));
    }
}

/// The page without its script, as on paper, which also allows the probe.
fn drawn(page: &str) -> String {
    let (head, rest) = page.split_once("<meta http-equiv=\"Content-Security-Policy\"").expect("a policy");
    let (_, rest) = rest.split_once('>').expect("it ends");
    let rest = rest.rsplit_once("<script>").map_or(rest, |(rest, _)| rest);
    format!("{head}{}</body></html>", rest.trim_end_matches("</body></html>"))
}

/// Keeps pictures of a page, light and dark.
fn keep_screenshots(name: &str, browser: &Path, page: &Path, size: (u32, u32)) {
    let kept = Path::new(env!("CARGO_TARGET_TMPDIR")).join("report_page");
    std::fs::create_dir_all(&kept).unwrap();
    for (surroundings, scheme) in [("light", 1), ("dark", 0)] {
        let picture = kept.join(format!("{name}-{surroundings}.png"));
        let screenshot = format!("--screenshot={}", picture.display());
        let scheme = format!("--blink-settings=preferredColorScheme={scheme}");
        open(browser, page, size, &[&screenshot, &scheme]);
        assert_eq!(picture_size(&picture), size);
    }
}

#[test]
#[ignore = "long: .ci/run runs it"]
fn the_page_of_the_first_experiment_fits_every_screen() {
    let out = tempdir().unwrap();
    report("battery_fault", out.path(), &[]);
    look_at("battery_fault", &out.path().join("report.html"), 3); // map, timeline, one violation
}

#[test]
#[ignore = "long: .ci/run runs it"]
fn a_long_run_fits_too() {
    let out = tempdir().unwrap();
    report("nominal", out.path(), &["--no-snapshots"]);
    look_at("nominal", &out.path().join("report.html"), 2);
}

#[test]
#[ignore = "long: .ci/run runs it"]
fn the_page_explains_why_the_robot_stands_still() {
    let out = tempdir().unwrap();
    report("late_halt", out.path(), &["--no-snapshots"]);
    let page = std::fs::read_to_string(out.path().join("report.html")).unwrap();
    let phi3 = page.find("id=\"violation-phi3\"").map(|at| &page[at..]).expect("phi3 has its story");
    let phi3 = &phi3[..phi3.find("</ol>").expect("it is a list")];
    let in_order = [
        "So Localization had to tell AtRechargingStation <code>[&lt;ok&gt;, true]</code> by tick 271.",
        "GotoRechargingStation told Navigation <code>[&lt;start_navigation&gt;, &lt;RechargingStation&gt;]</code> at tick 152",
        "Navigation told GotoRechargingStation <code>[&lt;ok&gt;, &lt;running&gt;]</code> at tick 152",
        "GoToDestination told Navigation <code>[&lt;stop_navigation&gt;, &lt;Destination&gt;]</code> at tick 152",
        "Navigation told GotoRechargingStation <code>[&lt;ok&gt;, &lt;idle&gt;]</code> at tick 152",
    ];
    let places = in_order.map(|words| phi3.find(words).unwrap_or_else(|| panic!("phi3's story does not say: {words}")));
    assert!(places.is_sorted(), "the start comes before the stop");
    look_at("late_halt", &out.path().join("report.html"), 3);
}

#[test]
#[ignore = "long: .ci/run runs it"]
fn a_robot_that_is_driven_away_repeatedly_fits_too() {
    let out = tempdir().unwrap();
    report("joypad", out.path(), &["--no-snapshots"]);
    let page = std::fs::read_to_string(out.path().join("report.html")).unwrap();
    assert!(page.contains(" s a fault took effect, for the first of 7 times: a joypad overrides"));
    look_at("joypad", &out.path().join("report.html"), 4);
}

/// Checks the page of that scenario's run and returns it: it has this many charts, and contains all of `words` in
/// order.
fn page_that_says(scenario: &str, charts: u64, words: &[&str]) {
    let out = tempdir().unwrap();
    report(scenario, out.path(), &["--no-snapshots"]);
    let page = std::fs::read_to_string(out.path().join("report.html")).unwrap();
    let mut rest = page.as_str();
    for words in words {
        let Some(place) = rest.find(words) else { panic!("the page does not say this, or in another order: {words}") };
        rest = &rest[place..];
    }
    look_at(scenario, &out.path().join("report.html"), charts);
}

#[test]
#[ignore = "long: .ci/run runs it"]
fn a_missing_message_is_described_and_drawn() {
    let words = [
        "At 0 s a fault took effect: the machine BatteryLevel has threshold = 20.",
        "At 20.5 s a fault took effect: battery level set to 25\u{a0}%.",
        "At tick 21 (21.02 s) BatteryReader told BatteryLevel <code>[&lt;ok&gt;, 24.974999…]</code>",
        "So GotoRechargingStation had to tell Navigation <code>[&lt;start_navigation&gt;, &lt;RechargingStation&gt;]</code> by tick 30.",
        "But GotoRechargingStation sent Navigation nothing at all in that time.",
        "BatteryLevel answered the tree <code>[&lt;success&gt;]</code> 10 times",
        "GotoRechargingStation was not asked by the tree",
        "At tick 31 (31.02 s) it was too late: <code>phi2</code> is violated.",
        "Ticks 22 to 30: the same 8 messages at each of 9 ticks, none from GotoRechargingStation to Navigation",
        "missing until tick 30: GotoRechargingStation → Navigation",
    ];
    page_that_says("skill_bug", 4, &words);
}

#[test]
#[ignore = "long: .ci/run runs it"]
fn a_robot_that_never_arrives_is_described() {
    let words = [
        "At 0 s a fault took effect: a box stands at",
        "So Localization had to tell AtRechargingStation <code>[&lt;ok&gt;, true]</code> by tick 150.",
        "But Localization sent AtRechargingStation only 120 other messages in that time, the last of them <code>[&lt;ok&gt;, false]</code> at tick 150.",
        "navigation was moving, then preparing before move, then waiting obstacle, then thinking, then failing.",
        "Navigation told GotoRechargingStation <code>[&lt;ok&gt;, &lt;running&gt;]</code>",
        "it was too late: <code>phi3</code> is violated.",
    ];
    page_that_says("never_arrives", 3, &words);
}

#[test]
#[ignore = "long: .ci/run runs it"]
fn a_violation_by_a_robot_at_the_station_is_described() {
    let words = [
        "At 0.5 s a fault took effect: battery level set to 29\u{a0}%.",
        "So GotoRechargingStation had to tell Navigation <code>[&lt;start_navigation&gt;, &lt;RechargingStation&gt;]</code> by tick 10.",
        "BatteryReader continued to send messages to BatteryLevel: the last, at tick 10, was <code>[&lt;ok&gt;, 47.039999…]</code>.",
        "GotoRechargingStation was not asked by the tree",
        "it was too late: <code>phi2</code> is violated.",
    ];
    page_that_says("already_there", 3, &words);
}

#[test]
fn a_violation_of_which_nothing_is_expected_is_named_first() {
    let out = tempdir().unwrap();
    let arguments = ["--no-snapshots", "--set", "expect={reached=[\"RechargingStation\"]}"];
    let output = steward(&[&["run", "battery_fault", "--out", out.path().to_str().unwrap()][..], &arguments].concat());
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(said.contains("\n  ! phi1 is violated, and the scenario does not expect it\n"), "{said}");
    assert_eq!(output.status.code(), Some(1), "{said}");
}

#[test]
fn junit_has_a_case_for_each_property_and_expectation() {
    let out = tempdir().unwrap();
    let file = out.path().join("results/junit.xml");
    let file_text = file.to_str().unwrap();
    let arguments = ["--no-snapshots", "--results", file_text, "--set", "expect.max_collisions=0"];
    report("battery_fault", out.path(), &arguments);
    let passed = std::fs::read_to_string(&file).unwrap();
    assert!(passed.contains("<testsuite name=\"battery_fault\" tests=\"8\" failures=\"0\""), "{passed}");
    assert_eq!(passed.matches("classname=\"battery_fault.properties\"").count(), 3, "{passed}");
    report("battery_fault", out.path(), &[&arguments[..], &["--set", "expect.phi1=satisfied"]].concat());
    let failed = std::fs::read_to_string(&file).unwrap();
    assert!(failed.contains("tests=\"8\" failures=\"2\""), "{failed}");
    assert!(failed.contains("<failure message=\"phi1 was expected to be satisfied and is violated\">"), "{failed}");
}

#[test]
fn a_page_that_cannot_be_written_is_an_error_that_names_it() {
    let out = tempdir().unwrap();
    std::fs::create_dir_all(out.path().join("report.html")).unwrap();
    let output = steward(&["--scenario", "battery_fault", "--no-snapshots", "--out", out.path().to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(3));
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(said.contains("report.html"), "{said}");
}
