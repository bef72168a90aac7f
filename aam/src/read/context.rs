//! What the parsers share: the file, the options, warnings, and the text of each block that nobody knows.

use std::cell::{Cell, RefCell};

use super::ReadOptions;
use super::fault::{Fault, Message, Rest};
use crate::diagnostics::{Finding, Position, ReadError, Severity};
use crate::document::Unknown;

/// Only so many warnings of one code are kept one by one.
const KEPT_PER_CODE: usize = 20;

/// The file being read.
pub(crate) struct Context<'a> {
    pub(crate) bytes: &'a [u8],
    pub(crate) options: &'a ReadOptions,
    pub(crate) binary: Cell<bool>,
    warnings: RefCell<Vec<Warning>>,
    tallies: RefCell<Vec<(&'static str, usize)>>,
}

struct Warning {
    offset: usize,
    code: &'static str,
    message: String,
}

impl<'a> Context<'a> {
    pub(crate) fn new(bytes: &'a [u8], options: &'a ReadOptions) -> Self {
        Self { bytes, options, binary: Cell::new(false), warnings: RefCell::default(), tallies: RefCell::default() }
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
        if self.options.strict {
            return Fault::fatal(rest, code, message);
        }
        let offset = self.offset(rest);
        let mut warnings = self.warnings.borrow_mut();
        // Backtracking may come past the same place again.
        if warnings.iter().rev().take(KEPT_PER_CODE).any(|w| w.offset == offset && w.code == code) {
            return Ok(());
        }
        let mut tallies = self.tallies.borrow_mut();
        let tally = match tallies.iter_mut().find(|(known, _)| *known == code) {
            Some((_, tally)) => tally,
            None => {
                tallies.push((code, 0));
                &mut tallies.last_mut().expect("just pushed").1
            }
        };
        *tally += 1;
        if *tally <= KEPT_PER_CODE {
            warnings.push(Warning { offset, code, message: message.into() });
        }
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
        for (code, tally) in self.tallies.into_inner() {
            if tally > KEPT_PER_CODE {
                findings.push(Finding {
                    code,
                    severity: Severity::Warning,
                    position: None,
                    subject: String::new(),
                    message: format!("{} more of the same", tally - KEPT_PER_CODE),
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

/// A block of tags: which it knows, and the unknown text met so far.
pub(crate) struct Block {
    /// Every tag that may stand in the block, and what ends it, in order.
    pub(crate) tags: &'static [&'static str],
    unknown: RefCell<Vec<(usize, Unknown)>>,
    met: RefCell<Vec<(&'static str, u32)>>,
}

impl Block {
    pub(crate) fn new(tags: &'static [&'static str]) -> Self {
        Self { tags, unknown: RefCell::default(), met: RefCell::default() }
    }

    /// The tag of this block that a word is.
    pub(crate) fn known(&self, word: &[u8]) -> Option<&'static str> {
        self.tags.iter().copied().find(|tag| tag.as_bytes() == word)
    }

    /// Keeps unknown text that starts at an offset, once.
    pub(crate) fn keep(&self, offset: usize, unknown: Unknown) {
        let mut kept = self.unknown.borrow_mut();
        if kept.last().is_none_or(|(last, _)| *last < offset) {
            kept.push((offset, unknown));
        }
    }

    /// Notes that a tag was met; the unknown text since the tag before it stands before this one.
    pub(crate) fn meet(&self, from: usize, tag: &'static str) {
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
        for (offset, unknown) in self.unknown.borrow_mut().iter_mut().rev() {
            if *offset < from {
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
