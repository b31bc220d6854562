//! Names of ROS 2 in arguments.

use bags::Remapping;

/// Whether this is a name of ROS 2, perhaps in namespaces.
fn is_name(text: &str) -> bool {
    text.strip_prefix('/').unwrap_or(text).split('/').all(ros_messages::is_name)
}

/// A namespace of ROS 2, with `/` at its beginning.
pub(crate) fn namespace(text: &str) -> Result<String, String> {
    match is_name(text) {
        true => Ok(format!("/{}", text.strip_prefix('/').unwrap_or(text))),
        false => Err("names of letters, digits and `_`, such as `/r1` or `/fleet/r1`".to_owned()),
    }
}

/// `FROM:=TO`, two names of topics, services or actions.
pub(crate) fn remapping(text: &str) -> Result<Remapping, String> {
    let names = text.split_once(":=").filter(|(from, to)| is_name(from) && is_name(to));
    let (from, to) = names.ok_or("two names of letters, digits and `_`, such as `/battery:=/base/battery`")?;
    Ok(Remapping { from: from.to_owned(), to: to.to_owned() })
}

/// `FROM:=TO`, two names of frames.
pub(crate) fn renaming(text: &str) -> Result<(String, String), String> {
    let is_name = |name: &str| !name.is_empty() && !name.starts_with('/') && !name.contains(char::is_whitespace);
    let parts = text.split_once(":=").filter(|(from, to)| is_name(from) && is_name(to));
    parts
        .map(|(from, to)| (from.to_owned(), to.to_owned()))
        .ok_or_else(|| "FROM:=TO, such as odom:=r1/odom, each without `/` at its beginning".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_renamed_to_names_without_a_slash_at_their_beginning() {
        assert_eq!(renaming("odom:=r1/odom"), Ok(("odom".to_owned(), "r1/odom".to_owned())));
        for wrong in ["odom", "odom:=", ":=odom", "odom:=/odom", "odom:=a b"] {
            assert!(renaming(wrong).is_err(), "{wrong}");
        }
    }
}
