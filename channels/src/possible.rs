//! What a place of a system may hold in some run, as far as texts are concerned: an answer to "what can this be
//! compared with?" that needs no run.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use crate::{FieldKind, Value};

/// The number of a text that something outside the system chooses, anew in each message.
pub type Choice = usize;

/// With more texts than this in one place, they count as [open](Possible::is_open). Chosen, not measured.
const MOST: usize = 256;

/// A deeper nesting than this is not distinguished from this one.
const DEEPEST: u8 = 4;

/// Everything that a place may hold: more than it really does, never less.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Possible {
    /// The choices of which it may be the text.
    pub chosen: BTreeSet<Choice>,
    /// The choices of which a part of it, an item or a member, may be the text.
    pub inside: BTreeSet<Choice>,
    /// The texts that it, or a part of it, may be; none if it is open.
    pub texts: BTreeSet<Arc<str>>,
    /// Whether it may also be a text that is not known: one that is computed, for instance.
    pub is_open: bool,
    /// Whether it, or a part of it, may be a number or a Boolean.
    pub is_number: bool,
    /// How deep lists and objects in it may be nested; 0 if it is neither.
    pub depth: u8,
}

impl Possible {
    /// A number or a Boolean.
    #[must_use]
    pub fn number() -> Self {
        Self { is_number: true, ..Self::default() }
    }

    /// A text that is not known.
    #[must_use]
    pub fn open() -> Self {
        Self { is_open: true, ..Self::default() }
    }

    /// Anything but a text that is chosen.
    #[must_use]
    pub fn anything() -> Self {
        Self { is_open: true, is_number: true, ..Self::default() }
    }

    /// One of these texts.
    #[must_use]
    pub fn texts<T: Into<Arc<str>>>(texts: impl IntoIterator<Item = T>) -> Self {
        let mut all = Self { texts: texts.into_iter().map(Into::into).collect(), ..Self::default() };
        all.widen();
        all
    }

    /// The text of this choice.
    #[must_use]
    pub fn choice(choice: Choice) -> Self {
        Self { chosen: BTreeSet::from([choice]), ..Self::default() }
    }

    /// Any value of a kind. Symbols are seen as texts, as machines see them.
    #[must_use]
    pub fn of_kind(kind: &FieldKind) -> Self {
        match kind {
            FieldKind::Symbol(symbols) => Self::texts(symbols.iter().map(|symbol| symbol.name())),
            FieldKind::Bool | FieldKind::Int | FieldKind::Real => Self::number(),
            FieldKind::Text => Self::open(),
            FieldKind::Optional(kind) => Self::of_kind(kind),
            FieldKind::List(kind) => Self::of_kind(kind).around(),
        }
    }

    /// Whether it, or a part of it, may be a text that is chosen.
    #[must_use]
    pub fn has_choice(&self) -> bool {
        !self.chosen.is_empty() || !self.inside.is_empty()
    }

    /// All choices of which it, or a part of it, may be the text.
    pub fn choices(&self) -> impl Iterator<Item = Choice> {
        self.chosen.iter().chain(&self.inside).copied()
    }

    /// Adds what the other one may be. Returns whether anything is new.
    pub fn join(&mut self, other: &Self) -> bool {
        let size =
            |all: &Self| (all.chosen.len(), all.inside.len(), all.texts.len(), all.is_open, all.is_number, all.depth);
        let before = size(self);
        self.chosen.extend(&other.chosen);
        self.inside.extend(&other.inside);
        self.texts.extend(other.texts.iter().cloned());
        self.is_open |= other.is_open;
        self.is_number |= other.is_number;
        self.depth = self.depth.max(other.depth);
        self.widen();
        before != size(self)
    }

    /// A set of texts that grows for ever would never be found.
    fn widen(&mut self) {
        self.is_open |= self.texts.len() > MOST;
        if self.is_open {
            self.texts.clear();
        }
    }

    /// What a structure with this part may be.
    #[must_use]
    pub fn around(mut self) -> Self {
        self.inside.append(&mut self.chosen);
        self.depth = DEEPEST.min(self.depth + 1);
        self
    }

    /// What a part of it may be.
    #[must_use]
    pub fn part(mut self) -> Self {
        self.chosen.extend(&self.inside);
        if self.depth < DEEPEST {
            self.depth = self.depth.saturating_sub(1);
        }
        self
    }
}

/// What texts that are chosen are compared with: a proof has to try each of these texts, and enough others.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Comparisons {
    /// The texts with which each choice is compared.
    pub with: BTreeMap<Choice, BTreeSet<Arc<str>>>,
    /// The choices that are compared with each other, the smaller one first.
    pub among: BTreeSet<(Choice, Choice)>,
}

/// Why a comparison distinguishes more texts than can be tried.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Beyond {
    /// With a text that is not known.
    Open,
    /// With a number, to which the text is converted.
    Number,
    /// With a list or an object, which is converted to a text.
    Structure,
}

impl Comparisons {
    /// Notes that two values are compared by `==` or `!=`. `converts` means that a number is compared with the number
    /// in a text.
    ///
    /// # Errors
    /// If one may be a text that is chosen, and the other something of which there are too many.
    pub fn compare(&mut self, one: &Possible, other: &Possible, converts: bool) -> Result<(), Beyond> {
        for (this, that) in [(one, other), (other, one)] {
            let is_text = that.has_choice() || that.is_open || !that.texts.is_empty();
            if converts && is_text && (!this.inside.is_empty() || !that.chosen.is_empty() && this.depth > 0) {
                return Err(Beyond::Structure);
            }
            if this.chosen.is_empty() {
                continue;
            }
            if that.is_open {
                return Err(Beyond::Open);
            }
            if that.is_number && converts {
                return Err(Beyond::Number);
            }
            for choice in &this.chosen {
                self.with.entry(*choice).or_default().extend(that.texts.iter().cloned());
                self.among.extend(that.chosen.iter().map(|other| (*choice.min(other), *choice.max(other))));
            }
        }
        Ok(())
    }

    /// Adds the other ones. Returns whether anything is new.
    pub fn join(&mut self, other: Self) -> bool {
        let mut is_new = false;
        for (choice, texts) in other.with {
            let known = self.with.entry(choice).or_default();
            let before = known.len();
            known.extend(texts);
            is_new |= known.len() > before;
        }
        let before = self.among.len();
        self.among.extend(other.among);
        is_new || self.among.len() > before
    }
}

/// What one of these may be.
impl FromIterator<Self> for Possible {
    fn from_iter<I: IntoIterator<Item = Self>>(all: I) -> Self {
        let both = |mut one: Self, other| {
            one.join(&other);
            one
        };
        all.into_iter().reduce(both).unwrap_or_default()
    }
}

/// What a constant may be.
impl From<&Value> for Possible {
    fn from(value: &Value) -> Self {
        match value {
            Value::Symbol(symbol) => Self::texts([symbol.name()]),
            Value::Text(text) => Self::texts([Arc::clone(text)]),
            Value::Bool(_) | Value::Int(_) | Value::Real(_) => Self::number(),
            Value::List(items) => items.iter().map(Self::from).collect::<Self>().around(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chosen_text_may_be_compared_with_known_texts_and_with_chosen_ones() {
        let mut comparisons = Comparisons::default();
        let known = Possible::texts(["a", "b"]);
        assert_eq!(comparisons.compare(&Possible::choice(0), &known, true), Ok(()));
        assert_eq!(comparisons.compare(&Possible::choice(1), &Possible::choice(0), true), Ok(()));
        // The system's own texts may be compared with anything.
        assert_eq!(comparisons.compare(&known, &Possible::anything(), true), Ok(()));
        assert_eq!(comparisons.with[&0], known.texts);
        assert_eq!(comparisons.among, BTreeSet::from([(0, 1)]));
    }

    #[test]
    fn what_tells_more_texts_apart_is_refused() {
        let compare = |one: &Possible, other: &Possible, converts| {
            let answers =
                [(one, other), (other, one)].map(|(one, other)| Comparisons::default().compare(one, other, converts));
            assert_eq!(answers[0], answers[1]);
            answers[0]
        };
        let chosen = Possible::choice(3);
        assert_eq!(compare(&chosen, &Possible::open(), false), Err(Beyond::Open));
        assert_eq!(compare(&chosen, &Possible::number(), true), Err(Beyond::Number));
        assert_eq!(compare(&chosen, &Possible::number(), false), Ok(()));
        assert_eq!(compare(&chosen.clone().around(), &Possible::texts(["a,b"]), true), Err(Beyond::Structure));
        assert_eq!(compare(&chosen.around(), &Possible::default(), true), Ok(()));
    }

    #[test]
    fn texts_that_grow_for_ever_become_open() {
        let mut all = Possible::default();
        for number in 0..=MOST {
            assert!(all.join(&Possible::texts([number.to_string()])));
        }
        assert!(all.texts.is_empty());
        assert!(all.is_open && !all.join(&Possible::open()));
    }
}
