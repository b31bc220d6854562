//! The passes over a journal that a survey needs.

use super::super::RunRecord;
use super::super::journal::{JournalReader, Layout};
use super::instructive::Selection;
use super::survey::{FirstLook, Survey};
use crate::Error;

/// Surveys the journal that `journal` opens; it is opened once per pass.
pub(in super::super) fn survey(
    layout: &Layout,
    journal: impl Fn() -> Result<JournalReader, Error>,
) -> Result<Survey, Error> {
    let each = |take: &mut dyn FnMut(&RunRecord)| -> Result<(), Error> {
        let mut reader = journal()?;
        while let Some(record) = reader.next()? {
            take(&record);
        }
        Ok(())
    };
    let mut first = FirstLook::new(layout);
    each(&mut |record| first.add(record))?;
    let mut survey = first.survey(layout);
    each(&mut |record| survey.add(record))?;
    if let Some(model) = &mut survey.model {
        model.settle();
    }
    let mut selection = Selection::new(&survey);
    each(&mut |record| selection.consider(&survey, record))?;
    survey.instructive = selection.chosen();
    Ok(survey)
}
