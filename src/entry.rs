//! Entries of a list: names with their meanings beside them.

/// A name longer than this has its own line.
const LONGEST: usize = 28;

/// The column at which the meanings of names begin.
pub(crate) fn column<'n>(names: impl IntoIterator<Item = &'n str>) -> usize {
    let widths = names.into_iter().map(|name| name.chars().count()).filter(|width| *width <= LONGEST);
    widths.max().unwrap_or(0) + 4
}

/// A name with its meaning beside it, starting at that column.
pub(crate) fn entry(column: usize, name: &str, meaning: &str) -> String {
    let width = column - 4;
    if name.chars().count() <= width {
        format!("  {name:<width$}  {meaning}\n")
    } else {
        format!("  {name}\n{:column$}{meaning}\n", "")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn meanings_are_aligned_in_one_column() {
        let names = ["at_s", "laser_blocked", "a_name_that_is_longer_than_all_the_others"];
        let column = column(names);
        let list: String = names.iter().map(|name| entry(column, name, "what it means")).collect();
        assert!(list.lines().filter(|line| line.contains("what")).all(|line| line.find("what") == Some(17)), "{list}");
    }
}
