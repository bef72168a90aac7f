//! Which findings a user wants to see, and how bad they are to that user.

use std::fmt;
use std::str::FromStr;

use super::codes::{CODES, code_info};
use crate::{Finding, Severity, nearest};

/// A code (`material/shininess`), or all codes of a group (`material`, `material/` or `material/*`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CodePattern(&'static str);

impl CodePattern {
    /// Whether it names a finding's code.
    pub fn matches(self, code: &str) -> bool {
        self.is_exactly(code) || group_of(code) == self.0
    }

    fn is_exactly(self, code: &str) -> bool {
        self.0 == code
    }
}

impl fmt::Display for CodePattern {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.0)
    }
}

/// The part before the `/`.
pub(super) fn group_of(code: &str) -> &str {
    code.split('/').next().unwrap_or(code)
}

/// The groups, each once, in the order of the table.
pub fn groups() -> Vec<&'static str> {
    let mut groups: Vec<&str> = CODES.iter().map(|info| group_of(info.code)).collect();
    groups.dedup();
    groups
}

impl FromStr for CodePattern {
    type Err = UnknownCode;

    fn from_str(text: &str) -> Result<Self, UnknownCode> {
        let name = text.strip_suffix("/*").or_else(|| text.strip_suffix('/')).unwrap_or(text);
        let codes = || CODES.iter().map(|info| info.code);
        if let Some(known) = codes().chain(groups()).find(|known| *known == name) {
            return Ok(Self(known));
        }
        let second = |code: &'static str| code.split('/').nth(1).unwrap_or(code);
        let whole = nearest(name.as_bytes(), codes().chain(groups()));
        let half = || {
            let near = nearest(name.as_bytes(), codes().map(second))?;
            codes().find(|code| second(code) == near)
        };
        Err(UnknownCode { near: whole.or_else(half) })
    }
}

/// There is no code or group of that name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UnknownCode {
    /// What was probably meant.
    pub near: Option<&'static str>,
}

impl fmt::Display for UnknownCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.near {
            Some(near) => write!(f, "there is no such finding; did you mean {near}?"),
            None => write!(f, "there is no such finding; groups of findings are {}", groups().join(", ")),
        }
    }
}

impl std::error::Error for UnknownCode {}

/// Which findings are wanted, and with which severity. The default leaves all as they are.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Rules {
    /// Only these; none means all.
    pub only: Vec<CodePattern>,
    /// None of these.
    pub ignore: Vec<CodePattern>,
    /// Severities other than those of the table. A code counts more than its group; of two equal patterns the first
    /// counts.
    pub severities: Vec<(CodePattern, Severity)>,
    /// Warnings are errors, unless [`Rules::severities`] names them.
    pub strict: bool,
}

impl Rules {
    /// Whether findings of a code are wanted.
    pub fn wants(&self, code: &str) -> bool {
        let named = |patterns: &[CodePattern]| patterns.iter().any(|pattern| pattern.matches(code));
        (self.only.is_empty() || named(&self.only)) && !named(&self.ignore)
    }

    /// The severity of a finding that has another one of its own.
    pub fn severity(&self, code: &str, own: Severity) -> Severity {
        let exact = self.severities.iter().find(|(pattern, _)| pattern.is_exactly(code));
        match exact.or_else(|| self.severities.iter().find(|(pattern, _)| pattern.matches(code))) {
            Some((_, severity)) => *severity,
            None if self.strict && own == Severity::Warning => Severity::Error,
            None => own,
        }
    }

    /// Leaves out what is not wanted and sets the severities of the rest.
    pub fn apply(&self, findings: &mut Vec<Finding>) {
        findings.retain(|finding| self.wants(finding.code));
        for finding in findings {
            finding.severity = self.severity(finding.code, finding.severity);
        }
    }

    /// A pattern that was given two different severities, if there is one.
    pub fn contradiction(&self) -> Option<CodePattern> {
        let again = |(index, (pattern, severity)): (usize, &(CodePattern, Severity))| {
            let other = |(known, of): &(CodePattern, Severity)| known == pattern && of != severity;
            self.severities[..index].iter().any(other).then_some(*pattern)
        };
        self.severities.iter().enumerate().find_map(again)
    }
}

/// The severity that the table gives a code.
pub(super) fn severity_of(code: &str) -> Severity {
    code_info(code).map_or(Severity::Error, |info| info.severity)
}
