//! The parsers' error: how far they came, and what they expected there.

use std::borrow::Cow;

use nom::error::{ErrorKind, ParseError};

/// Input that is still to be read; always the tail of the file.
pub(crate) type Rest<'a> = &'a [u8];

/// What every parser returns.
pub(crate) type Parsed<'a, T> = nom::IResult<Rest<'a>, T, Fault>;

/// Why a parser stopped. The place is told by how many bytes were left.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Fault {
    /// Bytes left, which gives the offset.
    pub(crate) left: usize,
    /// Stable code of the finding.
    pub(crate) code: &'static str,
    /// What is wrong.
    pub(crate) message: Message,
}

/// The sentence of a fault; made whole only when it is shown.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Message {
    /// "expected …, found …", the second half taken from the input.
    Expected(Cow<'static, str>),
    /// A whole sentence.
    Text(String),
}

impl Fault {
    /// Another alternative may still fit here.
    pub(crate) fn expected<T>(rest: Rest<'_>, what: impl Into<Cow<'static, str>>) -> Result<T, nom::Err<Self>> {
        Err(nom::Err::Error(Self {
            left: rest.len(),
            code: "syntax/expected",
            message: Message::Expected(what.into()),
        }))
    }

    /// Nothing else can fit here.
    pub(crate) fn fatal<T>(rest: Rest<'_>, code: &'static str, text: impl Into<String>) -> Result<T, nom::Err<Self>> {
        Err(nom::Err::Failure(Self { left: rest.len(), code, message: Message::Text(text.into()) }))
    }
}

impl<'a> ParseError<Rest<'a>> for Fault {
    fn from_error_kind(input: Rest<'a>, kind: ErrorKind) -> Self {
        Self { left: input.len(), code: "syntax/expected", message: Message::Expected(format!("{kind:?}").into()) }
    }

    fn append(_input: Rest<'a>, _kind: ErrorKind, other: Self) -> Self {
        other
    }

    fn or(self, other: Self) -> Self {
        // The alternative that came further says more.
        if self.left < other.left { self } else { other }
    }
}
