//! Should a reader of files ever panic, the editor goes on, and says so.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// The result of some work, or what it panicked with. The caller throws away what the work has changed.
pub(crate) fn guarded<T>(work: impl FnOnce() -> T) -> Result<T, String> {
    catch_unwind(AssertUnwindSafe(work))
        .map_err(|panic| format!("steward has a defect, please report it: {}", reason(panic.as_ref())))
}

fn reason(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    text.or(panic.downcast_ref::<&str>().copied()).unwrap_or("a panic without a reason")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_told_with_its_reason() {
        let count = [0; 3].len();
        assert_eq!(guarded(|| count), Ok(3));
        let told = guarded(|| assert!(count > 3, "only {count}")).unwrap_err();
        assert_eq!(told, "steward has a defect, please report it: only 3");
    }
}
