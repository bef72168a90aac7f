//! The report as it arises, kept to a readable length however many parts a file has.

use std::collections::BTreeMap;

use crate::{Outcome, Report};

/// Lines of one kind that are written out; the rest is counted.
const LINES: usize = 40;

/// Collects report lines. Properties are a fixed set of words, so that the length of the report is bounded.
#[derive(Debug, Default)]
pub(super) struct Log {
    report: Report,
    counts: BTreeMap<(Outcome, &'static str), usize>,
}

impl Log {
    fn room(&mut self, outcome: Outcome, property: &'static str) -> bool {
        let count = self.counts.entry((outcome, property)).or_insert(0);
        *count += 1;
        *count <= LINES
    }

    /// Something is in the output unchanged.
    pub(super) fn kept(&mut self, subject: &str, property: &'static str, note: impl Into<String>) {
        if self.room(Outcome::Kept, property) {
            self.report.kept(subject, property, note);
        }
    }

    /// Something is in the output in another form.
    pub(super) fn changed(
        &mut self,
        subject: &str,
        property: &'static str,
        note: impl Into<String>,
        size: Option<String>,
    ) {
        if self.room(Outcome::Changed, property) {
            self.report.changed(subject, property, note, size);
        }
    }

    /// Something is not in the output.
    pub(super) fn lost(&mut self, subject: &str, property: &'static str, note: impl Into<String>) {
        if self.room(Outcome::Lost, property) {
            self.report.lost(subject, property, note);
        }
    }

    /// The report, with how many lines were left out.
    pub(super) fn into_report(mut self) -> Report {
        for ((outcome, property), count) in self.counts {
            let Some(more) = count.checked_sub(LINES).filter(|more| *more > 0) else { continue };
            let note = format!("{more} more lines of this kind");
            match outcome {
                Outcome::Kept => self.report.kept("", property, note),
                Outcome::Changed => self.report.changed("", property, note, None),
                Outcome::Lost => self.report.lost("", property, note),
            }
        }
        self.report
    }
}
