//! What the parsers share: the file, the options, warnings, and the text of each block that nobody knows.

use std::cell::{Cell, RefCell};

use super::ReadOptions;
use super::fault::{Fault, Message, Rest};
use crate::diagnostics::{Finding, Position, ReadError, Severity};
use crate::document::Unknown;
use crate::{Limit, Text, nearest};

/// Only so many warnings of one code are kept one by one.
const KEPT_PER_CODE: usize = 20;

/// The file being read.
pub(crate) struct Context<'a> {
    pub(crate) bytes: &'a [u8],
    pub(crate) options: &'a ReadOptions,
    pub(crate) binary: Cell<bool>,
    warnings: RefCell<Vec<Warning>>,
    tallies: RefCell<Vec<Tally>>,
    totals: Cell<[u64; Limit::ALL.len()]>,
}

/// How many warnings of one code there were, and where the last one was.
struct Tally {
    code: &'static str,
    count: usize,
    last: usize,
}

struct Warning {
    offset: usize,
    code: &'static str,
    message: String,
}

impl<'a> Context<'a> {
    pub(crate) fn new(bytes: &'a [u8], options: &'a ReadOptions) -> Self {
        Self {
            bytes,
            options,
            binary: Cell::new(false),
            warnings: RefCell::default(),
            tallies: RefCell::default(),
            totals: Cell::default(),
        }
    }

    /// The byte offset at which `rest` starts.
    pub(crate) fn offset(&self, rest: Rest<'_>) -> usize {
        self.bytes.len() - rest.len()
    }

    /// Accepts an irregularity with a warning, or refuses it in strict mode.
    pub(crate) fn warn(
        &self,
        rest: Rest<'_>,
        code: &'static str,
        message: impl Into<String>,
    ) -> Result<(), nom::Err<Fault>> {
        self.warn_with(rest, code, || message.into())
    }

    /// As [`Context::warn`]; the message is made only where it is kept.
    pub(crate) fn warn_with(
        &self,
        rest: Rest<'_>,
        code: &'static str,
        message: impl FnOnce() -> String,
    ) -> Result<(), nom::Err<Fault>> {
        if self.options.strict {
            return Fault::fatal(rest, code, message());
        }
        let offset = self.offset(rest);
        let mut tallies = self.tallies.borrow_mut();
        let tally = match tallies.iter_mut().find(|tally| tally.code == code) {
            // Backtracking comes past the same places again.
            Some(tally) if offset <= tally.last => return Ok(()),
            Some(tally) => tally,
            None => {
                tallies.push(Tally { code, count: 0, last: 0 });
                tallies.last_mut().expect("just pushed")
            }
        };
        tally.count += 1;
        tally.last = offset;
        if tally.count <= KEPT_PER_CODE {
            self.warnings.borrow_mut().push(Warning { offset, code, message: message() });
        }
        Ok(())
    }

    /// Refuses what is over a limit.
    pub(crate) fn limit(
        &self,
        at: Rest<'_>,
        limit: Limit,
        code: &'static str,
        found: u64,
    ) -> Result<(), nom::Err<Fault>> {
        match self.options.limits.check(limit, found) {
            Ok(()) => Ok(()),
            Err(exceeded) => Fault::fatal(super::number::skip_space(at), code, exceeded.to_string()),
        }
    }

    /// Adds to what the document holds so far, and refuses what is then over a limit.
    pub(crate) fn grow(
        &self,
        at: Rest<'_>,
        limit: Limit,
        code: &'static str,
        count: usize,
    ) -> Result<(), nom::Err<Fault>> {
        let mut totals = self.totals.get();
        let total = &mut totals[limit as usize];
        *total = total.saturating_add(count as u64);
        self.limit(at, limit, code, *total)?;
        self.totals.set(totals);
        Ok(())
    }

    /// The warnings as findings, in file order, with one line for those that were only counted.
    pub(crate) fn findings(self) -> Vec<Finding> {
        let mut warnings = self.warnings.into_inner();
        warnings.sort_by_key(|warning| warning.offset);
        let mut lines = Position::walk(self.bytes);
        let mut findings: Vec<Finding> = warnings
            .into_iter()
            .map(|warning| Finding {
                code: warning.code,
                severity: Severity::Warning,
                position: Some(lines.at(warning.offset)),
                subject: String::new(),
                message: warning.message,
            })
            .collect();
        for Tally { code, count, .. } in self.tallies.into_inner() {
            if count > KEPT_PER_CODE {
                findings.push(Finding {
                    code,
                    severity: Severity::Warning,
                    position: None,
                    subject: String::new(),
                    message: format!("{} more of the same", count - KEPT_PER_CODE),
                });
            }
        }
        findings
    }

    /// Makes the error for the user of a parser's fault.
    pub(crate) fn error(&self, fault: nom::Err<Fault>) -> ReadError {
        let fault = match fault {
            nom::Err::Error(fault) | nom::Err::Failure(fault) => fault,
            nom::Err::Incomplete(_) => {
                Fault { left: 0, code: "syntax/expected", message: Message::Text("the file ends too early".into()) }
            }
        };
        let mut rest = &self.bytes[self.bytes.len() - fault.left.min(self.bytes.len())..];
        let message = match fault.message {
            Message::Text(text) => text,
            Message::Expected(what) => {
                rest = super::number::skip_space(rest);
                format!("expected {what}, found {}", found(rest))
            }
        };
        ReadError::at(self.bytes, self.offset(rest), fault.code, message)
    }
}

/// The next word for a message.
pub(crate) fn found(rest: Rest<'_>) -> String {
    const SHOWN: usize = 24;
    let rest = super::number::skip_space(rest);
    if rest.is_empty() {
        return "the end of the file".into();
    }
    let end = rest.iter().position(|&byte| super::number::is_space(byte)).unwrap_or(rest.len());
    let shown = &rest[..end.min(SHOWN)];
    if shown.iter().all(u8::is_ascii_graphic) {
        let text: String = shown.iter().map(|&byte| char::from(byte)).collect();
        format!("`{text}{}`", if end > SHOWN { "…" } else { "" })
    } else {
        "bytes that are not text".into()
    }
}

/// A misspelt word as it should be: one of those known, or one with the blank that is missing behind it.
pub(crate) fn suggestion(word: &[u8], known: impl IntoIterator<Item = &'static str> + Clone) -> Option<String> {
    let glued = known.clone().into_iter().find(|tag| tag.ends_with([':', '#']) && word.starts_with(tag.as_bytes()));
    match glued {
        Some(tag) => {
            let value = &word[tag.len()..];
            let shown = value.len() <= 24 && value.iter().all(u8::is_ascii_graphic);
            let value = if shown { String::from_utf8_lossy(value) } else { "…".into() };
            Some(format!("`{tag} {value}`"))
        }
        None => nearest(word, known).map(|tag| format!("`{tag}`")),
    }
}

/// A block of tags: which it knows, and the unknown text met so far.
pub(crate) struct Block {
    /// Every tag that may stand in the block, and what ends it, in order.
    pub(crate) tags: &'static [&'static str],
    /// Other words that may stand in it, for suggestions.
    hints: &'static [&'static str],
    /// With the number of bytes left where it starts, which tells the place.
    unknown: RefCell<Vec<(usize, Unknown)>>,
    met: RefCell<Vec<(&'static str, u32)>>,
}

impl Block {
    pub(crate) fn new(tags: &'static [&'static str]) -> Self {
        Self::with_hints(tags, &[])
    }

    pub(crate) fn with_hints(tags: &'static [&'static str], hints: &'static [&'static str]) -> Self {
        Self { tags, hints, unknown: RefCell::default(), met: RefCell::default() }
    }

    /// The tag of this block that a word is.
    pub(crate) fn known(&self, word: &[u8]) -> Option<&'static str> {
        self.tags.iter().copied().find(|tag| tag.as_bytes() == word)
    }

    /// What was probably meant by a word that the block does not know.
    pub(crate) fn suggestion(&self, word: &[u8]) -> Option<String> {
        let known = self.tags.iter().chain(self.hints).copied();
        // A word that is right elsewhere is not misspelt.
        if self.hints.iter().any(|hint| hint.as_bytes() == word) { None } else { suggestion(word, known) }
    }

    /// An unknown word at a place or after it that was probably meant to be a tag, and how many bytes are left where it
    /// stands. If the tag was met, the word may also stand before an earlier one of its kind.
    pub(crate) fn misspelt(&self, from: Rest<'_>, tag: &'static str) -> Option<(usize, Text)> {
        /// Farther on it would be a coincidence.
        const SEARCHED: usize = 100;
        let again = self.met.borrow().iter().any(|(known, _)| *known == tag);
        let unknown = self.unknown.borrow();
        let candidates = unknown.iter().filter(|(left, _)| again || *left <= from.len()).take(SEARCHED);
        let words = candidates.filter_map(|(left, unknown)| Some((*left, unknown.lines().next()?)));
        let near = |line: &[u8]| suggestion(super::tags::peek_word(line), [tag]).is_some();
        words.filter(|(_, line)| near(line)).map(|(left, line)| (left, Text::from(line))).next()
    }

    /// Keeps unknown text, once. `start` is where it starts.
    pub(crate) fn keep(&self, start: Rest<'_>, unknown: Unknown) {
        let mut kept = self.unknown.borrow_mut();
        if kept.last().is_none_or(|(left, _)| *left > start.len()) {
            kept.push((start.len(), unknown));
        }
    }

    /// Notes that a tag was met; the unknown text since the tag before it stands before this one.
    pub(crate) fn meet(&self, from: Rest<'_>, tag: &'static str) {
        let mut met = self.met.borrow_mut();
        let nth = match met.iter_mut().find(|(known, _)| *known == tag) {
            Some((_, nth)) => {
                *nth += 1;
                *nth
            }
            None => {
                met.push((tag, 0));
                0
            }
        };
        let before = (self.tags.last() != Some(&tag)).then_some((tag, nth));
        for (left, unknown) in self.unknown.borrow_mut().iter_mut().rev() {
            if *left > from.len() {
                break;
            }
            unknown.before = before;
        }
    }

    /// The unknown text, in order.
    pub(crate) fn into_unknown(self) -> Vec<Unknown> {
        self.unknown.into_inner().into_iter().map(|(_, unknown)| unknown).collect()
    }
}
