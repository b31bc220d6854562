//! Definitions on disk.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use diagnostics::{Error, ReadFile, read_text};

use crate::definition::{Message, TypeName};
use crate::layout::{Layout, Undefined};

/// Folders with packages, such as `/opt/ros/jazzy/share`, or packages themselves.
#[derive(Clone, Copy)]
pub struct Folders<'r> {
    /// The folders, in the order in which they are searched.
    pub paths: &'r [PathBuf],
    /// Reads their files.
    pub read: ReadFile<'r>,
}

impl Folders<'_> {
    /// A message type, with all types in it. Those that no folder defines are the ones [on board](crate::on_board) that
    /// all distributions have alike.
    ///
    /// # Errors
    /// [`Undefined`] if one of them is missing or wrong.
    pub fn layout(&self, name: &TypeName) -> Result<Arc<Layout>, Undefined> {
        Layout::resolve(name, &mut |name| {
            let found = self.messages(name)?.remove(name).or_else(|| Message::known(name, None));
            let help = "add a folder that contains the package, such as `/opt/ros/jazzy/share`";
            found.ok_or_else(|| Undefined::new(format!("there is no definition of {name}"), help))
        })
    }

    /// The messages defined together with this one: those of a service or an action, or it alone. None if no folder
    /// defines it.
    ///
    /// # Errors
    /// [`Undefined`] if the definition is wrong, or its file cannot be read.
    pub fn messages(&self, name: &TypeName) -> Result<BTreeMap<TypeName, Message>, Undefined> {
        let package = name.package.as_deref().unwrap_or_default();
        let whole = name.whole().name;
        for (kind, name) in [("msg", &name.name), ("srv", &whole), ("action", &whole)] {
            let file = format!("{name}.{kind}");
            let folders = self.paths.iter().flat_map(|folder| {
                let own = folder.file_name().is_some_and(|last| last == package);
                std::iter::once(folder.join(package)).chain(own.then(|| folder.clone()))
            });
            for path in folders.map(|folder| folder.join(kind).join(&file)) {
                let Some(text) = self.text(&path)? else { continue };
                let messages = Message::of_file(kind, name, &path.display().to_string(), &text);
                let messages = messages.map_err(|problems| {
                    Undefined::new(problems.plain().trim_end().to_owned(), "the definition in the folder is wrong")
                })?;
                let named = |(name, message): (String, Message)| (TypeName::new(Some(package), &name), message);
                return Ok(messages.into_iter().map(named).collect());
            }
        }
        Ok(BTreeMap::new())
    }

    fn text(&self, path: &Path) -> Result<Option<String>, Undefined> {
        match read_text(path, self.read) {
            Ok(text) => Ok(Some(text)),
            Err(Error::Read { source, .. }) if source.kind() == std::io::ErrorKind::NotFound => Ok(None),
            Err(error) => Err(Undefined::new(error.to_string(), "the folder must be readable")),
        }
    }
}
