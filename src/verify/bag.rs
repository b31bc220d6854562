//! Bags of ROS 2: their contents.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use bags::{Contents, Definitions, Listed, Survey};
use campaigns::Error;
use diagnostics::from_disk;
use judging::open_bag;
use serde_json::json;

/// A note that a file is only a part of a recording, at the first of the parts.
pub(super) fn part(logs: &[PathBuf], path: &Path) -> Option<String> {
    let (folder, count) = (path.parent()?, bags::parts(path)?);
    let is_part = |log: &&PathBuf| log.parent() == Some(folder) && bags::parts(log).is_some();
    let shown = if folder == Path::new("") { Path::new(".") } else { folder };
    let what = format!("is one of the {count} files of a recording; to check it as a whole, name the folder");
    let note = format!("{} {what}: {}", path.display(), shown.display());
    (logs.iter().find(is_part)? == path).then_some(note)
}

/// The contents of a bag.
pub(super) fn list(path: &Path) -> Result<Contents, Error> {
    let bag = open_bag(path)?;
    let mut contents = contents(bag.survey());
    contents.lost.extend(bag.damage().cloned());
    Ok(contents)
}

/// The contents of a source.
pub(crate) fn contents(survey: &Survey) -> Contents {
    Contents::of(survey, &Definitions { survey, folders: &[], read: &from_disk })
}

/// The list as a comment, with the mapping below it. `publishers` are the publishers of topics, where they are known.
pub(crate) fn in_words(contents: &Contents, publishers: &BTreeMap<String, String>) -> String {
    let mut text = String::new();
    let width = |of: fn(&Listed) -> &str| contents.topics.iter().map(|topic| of(topic).len()).max().unwrap_or(0);
    let (names, kinds) = (width(|topic| &topic.name), width(|topic| &topic.kind));
    if let Some(start_ns) = contents.start_ns {
        text += &format!("# {:.3} s, since {}\n", contents.duration_s, bags::moment(start_ns));
    }
    for Listed { name, kind, messages, rate_hz, fields, .. } in &contents.topics {
        let rate = rate_hz.map_or_else(String::new, |rate_hz| format!("{rate_hz:.2} Hz"));
        let publishers = publishers.get(name).map_or_else(String::new, |publishers| format!("  {publishers}"));
        let missing =
            fields.as_ref().err().map_or_else(String::new, |why| format!("  {}", why.replace('\n', "\n#   ")));
        let line = format!("# {name:names$}  {kind:kinds$}  {messages:>8}  {rate:>10}{publishers}{missing}");
        text += &format!("{}\n", line.trim_end());
    }
    contents.lost.iter().chain(&contents.notes).for_each(|what| text += &format!("# {what}\n"));
    match contents.proposal() {
        Some(proposal) => text += &format!("\n# A mapping of everything: keep what the properties need.\n{proposal}"),
        None => text += "# there is nothing to map\n",
    }
    text
}

pub(crate) fn as_json(contents: &Contents, path: &Path) -> serde_json::Value {
    let topic = |Listed { name, kind, messages, rate_hz, fields, .. }: &Listed| {
        let (fields, missing) = match fields {
            Ok(fields) => (fields.iter().map(|(path, what)| json!({ "path": path, "holds": what })).collect(), None),
            Err(why) => (Vec::new(), Some(why)),
        };
        json!({ "name": name, "type": kind, "messages": messages, "rate_hz": rate_hz, "fields": fields, "missing": missing })
    };
    json!({
        "bag": path.display().to_string(),
        "start_s": contents.start_ns.map(bags::seconds),
        "duration_s": contents.duration_s,
        "topics": contents.topics.iter().map(topic).collect::<Vec<_>>(),
        "lost": contents.lost,
        "notes": contents.notes,
        "mapping": contents.proposal(),
    })
}
