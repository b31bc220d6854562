//! Paths to fields of a ROS message: `pose.position.x`, `covariance[3]`, `ranges[]`.

/// A step of a path: the name of a field, and what of it, if it is an array.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct FieldStep {
    pub(crate) name: String,
    pub(crate) part: Option<Part>,
}

/// What a path takes of an array.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Part {
    Item(usize),
    /// All items, as a list.
    Every,
}

pub(crate) fn steps(path: &str) -> Option<Vec<FieldStep>> {
    let step = |text: &str| {
        let Some((name, item)) = text.split_once('[') else {
            return Some(FieldStep { name: text.to_owned(), part: None });
        };
        let item = item.strip_suffix(']')?;
        let part = match item.parse::<usize>() {
            Err(_) if item.is_empty() => Part::Every,
            // Each path can be written in only one way.
            Ok(number) if number.to_string() == item => Part::Item(number),
            _ => return None,
        };
        Some(FieldStep { name: name.to_owned(), part: Some(part) })
    };
    path.split('.').map(|text| step(text).filter(|step| !step.name.is_empty())).collect()
}
