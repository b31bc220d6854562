//! Definitions with everything that they use, as recordings contain them.

use std::fmt;

use diagnostics::{FileProblems, Problem, Source, Span};

use super::idl;
use super::parse::{PartReader, lines};
use super::{Message, TypeName};

/// A message and all types in it, in one text: the schemas `ros2msg` and `ros2idl` of MCAP, as rosbag2 records them.
///
/// After the message, each type has a line of `=`, a line with its name, and its definition. (In IDL, the message
/// itself also has these lines.)
///
/// ```
/// use ros_messages::{Bundle, TypeName};
///
/// let rule = "=".repeat(80);
/// let text = format!("Point[4] corners\n{rule}\nMSG: geometry_msgs/Point\nfloat64 x\nfloat64 y\n");
/// let bundle = Bundle::parse("geometry_msgs/msg/Quad", &text)?;
/// let (name, corner) = &bundle.types[0];
/// assert_eq!(*name, TypeName::new(Some("geometry_msgs"), "Point"));
/// assert_eq!(corner.fields[1].name, "y");
/// # Ok::<(), diagnostics::FileProblems>(())
/// ```
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Bundle {
    /// The message.
    pub message: Message,
    /// The other messages, by name and package, in the order of the text. A definition may name another one of its
    /// package [without the package](TypeName::within).
    pub types: Vec<(TypeName, Message)>,
}

impl Bundle {
    /// Reads a message with all types in it. `name` stands for the text in diagnostics.
    ///
    /// # Errors
    /// Everything that is wrong with it. A type that is used but missing is no error.
    pub fn parse(name: &str, text: &str) -> Result<Self, FileProblems> {
        let source = Source::new(name, text);
        let (mut problems, mut first, mut types) =
            (Vec::new(), PartReader::default(), Vec::<(TypeName, PartReader)>::new());
        let mut is_title = false;
        for (range, line) in lines(text) {
            let span = source.span(range);
            if std::mem::replace(&mut is_title, is_rule(line)) {
                match title(&span) {
                    Ok(name) if types.iter().any(|(earlier, _)| *earlier == name) => {
                        problems.push(span.problem(format!("{name} is defined twice")).with_label("again"));
                    }
                    Ok(name) => types.push((name, PartReader::default())),
                    Err(problem) => problems.push(problem),
                }
            } else if !is_title {
                types.last_mut().map_or(&mut first, |(_, part)| part).read(&span, &mut problems);
            }
        }
        let message = first.end(&mut problems);
        let types = types.into_iter().map(|(name, part)| (name, part.end(&mut problems))).collect();
        FileProblems::none_of(problems)?;
        Ok(Self { message, types })
    }

    /// Reads the message `name` with all types in it, in IDL.
    ///
    /// # Errors
    /// Everything that is wrong with it. A type that is used but missing is no error.
    pub fn parse_idl(name: &TypeName, text: &str) -> Result<Self, FileProblems> {
        let source = Source::new(&name.to_string(), text);
        let mut types = idl::types(&source)?;
        let message = types.remove(name).ok_or_else(|| {
            let problem =
                source.span(0..0).problem(format!("{name} is not defined")).with_label("nowhere in this text");
            problem.with_help("a message is a `struct` in the modules of its package")
        })?;
        Ok(Self { message, types: types.into_iter().collect() })
    }
}

impl fmt::Display for Bundle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let rule = "=".repeat(80);
        self.message.fmt(f)?;
        self.types.iter().try_for_each(|(name, message)| write!(f, "{rule}\nMSG: {name}\n{message}"))
    }
}

/// Whether a line separates definitions.
fn is_rule(line: &str) -> bool {
    line.len() >= 3 && line.bytes().all(|byte| byte == b'=')
}

/// The type defined in the lines after this one.
fn title(line: &Span) -> Result<TypeName, Problem> {
    let name = line.text().strip_prefix("MSG:").and_then(|name| TypeName::parse(name.trim()));
    name.filter(|name| name.package.is_some()).ok_or_else(|| {
        let problem = line.problem("this is not the name of a message").with_label("behind a line of `=`");
        problem.with_help(if line.text().starts_with("IDL:") {
            "this is IDL, although the text is declared otherwise"
        } else {
            "for example `MSG: geometry_msgs/Pose`"
        })
    })
}
