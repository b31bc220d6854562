//! The parameters of faults, read from a scenario file and checked.

use std::collections::BTreeMap;
use std::time::Duration;

use diagnostics::document::{Field, Key, Referent, Table, Written};
use diagnostics::{Span, Spanned};
use maps::{Point, Pose};
use serde_json::{Value, json};

use crate::coordinates::{POINT, POSE};

/// A parameter of a kind of fault.
#[derive(Clone, Copy, Debug)]
pub struct Parameter {
    /// The key in a scenario file. It ends with the unit, if there is one.
    pub name: &'static str,
    /// A description, on one line.
    pub about: &'static str,
    /// The allowed values.
    pub domain: ArgumentDomain,
    /// The default.
    pub default: ArgumentDefault,
}

/// The allowed values of a parameter.
#[derive(Clone, Copy, Debug)]
pub enum ArgumentDomain {
    /// Numbers in this range, both ends included.
    Numbers(f64, f64),
    /// Whole numbers in this range, both ends included.
    Whole(u64, u64),
    /// Any text.
    Text,
    /// The name of one of these.
    Name(Referent),
    /// One of these names.
    OneOf(&'static [&'static str]),
    /// True or false.
    Flag,
    /// A point: x and y in meters, in the `map` frame.
    Point,
    /// A pose: x and y in meters, in the `map` frame, and a heading in degrees.
    Pose,
    /// Several points.
    Points,
}

/// The value of a parameter that the file does not set.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ArgumentDefault {
    /// None: the file must set it.
    Required,
    /// No value: the parameter is optional.
    Absent,
    /// This number.
    Number(f64),
    /// This whole number.
    Whole(u64),
    /// This text.
    Text(&'static str),
    /// True or false.
    Flag(bool),
}

/// The value of a parameter.
#[derive(Clone, Debug, PartialEq)]
pub enum ArgumentValue {
    /// A number.
    Number(f64),
    /// A whole number.
    Whole(u64),
    /// A text.
    Text(String),
    /// True or false.
    Flag(bool),
    /// A point, in meters.
    Point(Point),
    /// A pose.
    Pose(Pose),
    /// Several points, in meters.
    Points(Vec<Point>),
}

impl Parameter {
    pub(super) const fn required(name: &'static str, about: &'static str, domain: ArgumentDomain) -> Self {
        Self { name, about, domain, default: ArgumentDefault::Required }
    }

    /// An optional number.
    pub(super) const fn number(name: &'static str, about: &'static str, least: f64, most: f64, default: f64) -> Self {
        Self { name, about, domain: ArgumentDomain::Numbers(least, most), default: ArgumentDefault::Number(default) }
    }

    /// An optional whole number.
    pub(super) const fn whole(name: &'static str, about: &'static str, least: u64, most: u64, default: u64) -> Self {
        Self { name, about, domain: ArgumentDomain::Whole(least, most), default: ArgumentDefault::Whole(default) }
    }

    /// An optional text.
    pub(super) const fn text(name: &'static str, about: &'static str, default: &'static str) -> Self {
        Self { name, about, domain: ArgumentDomain::Text, default: ArgumentDefault::Text(default) }
    }

    /// A flag that is false unless it is set.
    pub(super) const fn flag(name: &'static str, about: &'static str) -> Self {
        Self { name, about, domain: ArgumentDomain::Flag, default: ArgumentDefault::Flag(false) }
    }

    /// The parameter's unit, with which its name ends; `None` for a plain number or a name.
    #[must_use]
    pub fn unit(&self) -> Option<&'static str> {
        let units = [
            ("_mps", "m/s"),
            ("_radps", "rad/s"),
            ("_pct", "%"),
            ("_deg", "°"),
            ("deg_per_m", "°/m"),
            ("_m", "m"),
            ("_s", "s"),
        ];
        units.iter().find(|(ending, _)| self.name.ends_with(ending)).map(|(_, unit)| *unit)
    }

    /// The parameter as a key of its fault.
    #[must_use]
    pub fn key(&self) -> Key {
        let key = Key::all(|table| self.read(table)).pop();
        key.expect("its reader asks for one key")
    }

    /// Reads its value from a fault's table.
    fn read(&self, table: Table<'_>) -> Option<Spanned<ArgumentValue>> {
        let field = read_value(table, self).about(&sentence(self.about));
        if self.default == ArgumentDefault::Required {
            return field.required();
        }
        let span = table.span().clone();
        let default = self.default.value().map(|value| Spanned { value, span });
        field.rules(|| json!({ "default": self.default.written() })).optional().or(default)
    }
}

/// A phrase as a sentence.
#[must_use]
pub fn sentence(phrase: &str) -> String {
    let mut rest = phrase.chars();
    rest.next().map_or_else(String::new, |first| format!("{}{}.", first.to_uppercase(), rest.as_str()))
}

impl ArgumentValue {
    /// The value as recorded: angles in degrees.
    #[must_use]
    pub fn record(&self) -> recording::Argument {
        use recording::Argument;
        let point = |point: &Point| vec![point.x, point.y];
        match self {
            Self::Number(number) => Argument::Number(*number),
            Self::Whole(number) => Argument::Whole(*number),
            Self::Text(text) => Argument::Text(text.clone()),
            Self::Flag(flag) => Argument::Flag(*flag),
            Self::Point(at) => Argument::Place(point(at)),
            Self::Pose(at) => Argument::Place(vec![at.translation.x, at.translation.y, maps::heading(at).to_degrees()]),
            Self::Points(all) => Argument::Places(all.iter().map(point).collect()),
        }
    }
}

/// The values of a fault's parameters.
#[derive(Clone, Debug)]
pub struct Arguments {
    given: BTreeMap<&'static str, Spanned<ArgumentValue>>,
    /// The location of the fault, for problems with missing arguments.
    span: Span,
}

impl Arguments {
    /// Reads the parameters from a fault's table. `None` after recording its problems.
    pub(super) fn read(table: Table<'_>, parameters: &[Parameter]) -> Option<Self> {
        let mut given = BTreeMap::new();
        let mut complete = true;
        for parameter in parameters {
            let value = parameter.read(table);
            complete &= value.is_some() || parameter.default != ArgumentDefault::Required;
            given.extend(value.map(|value| (parameter.name, value)));
        }
        complete.then(|| Self { given, span: table.span().clone() })
    }

    /// The given arguments, by name.
    pub fn iter(&self) -> impl Iterator<Item = (&'static str, &ArgumentValue)> {
        self.given.iter().map(|(name, argument)| (*name, &argument.value))
    }

    /// The location of the fault in its file.
    pub fn span(&self) -> &Span {
        &self.span
    }

    fn get(&self, name: &str) -> &ArgumentValue {
        &self.given.get(name).expect("required arguments and those with a default are present").value
    }

    pub(super) fn number(&self, name: &str) -> f64 {
        let ArgumentValue::Number(number) = self.get(name) else { unreachable!("`{name}` is a number") };
        *number
    }

    pub(super) fn whole(&self, name: &str) -> usize {
        let ArgumentValue::Whole(number) = self.get(name) else { unreachable!("`{name}` is a whole number") };
        usize::try_from(*number).unwrap_or(usize::MAX)
    }

    pub(super) fn seconds(&self, name: &str) -> Duration {
        Duration::from_secs_f64(self.number(name))
    }

    /// An angle that the file gives in degrees, in radians.
    pub(super) fn radians(&self, name: &str) -> f64 {
        self.number(name).to_radians()
    }

    pub(super) fn text(&self, name: &str) -> &str {
        let ArgumentValue::Text(text) = self.get(name) else { unreachable!("`{name}` is a string") };
        text
    }

    /// Whether an optional argument is given.
    pub(super) fn has(&self, name: &str) -> bool {
        self.given.contains_key(name)
    }

    /// A text and its location.
    pub(super) fn name(&self, name: &str) -> Spanned<String> {
        Spanned { value: self.text(name).to_owned(), span: self.span_of(name) }
    }

    /// The location of an argument; the fault's location if the file does not set it.
    fn span_of(&self, name: &str) -> Span {
        self.given.get(name).map_or(&self.span, |argument| &argument.span).clone()
    }

    pub(super) fn flag(&self, name: &str) -> bool {
        matches!(self.get(name), ArgumentValue::Flag(true))
    }

    pub(super) fn point(&self, name: &str) -> Point {
        let ArgumentValue::Point(point) = self.get(name) else { unreachable!("`{name}` is a point") };
        *point
    }

    pub(super) fn pose(&self, name: &str) -> Pose {
        let ArgumentValue::Pose(pose) = self.get(name) else { unreachable!("`{name}` is a pose") };
        *pose
    }

    pub(super) fn spanned_pose(&self, name: &str) -> Spanned<Pose> {
        Spanned { value: self.pose(name), span: self.span_of(name) }
    }

    pub(super) fn points(&self, name: &str) -> &[Point] {
        let ArgumentValue::Points(points) = self.get(name) else { unreachable!("`{name}` is several points") };
        points
    }
}

impl ArgumentDefault {
    fn value(self) -> Option<ArgumentValue> {
        match self {
            Self::Required | Self::Absent => None,
            Self::Number(number) => Some(ArgumentValue::Number(number)),
            Self::Whole(number) => Some(ArgumentValue::Whole(number)),
            Self::Text(text) => Some(ArgumentValue::Text(text.to_owned())),
            Self::Flag(flag) => Some(ArgumentValue::Flag(flag)),
        }
    }

    /// `null` for none.
    fn written(self) -> Value {
        match self {
            Self::Required | Self::Absent => Value::Null,
            Self::Number(number) => number.written(),
            Self::Whole(number) => json!(number),
            Self::Text(text) => json!(text),
            Self::Flag(flag) => json!(flag),
        }
    }
}

fn read_value<'d>(table: Table<'d>, parameter: &Parameter) -> Field<'d, Spanned<ArgumentValue>> {
    let key = parameter.name;
    match parameter.domain {
        ArgumentDomain::Numbers(least, most) => {
            table.number(key).within(least..=most).map(ArgumentValue::Number).spanned()
        }
        ArgumentDomain::Whole(least, most) => {
            table.get::<u64>(key).within(least..=most).map(ArgumentValue::Whole).spanned()
        }
        ArgumentDomain::Text => table.text(key).map(ArgumentValue::Text).spanned(),
        ArgumentDomain::Name(what) => table.text(key).refers_to(what).map(ArgumentValue::Text).spanned(),
        ArgumentDomain::OneOf(names) => {
            let choices: Vec<(&str, String)> = names.iter().map(|name| (*name, (*name).to_owned())).collect();
            table.one_of(key, &choices).map(ArgumentValue::Text).spanned()
        }
        ArgumentDomain::Flag => table.boolean(key).map(ArgumentValue::Flag).spanned(),
        ArgumentDomain::Point => {
            table.get::<[f64; 2]>(key).words(POINT).map(|[x, y]| ArgumentValue::Point(Point::new(x, y))).spanned()
        }
        ArgumentDomain::Pose => table
            .get::<[f64; 3]>(key)
            .words(POSE)
            .map(|[x, y, degrees]| ArgumentValue::Pose(maps::pose(x, y, degrees.to_radians())))
            .spanned(),
        ArgumentDomain::Points => {
            let points =
                table.get::<Vec<[f64; 2]>>(key).check(|points| !points.is_empty(), "contain at least one point");
            points
                .rules(crate::coordinates::points)
                .rules(|| json!({ "minItems": 1 }))
                .map(|points| ArgumentValue::Points(points.iter().map(|[x, y]| Point::new(*x, *y)).collect()))
                .spanned()
        }
    }
}
