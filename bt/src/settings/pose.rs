//! Poses and paths as strings, in Nav2's format and in a short one.

/// The number of fields of a pose in Nav2's format: `stamp;frame;x;y;z;qx;qy;qz;qw`.
const FIELDS: usize = 9;

/// The position of a pose in meters: `x;y`, or Nav2's format.
pub(super) fn position(pose: &str) -> Option<[f64; 2]> {
    match pose.split(';').collect::<Vec<_>>()[..] {
        [x, y] | [_, _, x, y, _, _, _, _, _] => Some([number(x)?, number(y)?]),
        _ => None,
    }
}

/// A path: the position and orientation of each pose, as far as they are given. `x;y;x;y;…`, or `stamp;frame;` and
/// Nav2's nine fields for each pose. An empty string is an empty path.
pub(super) fn path(text: &str) -> Option<Vec<Vec<f64>>> {
    let fields: Vec<&str> = text.split(';').filter(|_| !text.is_empty()).collect();
    if has_header(&fields) {
        fields[2..].chunks(FIELDS).map(|pose| pose[2..].iter().map(|field| number(field)).collect()).collect()
    } else {
        let pairs = fields.chunks(2).map(|pair| pair.iter().map(|field| number(field)).collect());
        pairs.collect::<Option<Vec<Vec<f64>>>>().filter(|_| fields.len().is_multiple_of(2))
    }
}

/// The length of a path in meters.
pub(super) fn length(path: &[Vec<f64>]) -> f64 {
    path.windows(2).map(|pair| distance([pair[0][0], pair[0][1]], [pair[1][0], pair[1][1]])).sum()
}

pub(super) fn distance(from: [f64; 2], to: [f64; 2]) -> f64 {
    let [dx, dy] = [to[0] - from[0], to[1] - from[1]];
    (dx * dx + dy * dy).sqrt()
}

/// The stamp of a goal, or of several goals, in nanoseconds; `None` if it is not in Nav2's format, and 0 if there are
/// no goals.
pub(super) fn stamp(goal: &str) -> Option<i64> {
    let fields: Vec<&str> = goal.split(';').collect();
    match fields.len() {
        2 if has_header(&fields) => Some(0),
        FIELDS => fields[0].trim().parse().ok(),
        _ if has_header(&fields) => fields[0].trim().parse().ok(),
        _ => None,
    }
}

/// Whether the fields are `stamp;frame;` and whole poses.
fn has_header(fields: &[&str]) -> bool {
    fields.len() >= 2 && (fields.len() - 2).is_multiple_of(FIELDS) && number(fields[1]).is_none()
}

fn number(field: &str) -> Option<f64> {
    field.trim().parse().ok().filter(|number: &f64| number.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pose_is_short_or_in_the_format_of_nav2() {
        assert_eq!(position("1.5;-2"), Some([1.5, -2.0]));
        assert_eq!(position("12;map;1;2;0;0;0;0;1"), Some([1.0, 2.0]));
        assert_eq!([position(""), position("1;2;3"), position("kitchen"), position("a;b")], [None; 4]);
    }

    #[test]
    fn a_path_is_short_or_in_the_format_of_nav2() {
        let in_full = path("5;map;5;map;0;0;0;0;0;0;1;5;map;3;4;0;0;0;0;1").unwrap();
        assert_eq!((in_full.len(), length(&in_full)), (2, 5.0));
        assert_eq!(length(&path("0;0;3;4;3;5").unwrap()), 6.0);
        assert_eq!([path("").unwrap().len(), path("5;map").unwrap().len()], [0, 0]);
        assert_eq!([path("0;0;1"), path("there")], [None, None]);
    }

    #[test]
    fn only_goals_in_the_format_of_nav2_have_stamps() {
        assert_eq!(stamp("12;map;1;2;0;0;0;0;1"), Some(12));
        assert_eq!(stamp("7;map;12;map;1;2;0;0;0;0;1"), Some(7));
        assert_eq!(stamp("7;map"), Some(0));
        assert_eq!([stamp("1;2"), stamp("kitchen"), stamp("")], [None; 3]);
    }
}
