//! Files beside a machine's file: `src` and `srcexpr`.

use std::path::{Path, PathBuf};

use diagnostics::Disk;

use crate::folder::Folder;

/// The maximum length of a file.
pub(super) const MAX_BYTES: usize = 4 << 20;

/// The file at an address, relative to a folder, with that folder.
pub(super) fn path<'f>(address: &str, folder: Option<&'f Folder>) -> Result<(PathBuf, &'f Folder), String> {
    let address = address.trim();
    let name = address.strip_prefix("file://").or_else(|| address.strip_prefix("file:")).unwrap_or(address);
    if name.contains("://") {
        return Err(format!("`{address}` is not a local file, and other addresses are not supported"));
    }
    if name.is_empty() {
        return Err("no file is named".to_owned());
    }
    let folder = folder.ok_or("files beside the machine are not accessible here")?;
    Ok((folder.path.join(name), folder))
}

/// The text of a file: UTF-8, UTF-16 with a byte order mark, or ISO 8859-1 if its first line declares it.
pub(super) fn read(path: &Path, disk: &Disk) -> Result<String, String> {
    let unreadable = |reason: &dyn std::fmt::Display| format!("cannot read {}: {reason}", path.display());
    let bytes = disk.read_up_to(path, MAX_BYTES as u64).map_err(|error| unreadable(&error))?;
    decode(bytes).ok_or_else(|| unreadable(&"it is neither UTF-8 nor UTF-16"))
}

fn decode(bytes: Vec<u8>) -> Option<String> {
    let wide = |of: fn([u8; 2]) -> u16| {
        let units = bytes[2..].chunks_exact(2).map(|pair| of([pair[0], pair[1]]));
        char::decode_utf16(units).collect::<Result<String, _>>().ok()
    };
    match bytes.as_slice() {
        [0xFF, 0xFE, ..] => return wide(u16::from_le_bytes),
        [0xFE, 0xFF, ..] => return wide(u16::from_be_bytes),
        _ => {}
    }
    let head = String::from_utf8_lossy(&bytes[..bytes.len().min(120)]).to_ascii_uppercase();
    if ["ISO-8859-1", "WINDOWS-1252", "US-ASCII"].iter().any(|name| head.contains(name)) {
        return Some(bytes.iter().map(|byte| char::from(*byte)).collect());
    }
    String::from_utf8(bytes).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_looked_up_beside_the_machine() {
        let folder = &Folder::of(Path::new("machines/main.scxml"), &Disk::default());
        for address in ["sub.scxml", "file:sub.scxml", "file://sub.scxml", " sub.scxml "] {
            assert_eq!(path(address, Some(folder)).unwrap().0, folder.path.join("sub.scxml"));
        }
        assert!(path("http://example.org/sub.scxml", Some(folder)).is_err());
        assert!(path("", Some(folder)).is_err());
        assert!(path("sub.scxml", None).is_err());
    }

    #[test]
    fn several_encodings_are_read() {
        assert_eq!(decode(vec![0xFF, 0xFE, b'<', 0, 0xE4, 0]).as_deref(), Some("<ä"));
        assert_eq!(decode(vec![0xFE, 0xFF, 0, b'<']).as_deref(), Some("<"));
        assert_eq!(decode("<ä".into()).as_deref(), Some("<ä"));
        assert_eq!(
            decode(b"<?xml encoding='iso-8859-1'?>\xE4".to_vec()).as_deref(),
            Some("<?xml encoding='iso-8859-1'?>ä")
        );
        assert_eq!(decode(vec![0xE4]), None);
    }
}
