//! The elements of SCXML, their allowed contents and their attributes (SCXML 3 to 6).

/// The rules for an element.
pub(super) struct Rule {
    pub(super) element: &'static str,
    /// Required attributes.
    pub(super) required: &'static [&'static str],
    /// Optional attributes.
    pub(super) optional: &'static [&'static str],
    pub(super) children: &'static [&'static str],
    /// Whether it may contain executable content.
    pub(super) executable: bool,
    /// Whether it may contain text.
    pub(super) text: bool,
}

const fn rule(element: &'static str) -> Rule {
    Rule { element, required: &[], optional: &[], children: &[], executable: false, text: false }
}

/// Elements of executable content.
pub(super) const EXECUTABLE: [&str; 8] = ["raise", "if", "foreach", "log", "assign", "script", "send", "cancel"];

pub(super) const RULES: [Rule; 26] = [
    Rule {
        optional: &["version", "initial", "name", "datamodel", "binding"],
        children: &["state", "parallel", "final", "datamodel", "script"],
        ..rule("scxml")
    },
    Rule {
        optional: &["id", "initial"],
        children: &[
            "onentry",
            "onexit",
            "transition",
            "initial",
            "state",
            "parallel",
            "final",
            "history",
            "datamodel",
            "invoke",
        ],
        ..rule("state")
    },
    Rule {
        optional: &["id"],
        children: &["onentry", "onexit", "transition", "state", "parallel", "history", "datamodel", "invoke"],
        ..rule("parallel")
    },
    Rule { optional: &["id"], children: &["onentry", "onexit", "donedata"], ..rule("final") },
    Rule { optional: &["id", "type"], children: &["transition"], ..rule("history") },
    Rule { children: &["transition"], ..rule("initial") },
    Rule { optional: &["event", "cond", "target", "type"], executable: true, ..rule("transition") },
    Rule { executable: true, ..rule("onentry") },
    Rule { executable: true, ..rule("onexit") },
    Rule { children: &["data"], ..rule("datamodel") },
    Rule { required: &["id"], optional: &["expr", "src"], text: true, ..rule("data") },
    Rule { children: &["content", "param"], ..rule("donedata") },
    Rule { required: &["event"], ..rule("raise") },
    Rule { required: &["cond"], children: &["elseif", "else"], executable: true, ..rule("if") },
    Rule { required: &["cond"], ..rule("elseif") },
    rule("else"),
    Rule { required: &["array", "item"], optional: &["index"], executable: true, ..rule("foreach") },
    Rule { optional: &["label", "expr"], ..rule("log") },
    Rule { required: &["location"], optional: &["expr"], text: true, ..rule("assign") },
    Rule { optional: &["src"], text: true, ..rule("script") },
    Rule {
        optional: &[
            "event",
            "eventexpr",
            "target",
            "targetexpr",
            "type",
            "typeexpr",
            "id",
            "idlocation",
            "delay",
            "delayexpr",
            "namelist",
        ],
        children: &["content", "param"],
        ..rule("send")
    },
    Rule { optional: &["sendid", "sendidexpr"], ..rule("cancel") },
    Rule { required: &["name"], optional: &["expr", "location"], ..rule("param") },
    Rule { optional: &["expr"], text: true, ..rule("content") },
    Rule {
        optional: &["type", "typeexpr", "src", "srcexpr", "id", "idlocation", "namelist", "autoforward"],
        children: &["param", "content", "finalize"],
        ..rule("invoke")
    },
    Rule { executable: true, ..rule("finalize") },
];

impl Rule {
    pub(super) fn of(element: &str) -> Option<&'static Self> {
        RULES.iter().find(|rule| rule.element == element)
    }

    pub(super) fn may_contain(&self, element: &str) -> bool {
        self.children.contains(&element) || self.executable && EXECUTABLE.contains(&element)
    }

    /// The allowed contents of the element, for messages.
    pub(super) fn contents(&self) -> Vec<&'static str> {
        let executable: &[&str] = if self.executable { &EXECUTABLE } else { &[] };
        self.children.iter().chain(executable).copied().collect()
    }

    pub(super) fn attributes(&self) -> Vec<&'static str> {
        self.required.iter().chain(self.optional).copied().collect()
    }
}

/// The names of the elements that may be in one with this name, or in none.
#[must_use]
pub fn elements_in(parent: Option<&str>) -> Vec<&'static str> {
    match parent {
        None => vec!["scxml"],
        Some(parent) => Rule::of(parent).map(Rule::contents).unwrap_or_default(),
    }
}

/// The attributes of an element, each with whether it is required.
pub fn attributes_of(element: &str) -> impl Iterator<Item = (&'static str, bool)> {
    let rule = Rule::of(element).into_iter();
    rule.flat_map(|rule| rule.attributes().into_iter().map(|name| (name, rule.required.contains(&name))))
}

/// Mutually exclusive attributes, by element.
pub(super) const EXCLUSIVE: [(&str, [&str; 2]); 11] = [
    ("send", ["event", "eventexpr"]),
    ("send", ["target", "targetexpr"]),
    ("send", ["type", "typeexpr"]),
    ("send", ["id", "idlocation"]),
    ("send", ["delay", "delayexpr"]),
    ("cancel", ["sendid", "sendidexpr"]),
    ("invoke", ["type", "typeexpr"]),
    ("invoke", ["src", "srcexpr"]),
    ("invoke", ["id", "idlocation"]),
    ("data", ["src", "expr"]),
    ("param", ["expr", "location"]),
];
