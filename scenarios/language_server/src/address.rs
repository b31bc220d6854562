//! Paths of files as addresses, and back.

use std::path::{Path, PathBuf};

use lsp_types::Uri;

/// The path of the file at an address; nothing for documents that are not files.
pub(crate) fn path(address: &Uri) -> Option<PathBuf> {
    let written = address.as_str().strip_prefix("file://")?;
    // The name of this computer may be there.
    let path = &written[written.find('/')?..];
    let path = decoded(path.split(['?', '#']).next()?)?;
    let after_slash = &path[1..];
    let is_drive = after_slash.as_bytes().get(1) == Some(&b':') && cfg!(windows);
    Some(PathBuf::from(if is_drive { after_slash } else { &path }))
}

/// The address of a file; nothing for a path that is not text.
pub(crate) fn of(path: &Path) -> Option<Uri> {
    let path = path.to_str()?.replace(std::path::MAIN_SEPARATOR, "/");
    let mut written = "file://".to_owned();
    if !path.starts_with('/') {
        written.push('/');
    }
    for byte in path.bytes() {
        if byte.is_ascii_alphanumeric() || b"-._~/".contains(&byte) {
            written.push(byte.into());
        } else {
            written += &format!("%{byte:02X}");
        }
    }
    written.parse().ok()
}

fn decoded(written: &str) -> Option<String> {
    let mut bytes = Vec::with_capacity(written.len());
    let mut rest = written.bytes();
    while let Some(byte) = rest.next() {
        bytes.push(match byte {
            b'%' => {
                let digits = [rest.next()?, rest.next()?];
                u8::from_str_radix(std::str::from_utf8(&digits).ok()?, 16).ok()?
            }
            byte => byte,
        });
    }
    String::from_utf8(bytes).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_survive_as_addresses() {
        for file in ["/home/me/a b.toml", "/tmp/ä%20#?.xml", "/x/y+z@~.scope"] {
            let address = of(Path::new(file)).unwrap();
            assert_eq!(path(&address).as_deref(), Some(Path::new(file)), "{address:?}");
        }
        let other = |address: &str| path(&address.parse().unwrap());
        assert_eq!(other("file://localhost/a%3Ab"), Some("/a:b".into()));
        assert_eq!(other("untitled:Untitled-1"), None);
        assert_eq!(other("file:///broken%C3"), None);
    }
}
