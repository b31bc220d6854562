//! Readers of the records of a run, one after the other.

use std::convert::Infallible;

use crate::RunView;

/// Follows a run, record by record: what shows it, writes it to a file or watches for something in it.
///
/// A follower is made from the run at its start. Then it sees the view after each step, once; the last step comes
/// together with the end.
pub trait Follower {
    /// Why it cannot go on.
    type Error;

    /// Takes in what the last step has added.
    ///
    /// # Errors
    /// If it cannot go on.
    fn follow(&mut self, view: &RunView) -> Result<(), Self::Error>;
}

/// No follower.
impl Follower for () {
    type Error = Infallible;

    fn follow(&mut self, _: &RunView) -> Result<(), Infallible> {
        Ok(())
    }
}

/// Two follow; the second can always go on.
impl<A: Follower, B: Follower<Error = Infallible>> Follower for (A, B) {
    type Error = A::Error;

    fn follow(&mut self, view: &RunView) -> Result<(), A::Error> {
        let Ok(()) = self.1.follow(view);
        self.0.follow(view)
    }
}

impl<F: Follower + ?Sized> Follower for Box<F> {
    type Error = F::Error;

    fn follow(&mut self, view: &RunView) -> Result<(), F::Error> {
        (**self).follow(view)
    }
}

impl<F: Follower> Follower for Option<F> {
    type Error = F::Error;

    fn follow(&mut self, view: &RunView) -> Result<(), F::Error> {
        self.as_mut().map_or(Ok(()), |follower| follower.follow(view))
    }
}
