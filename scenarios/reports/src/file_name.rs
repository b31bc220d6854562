//! Names of files.

/// Turns a user's name into a file name: unchanged if every system accepts it and it cannot lead out of a folder.
/// Otherwise, bad characters are left out, a very long name is cut off, and a hash of the whole name is added.
#[must_use]
pub fn file_name(name: &str) -> String {
    /// Longer names are cut off.
    const MAX_BYTES: usize = 100;
    /// This much of them is kept.
    const KEPT: usize = 80;
    let is_plain = |c: &char| !(c.is_control() || INVISIBLE.contains(c) || r#"/\:*?"<>|"#.contains(*c));
    let plain: String = name.chars().filter(is_plain).collect();
    let end = if plain.len() > MAX_BYTES { plain.floor_char_boundary(KEPT) } else { plain.len() };
    let cut = plain[..end].trim_matches([' ', '.']).trim_start_matches('-');
    let device = cut.split('.').next().unwrap_or_default().trim_end().to_ascii_uppercase();
    let is_device = DEVICES.contains(&device.trim_end_matches(|c: char| c.is_ascii_digit()));
    if cut == name && !cut.is_empty() && !is_device {
        return name.to_owned();
    }
    let hash = blake3::hash(name.as_bytes()).to_hex();
    let before = if is_device { "_" } else { "" };
    format!("{before}{cut}-{}", &hash[..8]).trim_start_matches('-').to_owned()
}

/// Names of devices on Windows, without a number.
const DEVICES: &[&str] = &["CON", "PRN", "AUX", "NUL", "COM", "LPT"];

/// Invisible characters that change how a text is displayed.
const INVISIBLE: &[char] = &[
    '\u{200b}', '\u{200c}', '\u{200d}', '\u{200e}', '\u{200f}', '\u{2028}', '\u{2029}', '\u{202a}', '\u{202b}',
    '\u{202c}', '\u{202d}', '\u{202e}', '\u{2060}', '\u{2066}', '\u{2067}', '\u{2068}', '\u{2069}', '\u{feff}',
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_becomes_a_unique_file_name() {
        for plain in ["phi1", "arrival-RechargingStation", "my run.v2", "über", "充电站", "console", "a-b"] {
            assert_eq!(file_name(plain), plain);
        }
        let long = "p".repeat(245);
        let strange = [
            "",
            ".",
            "..",
            "...",
            "../../up",
            "a/b",
            "a\\b",
            ".hidden",
            "-rf",
            "end.",
            " ",
            "a\nb",
            "nul",
            "COM1.x",
            "a\u{202e}b",
        ];
        let strange = strange.into_iter().map(str::to_owned).chain([long.clone(), long + "q", "充电站".repeat(30)]);
        let names: Vec<String> = strange.map(|name| file_name(&name)).collect();
        for (place, name) in names.iter().enumerate() {
            assert!((8..=100).contains(&name.len()) && !names[..place].contains(name), "{name}");
            assert!(!name.starts_with(['.', '-']) && !name.contains(['/', '\\', '\n']), "{name}");
            assert_eq!(&file_name(name), name, "safe characters stay as they are");
        }
    }
}
