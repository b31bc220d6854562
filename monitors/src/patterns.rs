//! The usual patterns of requirements, after Dwyer, Avrunin and Corbett ("Patterns in property specifications for
//! finite-state verification", ICSE 1999), as formulas for this language.
//!
//! Their own formulas for LTL are about states. Here an event holds from its message until the next one on its channel,
//! and is checked when a message comes: `Q and not R` would be false at each Q that follows an R. A test compares these
//! formulas with definitions that look at the messages themselves.

use std::fmt;

/// What is required of the messages in a scope.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pattern {
    /// No message is P.
    Absence,
    /// A message is P.
    Existence,
    /// Each message on P's channel is P.
    Universality,
    /// Before the first P comes an S.
    Precedence,
    /// After each P comes an S.
    Response,
}

/// Where a pattern applies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scope {
    /// In the whole run.
    Globally,
    /// Up to the first R; nothing is required if there is none.
    Before,
    /// From the first Q on.
    After,
    /// From each Q to the next R; nothing is required if none follows.
    Between,
    /// From each Q to the next R, or to the end.
    AfterUntil,
}

/// The events of a pattern, as they are written.
#[derive(Clone, Copy, Debug)]
pub struct PatternEvents<'a> {
    /// What the pattern is about.
    pub p: &'a str,
    /// What precedes or answers it.
    pub s: &'a str,
    /// What begins the scope.
    pub q: &'a str,
    /// What ends the scope.
    pub r: &'a str,
}

impl Pattern {
    /// All patterns.
    pub const ALL: [Self; 5] = [Self::Absence, Self::Existence, Self::Universality, Self::Precedence, Self::Response];

    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Absence => "absence",
            Self::Existence => "existence",
            Self::Universality => "universality",
            Self::Precedence => "precedence",
            Self::Response => "response",
        }
    }

    /// Its meaning in a scope, in words.
    #[must_use]
    pub fn about(self) -> &'static str {
        match self {
            Self::Absence => "P never comes",
            Self::Existence => "P comes",
            Self::Universality => "each message on P's channel is P",
            Self::Precedence => "P comes only after S",
            Self::Response => "after each P comes an S",
        }
    }

    /// Whether it is about two events, P and S.
    #[must_use]
    pub fn has_other(self) -> bool {
        matches!(self, Self::Precedence | Self::Response)
    }

    /// Its formula. P, Q, R and S are different events: no message is two of them; and with
    /// [`Universality`](Self::Universality), P's channel is neither Q's nor R's.
    #[must_use]
    pub fn formula(self, scope: Scope, events: PatternEvents<'_>) -> String {
        let mut formula = String::new();
        for word in self.template(scope).split_inclusive(|sign: char| !sign.is_alphanumeric()) {
            let (name, rest) = word.split_at(word.find(|sign: char| !sign.is_alphanumeric()).unwrap_or(word.len()));
            formula += match name {
                "P" => events.p,
                "S" => events.s,
                "Q" => events.q,
                "R" => events.r,
                word => word,
            };
            formula += rest;
        }
        formula
    }

    fn template(self, scope: Scope) -> &'static str {
        use Pattern::{Absence, Existence, Precedence, Response, Universality};
        use Scope::{After, AfterUntil, Before, Between, Globally};
        match (self, scope) {
            (Absence, Globally) => "always not P",
            (Absence, Before) => "eventually R implies not P until R",
            (Absence, After) => "always (Q implies always not P)",
            (Absence, Between) => "always (Q and eventually R implies not P until R)",
            (Absence, AfterUntil) => "always (Q implies not P until R or always not P)",
            (Existence, Globally) => "eventually P",
            (Existence, Before) => "not R until P or always not R",
            (Existence, After) => "always not Q or eventually (Q and eventually P)",
            (Existence, Between) => "always (Q implies not R until P or always not R)",
            (Existence, AfterUntil) => "always (Q implies not R until P)",
            (Universality, Globally) => "always P",
            (Universality, Before) => "eventually R implies P until R",
            (Universality, After) => "always (Q implies always P)",
            (Universality, Between) => "always (Q and eventually R implies P until R)",
            (Universality, AfterUntil) => "always (Q implies P until R or always P)",
            (Precedence, Globally) => "not P until S or always not P",
            (Precedence, Before) => "eventually R implies not P until (S or R)",
            (Precedence, After) => "always not Q or not Q until (Q and (not P until S or always not P))",
            (Precedence, Between) => "always (Q and eventually R implies not P until (S or R))",
            (Precedence, AfterUntil) => "always (Q implies not P until (S or R) or always not P)",
            (Response, Globally) => "always (P implies eventually S)",
            (Response, Before) => "eventually R implies (P implies not R until S) until R",
            (Response, After) => "always (Q implies always (P implies eventually S))",
            (Response, Between) => "always (Q and eventually R implies (P implies not R until S) until R)",
            (Response, AfterUntil) => {
                "always (Q implies (P implies not R until S) until R or always (P implies not R until S))"
            }
        }
    }
}

impl Scope {
    /// All scopes.
    pub const ALL: [Self; 5] = [Self::Globally, Self::Before, Self::After, Self::Between, Self::AfterUntil];
}

impl fmt::Display for Scope {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Globally => "globally",
            Self::Before => "before R",
            Self::After => "after Q",
            Self::Between => "between Q and R",
            Self::AfterUntil => "after Q until R",
        })
    }
}
