//! The findings in a usable file.

use diagnostics::{counted, parts};
use miette::Diagnostic;

/// The findings in a usable file.
#[derive(Debug, Default)]
pub struct Checked {
    /// Its kind, in a few words.
    pub summary: String,
    /// Its warnings.
    pub concerns: Vec<Box<dyn Diagnostic + Send + Sync>>,
    /// The programs that a run of it starts, each in a sentence.
    pub programs: Vec<String>,
    /// The files that it takes from elsewhere, in sentences.
    pub elsewhere: Vec<String>,
}

impl Checked {
    /// A file without programs.
    pub(crate) fn of<D: Diagnostic + Send + Sync + 'static>(
        summary: String,
        concerns: impl IntoIterator<Item = D>,
    ) -> Self {
        let concerns = concerns.into_iter().map(|concern| Box::new(concern) as _).collect();
        Self { summary, concerns, ..Self::default() }
    }

    /// The summary, and whether anything looks wrong.
    #[must_use]
    pub fn words(&self) -> String {
        let found = match self.concerns.iter().map(|concern| parts(concern.as_ref()).len()).sum() {
            0 => "no problems found".to_owned(),
            count => counted(count, "warning"),
        };
        format!("{}; {found}", self.summary)
    }
}
