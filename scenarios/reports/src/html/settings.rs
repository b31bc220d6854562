//! Every parameter of a scenario with the value that was in effect, and the command that runs it again.

mod given;

use recording::{RunView, SettingGroup};

use super::markup::{code, escape, row};
use crate::report::{Report, SnapshotReport};

use given::Given;

/// The section of the parameters.
pub(super) fn section(view: &RunView) -> String {
    let given: String = given::of(&view.header().origin).iter().map(Given::row).collect();
    let groups: String = view.header().settings.iter().map(table).collect();
    format!(
        "<section id=\"parameters\">\n<h2>Parameters</h2>\n<div class=\"panel\">\n<h3>What the scenario says</h3>\n\
         <div class=\"scroll\"><table class=\"parameters\"><tbody>\n{given}</tbody></table></div>\n\
         <details><summary>Everything else: robot, world and execution in effect</summary>\n<div class=\"groups\">{groups}</div>\
         </details>\n</div>\n</section>\n"
    )
}

/// Parameters that belong together as a table.
fn table(group: &SettingGroup) -> String {
    let rows: String = group.rows.iter().map(|(name, value)| row(&escape(name), &[escape(value)])).collect();
    format!("<div><h4>{}</h4><table class=\"parameters\"><tbody>\n{rows}</tbody></table></div>\n", group.title)
}

/// The section with the command line.
pub(super) fn reproduction(view: &RunView, report: &Report) -> String {
    let link = |picture: &SnapshotReport| format!("<li><a href=\"{0}\">{0}</a></li>", escape(&picture.file));
    let pictures: String = report.snapshots.iter().map(link).collect();
    let pictures = if pictures.is_empty() { pictures } else { format!("<ul class=\"files\">{pictures}</ul>\n") };
    format!(
        "<section id=\"reproduce\">\n<h2>Run it again</h2>\n<div class=\"panel\">\n<pre class=\"command\"><code>{}</code></pre>\n\
         <p>With version {} of the program this gives the same run to the last bit, on any machine of its kind. \
         The hash of its trace is {}.</p>\n<p>Beside this page: <a href=\"report.json\">report.json</a>, the same for programs.</p>\n\
         {pictures}</div>\n</section>\n",
        escape(&command(view, report)),
        escape(&report.version),
        code(&report.trace_hash),
    )
}

/// The command line that runs the scenario again.
pub(super) fn command(view: &RunView, report: &Report) -> String {
    let origin = &view.header().origin;
    let mut command = format!("steward --scenario {} --seed {}", quoted(&origin.argument), report.seed);
    for assignment in &origin.overrides {
        command += &format!(" --set {}", quoted(assignment));
    }
    if view.header().unwatched {
        command += " --no-monitors";
    }
    command
}

/// A word as a shell takes it.
fn quoted(word: &str) -> String {
    let plain = |character: char| character.is_ascii_alphanumeric() || "-_./=:,+@%".contains(character);
    if !word.is_empty() && word.chars().all(plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', r"'\''"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shell_reads_every_word_as_one() {
        assert_eq!(quoted("battery.initial_pct=35"), "battery.initial_pct=35");
        assert_eq!(quoted("faults=[]"), "'faults=[]'");
        assert_eq!(quoted("about=it's"), r"'about=it'\''s'");
    }
}
