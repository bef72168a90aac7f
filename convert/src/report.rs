//! What a conversion kept, changed and lost.

use serde::Serialize;

/// What became of one property of the input.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Outcome {
    /// In the output, unchanged in meaning.
    Kept,
    /// In the output, in another form or value; [`Change::size`] says by how much where that can be measured.
    Changed,
    /// Not in the output.
    Lost,
}

/// One line of the report.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Change {
    /// What became of it.
    pub outcome: Outcome,
    /// Which part of the input (`material "Glass"`, `node "Lamp"`), empty for the whole.
    pub subject: String,
    /// The property (`occlusion texture`, `normals`).
    pub property: String,
    /// One sentence: what was done and why.
    pub note: String,
    /// The size of the change, with its unit (`0.31°`, `1.2 % RMS`).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub size: Option<String>,
}

/// All lines, in the order in which they arose. Serialises to the JSON of `--report`.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Report {
    /// The lines.
    pub changes: Vec<Change>,
}

impl Report {
    fn add(&mut self, outcome: Outcome, subject: &str, property: &str, note: String, size: Option<String>) {
        self.push(Change { outcome, subject: subject.into(), property: property.into(), note, size });
    }

    /// Adds a line, unless it is among the latest already.
    fn push(&mut self, change: Change) {
        /// Enough to catch what is said for each of several parts, few enough that many lines take no long time.
        const LATEST: usize = 500;
        if !self.changes.iter().rev().take(LATEST).any(|known| *known == change) {
            self.changes.push(change);
        }
    }

    /// Something is in the output unchanged.
    pub fn kept(&mut self, subject: &str, property: &str, note: impl Into<String>) {
        self.add(Outcome::Kept, subject, property, note.into(), None);
    }

    /// Something is in the output in another form.
    pub fn changed(&mut self, subject: &str, property: &str, note: impl Into<String>, size: Option<String>) {
        self.add(Outcome::Changed, subject, property, note.into(), size);
    }

    /// Something is not in the output.
    pub fn lost(&mut self, subject: &str, property: &str, note: impl Into<String>) {
        self.add(Outcome::Lost, subject, property, note.into(), None);
    }

    /// All lines of another report after these.
    pub fn append(&mut self, other: Self) {
        other.changes.into_iter().for_each(|change| self.push(change));
    }

    /// How many lines have this outcome.
    pub fn count(&self, outcome: Outcome) -> usize {
        self.changes.iter().filter(|change| change.outcome == outcome).count()
    }
}
