//! Annotations, which precede a field, on its line or on lines of their own.

use diagnostics::{Problem, Span, did_you_mean};

use super::span_parts::{split, trimmed};

/// The annotations that precede the next field.
#[derive(Debug, Default)]
pub(super) struct Annotations {
    pub(super) is_optional: bool,
    pub(super) is_key: bool,
    /// The location of the last one.
    pub(super) place: Option<Span>,
}

impl Annotations {
    /// Removes the annotations at the beginning of a line, and leaves what follows.
    pub(super) fn take(&mut self, line: &Span) -> Result<Span, Problem> {
        let mut rest = line.clone();
        while rest.text().starts_with('@') {
            let (annotation, behind) = split(&rest, char::is_whitespace);
            let flag = match annotation.text() {
                "@optional" => &mut self.is_optional,
                "@key" => &mut self.is_key,
                unknown => {
                    let problem = annotation.problem(format!("unknown annotation `{unknown}`")).with_label("here");
                    let known = ["@optional", "@key"];
                    let help = did_you_mean(unknown, known)
                        .unwrap_or_else(|| "only `@optional` and `@key` are known".to_owned());
                    return Err(problem.with_help(help));
                }
            };
            if std::mem::replace(flag, true) {
                return Err(annotation
                    .problem(format!("`{}` is written twice", annotation.text()))
                    .with_label("again"));
            }
            self.place = Some(annotation);
            rest = trimmed(&behind);
        }
        Ok(rest)
    }

    /// The problem that no field follows the annotations, if there are any.
    pub(super) fn without_field(&self) -> Option<Problem> {
        let place = self.place.as_ref()?;
        Some(place.problem(format!("no field follows `{}`", place.text())).with_label("this annotation"))
    }
}
