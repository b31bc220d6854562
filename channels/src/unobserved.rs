//! Parts of a value that are not part of its state.

use std::hash::{Hash, Hasher};
use std::ops::{Deref, DerefMut};

/// Something that does not distinguish states: working memory, notes for people, or what the rest of a state
/// determines. All such values are equal and have the same hash, so states that differ only in them are equal.
#[derive(Clone, Debug, Default)]
pub struct Unobserved<T>(pub T);

impl<T> PartialEq for Unobserved<T> {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl<T> Eq for Unobserved<T> {}

impl<T> Hash for Unobserved<T> {
    fn hash<H: Hasher>(&self, _: &mut H) {}
}

impl<T> Deref for Unobserved<T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.0
    }
}

impl<T> DerefMut for Unobserved<T> {
    fn deref_mut(&mut self) -> &mut T {
        &mut self.0
    }
}
