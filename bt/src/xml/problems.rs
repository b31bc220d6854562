//! Problems of tree files that are reported in several places.

use std::fmt::Display;
use std::sync::Arc;

use diagnostics::{MAX_HINTS, Problem, nearest};
use miette::SourceSpan;

use crate::blackboard::{Clash, Type};
use crate::{Category, Direction};

/// The file, or the tree with its subtrees, is too large.
pub(super) fn too_large(limit: usize, span: SourceSpan) -> Problem {
    Problem::new(format!("this is too large: more than {limit} nodes")).at(span, "here")
}

/// There are too many ports.
pub(super) fn too_many(what: &str, limit: usize, span: SourceSpan) -> Problem {
    Problem::new(format!("there are more than {limit} {what}")).at(span, "one too many")
}

/// Nodes are nested too deeply.
pub(super) fn too_deep(limit: usize, span: SourceSpan) -> Problem {
    let problem = Problem::new(format!("nodes are nested more than {limit} deep")).at(span, "one level too deep");
    problem.with_help("move a part into its own tree, or reduce the nesting; BehaviorTree.CPP has the same limit")
}

/// BehaviorTree.CPP supports or supported it; this crate does not.
pub(super) fn not_supported(what: &str, span: SourceSpan, help: &str) -> Problem {
    Problem::new(format!("{what} is not supported")).at(span, "not supported").with_help(help)
}

/// A node has the wrong number of children.
pub(super) fn child_count(node: &str, expected: &str, found: usize, span: SourceSpan) -> Problem {
    Problem::new(format!("{node} must have {expected}, but has {found}")).at(span, format!("must have {expected}"))
}

/// A node is used in a different category than declared; `declared` is the position of the declaration.
pub(super) fn wrong_category(
    id: &str,
    is: Category,
    used_as: Category,
    span: SourceSpan,
    declared: Option<SourceSpan>,
) -> Problem {
    let message = format!("`{id}` is {}, not {}", with_article(is), with_article(used_as));
    let problem = Problem::new(message).at(span, format!("used as <{used_as}> here"));
    match declared {
        Some(declared) => problem.at(declared, format!("<{is}> here")),
        None => problem,
    }
}

fn with_article(category: Category) -> String {
    let article = if category == Category::Action { "an" } else { "a" };
    format!("{article} <{category}>")
}

/// An element has an unknown name, and so have `more` others in the file.
pub(super) fn unknown_node(name: &str, more: usize) -> Problem {
    let repeated = match more {
        0 => String::new(),
        1 => ", here and in one other place".to_owned(),
        more => format!(", here and in {more} other places"),
    };
    Problem::new(format!("unknown node type <{name}>{repeated}"))
}

pub(super) fn missing_port(node: &str, port: &str, span: SourceSpan, help: Option<String>) -> Problem {
    let problem = Problem::new(format!("{node} needs the port `{port}`"));
    problem.at(span, format!("needs {port}=\"…\"")).with_help_if(help)
}

/// An attribute is not one of the node's ports.
pub(super) fn unknown_port(node: &str, port: &str, span: SourceSpan, help: Option<String>) -> Problem {
    Problem::new(format!("{node} has no port `{port}`")).at(span, "no such port").with_help_if(help)
}

/// An entry is used as a port of another type. It is an error, unless some version of BehaviorTree.CPP, or a program
/// that extends it, accepts it.
pub(super) fn types_differ(key: &str, clash: &Clash, of: &Type, direction: Direction) -> Problem {
    let Clash { is, of_constant } = clash;
    let problem = Problem::new(format!("the entry `{key}` already has the type {is} and cannot be used as {of}"));
    if *of_constant {
        return problem.as_warning().with_help(format!(
            "BehaviorTree.CPP from 4.9.1 on refuses to load this tree: the port [{key}] was initially created with \
             type [{is}] and, later type [{of}] was used somewhere else; 4.9.0 passes the constant as a string, and so \
             does an entry that SetBlackboard writes"
        ));
    }
    match (is, of, direction) {
        (Type::Other(_), Type::Other(_), Direction::Input) => problem.as_warning().with_help(
            "BehaviorTree.CPP from 4.9 on accepts this if the robot's program registers a cast between shared pointers \
             to the two types, and otherwise refuses to load the tree",
        ),
        _ => problem,
    }
}

/// What a SetBlackboard writes.
pub(super) enum Written {
    Constant(Arc<str>),
    /// The value of an entry of this type.
    Copy(Type),
    /// The value of an entry without a type, to which only scripts assign numbers.
    ScriptedNumber,
    /// The value of an entry without a type, to which a script can assign a string.
    ScriptedString,
}

/// The problem with writing to the entry of a key, of this type, by SetBlackboard; `is_any` if it is a `BT::Any`, and
/// `is_made` if the entry can exist before that.
pub(super) fn copy_refused(key: &str, of: Type, (is_any, is_made): (bool, bool), written: &Written) -> Option<Problem> {
    let changed = |from: &dyn Display| {
        format!(
            "BehaviorTree.CPP throws \"Blackboard::set({key}): once declared, the type of a port shall not change\": \
             the entry has the type {of}, and the value {from}"
        )
    };
    let is_string = matches!(written, Written::Constant(_) | Written::Copy(Type::Text) | Written::ScriptedString);
    let help = match written {
        _ if is_string && is_any => format!("BehaviorTree.CPP throws \"Can't convert string … to type [{ANY}]\""),
        _ if is_string && of == Type::Status => changed(&"is a string"),
        // A new entry that gets what a script has made has no type either.
        Written::Constant(_) | Written::Copy(Type::Text) | Written::ScriptedString
            if !of.is_strong() && (is_made || matches!(written, Written::ScriptedString)) =>
        {
            "BehaviorTree.CPP parses the string with the entry's type; if a script or a port makes the entry first, it \
             has none and is emptied"
                .to_owned()
        }
        Written::Constant(text) if of.parse(text).is_err() => {
            format!("BehaviorTree.CPP throws \"Can't convert string [{text}] to type [{of}]\"")
        }
        Written::Copy(from) if of.is_strong() && from.is_strong() && *from != Type::Text && *from != of => {
            changed(&format_args!("is of type {from}"))
        }
        // A script's numbers are 64 bits wide.
        Written::ScriptedNumber if matches!(of, Type::Int { .. } | Type::Bool) && of != Type::INT64 => {
            changed(&"of a script is an int64_t or a double")
        }
        _ => return None,
    };
    let problem = Problem::new(format!("the entry `{key}` cannot take what SetBlackboard writes"));
    Some(problem.as_warning().with_help(help))
}

/// The type that SkipUnlessUpdated and others like it give to their entry.
const ANY: &str = "BT::Any";

/// A script assigns a string to an entry of this type, `BT::Any` if there is none.
pub(super) fn string_refused(key: &str, of: Option<Type>) -> Problem {
    let help = match of {
        Some(of) => format!(
            "BehaviorTree.CPP throws \"Error assigning a value to entry [{key}] with type [{of}]. The right operand is \
             a string, can't convert to {of}\""
        ),
        None => format!(
            "the port `entry` of a node declares it, and unless a port of another type has written it before, \
             BehaviorTree.CPP throws \"You didn't implement the template specialization of convertFromString for this \
             type: {ANY}\""
        ),
    };
    Problem::new(format!("the entry `{key}` cannot take a string from a script")).as_warning().with_help(help)
}

/// A script that decides something assigns to an entry.
pub(super) fn assigned_condition() -> Problem {
    let problem = Problem::new("the `=` of this condition assigns; it does not compare").as_warning();
    problem.with_help("`==` compares; the value of an assignment is that of its right side")
}

/// Something happens to an integer that is too large for it.
pub(super) fn large_integer(what: &str) -> Problem {
    let problem = Problem::new(format!("{what} of more than 53 bits")).as_warning();
    problem.with_help(
        "BehaviorTree.CPP throws \"Loss of precision when converting a large integer number to floating point\"",
    )
}

/// A port's value has the wrong type, or cannot be valid.
pub(super) fn port_value(port: &str, message: &str, span: SourceSpan, help: Option<String>) -> Problem {
    Problem::new(format!("the port `{port}`: {message}")).at(span, "not accepted here").with_help_if(help)
}

/// A statement of a script is not separated from the one before it.
pub(super) fn unseparated_statement(span: SourceSpan) -> Problem {
    let problem = Problem::new("there is no `;` before this statement").as_warning().at(span, "a new statement");
    problem.with_help(
        "BehaviorTree.CPP reads this from 4.9.0 on; earlier releases refuse to load the tree, and a line break does not \
         end a statement",
    )
}

/// Only the beginning of a port's value is a number.
pub(super) fn partly_read(port: &str, text: &str, read: &str, span: SourceSpan) -> Problem {
    let problem = Problem::new(format!("the port `{port}`: `{text}` is read as {read}")).as_warning();
    let help = if text.contains(',') { "write a point, not a comma" } else { "write nothing after the number" };
    problem.at(span, "not a number as a whole").with_help(format!(
        "{help}: like BehaviorTree.CPP, this reads the number at the beginning and ignores the rest"
    ))
}

/// An output port whose value is no entry.
pub(super) fn unbraced_output(port: &str, value: &str, span: SourceSpan) -> Problem {
    let problem = Problem::new(format!("the output port `{port}` names no entry")).as_warning();
    problem.at(span, format!("write {{{value}}}")).with_help(format!(
        "BehaviorTree.CPP 4 refuses to write to it: \"setOutput requires a blackboard pointer\"; version 3 wrote to the \
         entry `{value}`"
    ))
}

/// The name that was probably meant, or else all known names, as help. `None` after very many problems, so that a
/// malicious file does not cause endless searching.
pub(super) fn hint<'a>(unknown: &str, known: impl Iterator<Item = &'a str> + Clone, problems: usize) -> Option<String> {
    suggestion(unknown, known.clone(), problems).or_else(|| known_names(known, problems))
}

/// The name that was probably meant, as help.
pub(super) fn suggestion<'a>(unknown: &str, known: impl Iterator<Item = &'a str>, problems: usize) -> Option<String> {
    near(unknown, known, problems).map(|near| format!("did you mean `{near}`?"))
}

/// All known names, as help.
pub(super) fn known_names<'a>(known: impl Iterator<Item = &'a str> + Clone, problems: usize) -> Option<String> {
    (problems < MAX_HINTS && known.clone().next().is_some()).then(|| format!("known names are {}", listed(known)))
}

/// The name that was probably meant.
pub(super) fn near<'a>(unknown: &str, known: impl Iterator<Item = &'a str>, problems: usize) -> Option<&'a str> {
    if problems < MAX_HINTS { nearest(unknown, known) } else { None }
}

/// The names in a sentence; if there are very many, only the first ones.
pub(super) fn listed<'a>(mut names: impl Iterator<Item = &'a str>) -> String {
    let mut quoted: Vec<String> = names.by_ref().take(10).map(|name| format!("`{name}`")).collect();
    quoted.extend(names.next().map(|_| "…".to_owned()));
    quoted.join(", ")
}

/// After this many problems, a file is not read further.
pub(super) const MAX_PROBLEMS: usize = 100_000;

/// The problems found so far.
pub(super) type Problems = Vec<Problem>;
