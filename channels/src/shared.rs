//! Data shared by all states of a process.

use std::hash::{Hash, Hasher};
use std::ops::Deref;
use std::sync::Arc;

/// Something that never changes while a process runs, kept beside its state. Comparing states of one process costs only
/// a pointer comparison; it is not part of hashes.
#[derive(Debug)]
pub struct Shared<T: ?Sized>(Arc<T>);

impl<T> Shared<T> {
    /// To be shared from now on.
    #[must_use]
    pub fn new(content: T) -> Self {
        Self(Arc::new(content))
    }
}

impl<T: ?Sized> From<Arc<T>> for Shared<T> {
    fn from(content: Arc<T>) -> Self {
        Self(content)
    }
}

impl<T: ?Sized> Deref for Shared<T> {
    type Target = Arc<T>;

    fn deref(&self) -> &Arc<T> {
        &self.0
    }
}

impl<T: ?Sized> Clone for Shared<T> {
    fn clone(&self) -> Self {
        Self(Arc::clone(&self.0))
    }
}

impl<T: ?Sized + PartialEq> PartialEq for Shared<T> {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0) || self.0 == other.0
    }
}

impl<T: ?Sized + Eq> Eq for Shared<T> {}

impl<T: ?Sized> Hash for Shared<T> {
    fn hash<H: Hasher>(&self, _: &mut H) {}
}
