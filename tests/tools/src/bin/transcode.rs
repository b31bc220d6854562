//! For `ros/messages/tests/foreign.py`: `transcode FOLDER…` reads lines `TYPE BYTES`, decodes the bytes, which are in
//! hexadecimal, and encodes the value again. For each line, it prints the type's hash and the bytes. The folders
//! contain the definitions; `@EDITION` in place of them stands for those on board.

use std::collections::BTreeMap;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use ros_messages::{Decoder, Folders, Layout, Message, TypeName, Undefined, Want};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let paths: Vec<PathBuf> = std::env::args_os().skip(1).map(PathBuf::from).collect();
    let folders = Folders { paths: &paths, read: &|path: &Path| diagnostics::from_disk(path) };
    let edition = paths.first().and_then(|path| path.to_str()?.strip_prefix('@'));
    let layout_of = |name: &TypeName| match edition {
        Some(_) => Layout::resolve(name, &mut |name| {
            Message::known(name, edition).ok_or_else(|| Undefined::new(format!("{name} is not on board"), ""))
        }),
        None => folders.layout(name),
    };
    let mut known = BTreeMap::new();
    let mut out = std::io::BufWriter::new(std::io::stdout().lock());
    for line in std::io::stdin().lines() {
        let line = line?;
        let (name, digits) = line.split_once(' ').ok_or("a line has a type and bytes")?;
        if !known.contains_key(name) {
            let layout = layout_of(&TypeName::parse(name).ok_or("this is not the name of a type")?)?;
            known.insert(name.to_owned(), (layout.type_hash(), Decoder::new(&layout, &Want::All), layout));
        }
        let (hash, decoder, layout) = &known[name];
        let digits = digits.as_bytes().chunks(2).map(std::str::from_utf8);
        let bytes = digits
            .map(|pair| Ok(u8::from_str_radix(pair?, 16)?))
            .collect::<Result<Vec<u8>, Box<dyn std::error::Error>>>();
        let again = layout.encode(&decoder.decode(&bytes?)?)?;
        writeln!(out, "{hash} {}", again.iter().map(|byte| format!("{byte:02x}")).collect::<String>())?;
    }
    Ok(())
}
