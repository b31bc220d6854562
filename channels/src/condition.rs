//! Conditions and terms over the variables of a program graph.

use std::cmp::Ordering;
use std::fmt;

use serde::{Deserialize, Serialize};

use crate::{Message, Value};

/// A variable of a program graph, as an index into the graph's variables.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct VariableId(pub(crate) usize);

impl VariableId {
    /// The variable itself as a term.
    #[must_use]
    pub fn term(self) -> Term {
        Term::Variable(self)
    }

    /// Position among the variables of the graph, in the order they were declared.
    #[must_use]
    pub fn index(self) -> usize {
        self.0
    }

    /// Field `m[number]` of the message in the variable, counted from 1, as a term. No graph can be built with field 0.
    #[must_use]
    pub fn field(self, number: usize) -> Term {
        Term::Field(self, number)
    }

    /// What is wrong with the variable in a graph with this many variables.
    pub(crate) fn problem(self, variables: usize) -> Option<String> {
        (self.0 >= variables).then(|| format!("uses variable {} of another graph: it has only {variables}", self.0))
    }
}

/// What a variable holds.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Default)]
pub enum Content {
    /// Nothing yet.
    #[default]
    Nothing,
    /// A value.
    Value(Value),
    /// A message, as a receive action assigns it.
    Message(Message),
}

/// The values of all variables of a graph: an element of Eval(Var).
#[derive(Clone, Debug, PartialEq, Eq, Hash, Default)]
pub struct Evaluation(Vec<Content>);

impl Evaluation {
    /// The evaluation that gives each variable its content, in the order of the graph's variables.
    #[must_use]
    pub fn new(contents: Vec<Content>) -> Self {
        Self(contents)
    }

    /// What a variable holds.
    #[must_use]
    pub fn get(&self, variable: VariableId) -> &Content {
        &self.0[variable.0]
    }

    /// The values of all variables, in the order of the graph's variables.
    #[must_use]
    pub fn contents(&self) -> &[Content] {
        &self.0
    }

    /// Gives a variable new content.
    pub(crate) fn set(&mut self, variable: VariableId, content: Content) {
        self.0[variable.0] = content;
    }
}

/// Something that has a value in an evaluation.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Term {
    /// A constant.
    Constant(Value),
    /// The content of a variable.
    Variable(VariableId),
    /// A field of the message in a variable, counted from 1.
    Field(VariableId, usize),
    /// The sum of two numbers.
    Sum(Box<Term>, Box<Term>),
    /// The difference of two numbers.
    Difference(Box<Term>, Box<Term>),
    /// A message made of values.
    Tuple(Vec<Term>),
}

impl Term {
    /// The term's value. [`Content::Nothing`] if a variable is empty, a field is missing or an operand is not a number.
    #[must_use]
    pub fn evaluate(&self, evaluation: &Evaluation) -> Content {
        match self {
            Self::Constant(value) => Content::Value(value.clone()),
            Self::Variable(variable) => evaluation.get(*variable).clone(),
            Self::Field(variable, number) => match evaluation.get(*variable) {
                Content::Message(message) => message.field(*number).cloned().map_or(Content::Nothing, Content::Value),
                _ => Content::Nothing,
            },
            Self::Sum(a, b) => arithmetic(a, b, evaluation, i64::checked_add, |a, b| a + b),
            Self::Difference(a, b) => arithmetic(a, b, evaluation, i64::checked_sub, |a, b| a - b),
            Self::Tuple(terms) => tuple(terms, evaluation),
        }
    }

    /// The condition that this term and the other are in the given relation.
    #[must_use]
    pub fn compare(self, relation: Relation, other: impl Into<Self>) -> Condition {
        Condition::Compare(self, relation, other.into())
    }

    /// What is wrong with the term in a graph with this many variables.
    pub(crate) fn problem(&self, variables: usize) -> Option<String> {
        match self {
            Self::Constant(_) => None,
            Self::Field(_, 0) => Some("reads field 0 of a message, whose fields are counted from 1".to_owned()),
            Self::Variable(variable) | Self::Field(variable, _) => variable.problem(variables),
            Self::Sum(a, b) | Self::Difference(a, b) => a.problem(variables).or_else(|| b.problem(variables)),
            Self::Tuple(terms) => terms.iter().find_map(|term| term.problem(variables)),
        }
    }

    /// The term with variables written by name.
    fn describe(&self, names: &[String]) -> String {
        match self {
            Self::Constant(value) => value.to_string(),
            Self::Variable(variable) => names[variable.0].clone(),
            Self::Field(variable, number) => format!("{}[{number}]", names[variable.0]),
            Self::Sum(a, b) => format!("{} + {}", a.describe(names), b.describe(names)),
            Self::Difference(a, b) => format!("{} - {}", a.describe(names), b.describe_inside(names)),
            Self::Tuple(terms) => {
                let fields: Vec<String> = terms.iter().map(|term| term.describe(names)).collect();
                format!("[{}]", fields.join(", "))
            }
        }
    }

    /// The term as the right operand of a subtraction: a sum is put in parentheses.
    fn describe_inside(&self, names: &[String]) -> String {
        match self {
            Self::Sum(..) | Self::Difference(..) => format!("({})", self.describe(names)),
            _ => self.describe(names),
        }
    }
}

impl<V: Into<Value>> From<V> for Term {
    fn from(value: V) -> Self {
        Self::Constant(value.into())
    }
}

fn arithmetic(
    a: &Term,
    b: &Term,
    evaluation: &Evaluation,
    of_integers: fn(i64, i64) -> Option<i64>,
    of_reals: fn(f64, f64) -> f64,
) -> Content {
    let (Content::Value(a), Content::Value(b)) = (a.evaluate(evaluation), b.evaluate(evaluation)) else {
        return Content::Nothing;
    };
    if let (Value::Int(a), Value::Int(b)) = (&a, &b) {
        return of_integers(*a, *b).map_or(Content::Nothing, |number| Content::Value(Value::Int(number)));
    }
    match (a.as_number(), b.as_number()) {
        (Some(a), Some(b)) => Content::Value(Value::Real(of_reals(a, b))),
        _ => Content::Nothing,
    }
}

fn tuple(terms: &[Term], evaluation: &Evaluation) -> Content {
    let values: Option<Vec<Value>> = terms
        .iter()
        .map(|term| match term.evaluate(evaluation) {
            Content::Value(value) => Some(value),
            _ => None,
        })
        .collect();
    values.map_or(Content::Nothing, |values| Content::Message(Message::new(values)))
}

/// A relational operator.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Relation {
    /// `=`
    Equal,
    /// `!=`: not equal; it also holds between values of different types.
    NotEqual,
    /// `<`
    Less,
    /// `<=`
    LessOrEqual,
    /// `>`
    Greater,
    /// `>=`
    GreaterOrEqual,
}

impl Relation {
    /// Whether the relation holds. Integers and reals compare as numbers, exactly; values of other types have no order.
    /// Between values of different types, every relation but `!=` is false.
    #[must_use]
    pub fn holds(self, a: &Value, b: &Value) -> bool {
        let equal = || if a.is_number() && b.is_number() { a.order(b) == Some(Ordering::Equal) } else { a == b };
        match self {
            Self::Equal => equal(),
            Self::NotEqual => !equal(),
            Self::Less => a.order(b) == Some(Ordering::Less),
            Self::LessOrEqual => a.order(b).is_some_and(Ordering::is_le),
            Self::Greater => a.order(b) == Some(Ordering::Greater),
            Self::GreaterOrEqual => a.order(b).is_some_and(Ordering::is_ge),
        }
    }
}

impl fmt::Display for Relation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Equal => "=",
            Self::NotEqual => "≠",
            Self::Less => "<",
            Self::LessOrEqual => "≤",
            Self::Greater => ">",
            Self::GreaterOrEqual => "≥",
        })
    }
}

/// A Boolean condition over variables: an element of Cond(Var).
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Condition {
    /// Always holds.
    True,
    /// Holds if the condition does not.
    Not(Box<Condition>),
    /// Holds if all of them hold.
    And(Vec<Condition>),
    /// Holds if at least one of them holds.
    Or(Vec<Condition>),
    /// Holds if the terms' values are in the relation. A term without a value makes every relation but `!=` false.
    Compare(Term, Relation, Term),
}

impl Condition {
    /// Whether the evaluation satisfies the condition, η ⊨ g.
    #[must_use]
    pub fn holds(&self, evaluation: &Evaluation) -> bool {
        match self {
            Self::True => true,
            Self::Not(condition) => !condition.holds(evaluation),
            Self::And(conditions) => conditions.iter().all(|condition| condition.holds(evaluation)),
            Self::Or(conditions) => conditions.iter().any(|condition| condition.holds(evaluation)),
            Self::Compare(a, relation, b) => match (a.evaluate(evaluation), b.evaluate(evaluation)) {
                (Content::Value(a), Content::Value(b)) => relation.holds(&a, &b),
                (a, b) => match relation {
                    Relation::Equal => a == b && a != Content::Nothing,
                    Relation::NotEqual => a != b || a == Content::Nothing,
                    _ => false,
                },
            },
        }
    }

    /// The conjunction of both conditions.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self::And(vec![self, other])
    }

    /// The disjunction of both conditions.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        Self::Or(vec![self, other])
    }

    /// The negation of the condition.
    #[must_use]
    pub fn negated(self) -> Self {
        Self::Not(Box::new(self))
    }

    /// What is wrong with the condition in a graph with this many variables.
    pub(crate) fn problem(&self, variables: usize) -> Option<String> {
        match self {
            Self::True => None,
            Self::Not(condition) => condition.problem(variables),
            Self::And(conditions) | Self::Or(conditions) => {
                conditions.iter().find_map(|condition| condition.problem(variables))
            }
            Self::Compare(a, _, b) => a.problem(variables).or_else(|| b.problem(variables)),
        }
    }

    /// The condition with variables written by name.
    #[must_use]
    pub(crate) fn describe(&self, names: &[String]) -> String {
        let join = |conditions: &[Self], word: &str| {
            let parts: Vec<String> = conditions.iter().map(|condition| condition.describe_inside(names)).collect();
            parts.join(word)
        };
        match self {
            Self::True => "true".to_owned(),
            Self::Not(condition) => format!("not {}", condition.describe_inside(names)),
            Self::And(conditions) => join(conditions, " and "),
            Self::Or(conditions) => join(conditions, " or "),
            Self::Compare(a, relation, b) => format!("{} {relation} {}", a.describe(names), b.describe(names)),
        }
    }

    fn describe_inside(&self, names: &[String]) -> String {
        match self {
            Self::And(_) | Self::Or(_) => format!("({})", self.describe(names)),
            _ => self.describe(names),
        }
    }
}

/// `x := term`, one assignment of an action's effect.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Assignment {
    /// The variable that changes.
    pub variable: VariableId,
    /// Its new content, evaluated before the assignment.
    pub term: Term,
}

impl Assignment {
    pub(crate) fn describe(&self, names: &[String]) -> String {
        format!("{} := {}", names[self.variable.0], self.term.describe(names))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const M: VariableId = VariableId(0);

    fn holds(condition: &Condition, content: Content) -> bool {
        condition.holds(&Evaluation::new(vec![content]))
    }

    #[test]
    fn integers_and_reals_compare_as_numbers() {
        assert!(Relation::GreaterOrEqual.holds(&Value::Real(20.0), &Value::Int(20)));
        assert!(Relation::Equal.holds(&Value::Real(20.0), &Value::Int(20)));
        assert!(!Relation::Less.holds(&Value::Real(20.0), &Value::Int(20)));
    }

    #[test]
    fn numbers_compare_exactly_whatever_their_size() {
        let all = |relation: Relation, pairs: &[(Value, Value)]| pairs.iter().all(|(a, b)| relation.holds(a, b));
        let (int, real) = (Value::Int, Value::Real);
        assert!(all(
            Relation::Equal,
            &[
                (int(1 << 60), real(1_152_921_504_606_846_976.0)),
                (real(-9_223_372_036_854_775_808.0), int(i64::MIN)),
                (real(-0.0), int(0)),
            ]
        ));
        assert!(all(Relation::NotEqual, &[(int(9_007_199_254_740_993), real(9_007_199_254_740_992.0))]));
        assert!(all(
            Relation::Less,
            &[
                (int(1_700_000_000_000_000_001), int(1_700_000_000_000_000_002)),
                (int(9_007_199_254_740_992), int(9_007_199_254_740_993)),
                (real(9_007_199_254_740_992.0), int(9_007_199_254_740_993)),
                (int(i64::MAX), real(9_223_372_036_854_775_808.0)),
                (int(i64::MAX), real(f64::INFINITY)),
                (real(f64::NEG_INFINITY), int(i64::MIN)),
                (int(-3), real(-2.5)),
                (real(-2.5), int(-2)),
                (real(2.5), int(3)),
            ]
        ));
        for relation in [Relation::Equal, Relation::LessOrEqual, Relation::GreaterOrEqual] {
            assert!(!relation.holds(&int(0), &real(f64::NAN)));
        }
    }

    #[test]
    fn symbols_have_no_order() {
        let (a, b) = (Value::symbol("a"), Value::symbol("a"));
        assert!(Relation::Equal.holds(&a, &b));
        assert!(!Relation::LessOrEqual.holds(&a, &b));
    }

    #[test]
    fn a_missing_field_makes_every_relation_but_inequality_false() {
        let message = Content::Message(Message::symbols(["ok"]));
        for relation in [Relation::Equal, Relation::Less, Relation::LessOrEqual, Relation::Greater] {
            assert!(!holds(&M.field(2).compare(relation, 20), message.clone()), "{relation}");
        }
        assert!(holds(&M.field(2).compare(Relation::NotEqual, 20), message));
    }

    #[test]
    fn terms_add_and_subtract() {
        let timer = Evaluation::new(vec![Content::Value(10.into())]);
        let one_less = Term::Difference(Box::new(M.term()), Box::new(1.into()));
        assert_eq!(one_less.evaluate(&timer), Content::Value(9.into()));
        let overflow = Term::Sum(Box::new(M.term()), Box::new(i64::MAX.into()));
        assert_eq!(overflow.evaluate(&timer), Content::Nothing);
    }
}
