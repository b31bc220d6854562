//! Fields that only some messages of a channel have, because others have another field at the same position: what
//! selects these messages is given with the field, or beside the comparison.

use channels::Relation;

use crate::formula::{MessageCondition, MessageField, Term};

impl MessageCondition {
    /// The same condition, where what selects the messages with a field is a part beside the comparison. Inside
    /// `any(…)`, `all(…)` and `count(…)`, it stays with the field.
    pub(crate) fn spelled_out(&self) -> Self {
        let mut all = self.clone();
        all.leaves_mut(&mut |leaf| {
            let mut parts: Vec<Self> = Vec::new();
            leaf.fields_mut(false, &mut |field| {
                if let Some(given) = field.given.take().filter(|given| !parts.contains(given)) {
                    parts.push(*given);
                }
            });
            if parts.is_empty() {
                return;
            }
            // A missing value differs from every value.
            let is_denied = match leaf {
                Self::Compare { relation, .. } | Self::Relate { relation, .. } if *relation == Relation::NotEqual => {
                    *relation = Relation::Equal;
                    true
                }
                _ => false,
            };
            parts.push(leaf.clone());
            *leaf = if is_denied { Self::Not(Box::new(Self::And(parts))) } else { Self::And(parts) };
        });
        all
    }

    /// The condition with each field as that of any message.
    pub(crate) fn of_any(&self) -> Self {
        let mut all = self.clone();
        all.fields_mut(true, &mut |field| field.given = None);
        all
    }

    /// Calls `visit` with each field; with those by which items are counted only if `of_items`.
    fn fields_mut(&mut self, of_items: bool, visit: &mut dyn FnMut(&mut MessageField)) {
        self.leaves_mut(&mut |leaf| match leaf {
            Self::Compare { field, .. } | Self::Remember { field, .. } => visit(field),
            Self::Relate { left, right, .. } => {
                [left, right].into_iter().for_each(|term| term.fields_mut(of_items, visit));
            }
            _ => {}
        });
    }
}

impl Term {
    fn fields_mut(&mut self, of_items: bool, visit: &mut dyn FnMut(&mut MessageField)) {
        match self {
            Self::Field(field) => visit(field),
            Self::Arithmetic(left, _, right) => {
                [left, right].into_iter().for_each(|term| term.fields_mut(of_items, visit));
            }
            Self::Call(_, terms) => terms.iter_mut().for_each(|term| term.fields_mut(of_items, visit)),
            Self::Count(condition) if of_items => condition.fields_mut(of_items, visit),
            Self::Value(_) | Self::Remembered(_) | Self::Count(_) => {}
        }
    }
}
