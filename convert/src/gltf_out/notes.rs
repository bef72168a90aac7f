//! Report lines, one for each thing that happened however many parts it happened to.

use std::collections::BTreeMap;

use crate::{Outcome, Report};

/// Subjects that a line names; the rest is counted.
const NAMED: usize = 3;

/// Collects lines.
#[derive(Debug, Default)]
pub(super) struct Notes {
    lines: Vec<Line>,
    places: BTreeMap<(Outcome, &'static str, String), usize>,
}

#[derive(Debug)]
struct Line {
    outcome: Outcome,
    property: &'static str,
    note: String,
    subjects: Vec<String>,
    count: usize,
    /// The largest size and its text.
    size: Option<(f64, String)>,
}

impl Notes {
    fn add(&mut self, outcome: Outcome, subject: &str, property: &'static str, note: String) -> &mut Line {
        let place = *self.places.entry((outcome, property, note.clone())).or_insert_with(|| {
            self.lines.push(Line { outcome, property, note, subjects: Vec::new(), count: 0, size: None });
            self.lines.len() - 1
        });
        let line = &mut self.lines[place];
        line.count += 1;
        if line.subjects.len() < NAMED {
            line.subjects.push(subject.to_owned());
        }
        line
    }

    /// Something is in the output unchanged.
    pub(super) fn kept(&mut self, subject: &str, property: &'static str, note: impl Into<String>) {
        self.add(Outcome::Kept, subject, property, note.into());
    }

    /// Something is in the output in another form.
    pub(super) fn changed(&mut self, subject: &str, property: &'static str, note: impl Into<String>) {
        self.add(Outcome::Changed, subject, property, note.into());
    }

    /// Something is in the output in another form, and by how much. Of several sizes the largest is told.
    pub(super) fn changed_by(
        &mut self,
        subject: &str,
        property: &'static str,
        note: impl Into<String>,
        (size, text): (f64, String),
    ) {
        let line = self.add(Outcome::Changed, subject, property, note.into());
        if line.size.as_ref().is_none_or(|(largest, _)| size > *largest) {
            line.size = Some((size, text));
        }
    }

    /// Something is not in the output.
    pub(super) fn lost(&mut self, subject: &str, property: &'static str, note: impl Into<String>) {
        self.add(Outcome::Lost, subject, property, note.into());
    }

    /// The report.
    pub(super) fn into_report(self) -> Report {
        let mut report = Report::default();
        for line in self.lines {
            let mut subject = line.subjects.join(", ");
            if line.count > line.subjects.len() {
                subject = format!("{subject} and {} more", line.count - line.subjects.len());
            }
            match line.outcome {
                Outcome::Kept => report.kept(&subject, line.property, line.note),
                Outcome::Changed => {
                    let of = if line.count > 1 { "at most " } else { "" };
                    report.changed(
                        &subject,
                        line.property,
                        line.note,
                        line.size.map(|(_, text)| format!("{of}{text}")),
                    );
                }
                Outcome::Lost => report.lost(&subject, line.property, line.note),
            }
        }
        report
    }
}
