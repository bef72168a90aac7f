//! Tags, values on a tag's line, blocks, and the text that nobody knows.

use nom::Parser;

use super::context::{Block, Context, found, suggestion};
use super::fault::{Fault, Message, Parsed, Rest};
use super::number::{integer, is_space, real, skip_space};
use crate::Text;
use crate::document::Unknown;
use crate::text::trim_blanks;

/// The next word (up to white space), after any white space.
pub(crate) fn peek_word(rest: Rest<'_>) -> &[u8] {
    let rest = skip_space(rest);
    let end = rest.iter().position(|&byte| is_space(byte)).unwrap_or(rest.len());
    &rest[..end]
}

/// A fixed word, after any white space.
pub(crate) fn word<'a>(expected: &'static str) -> impl Parser<Rest<'a>, Output = &'static str, Error = Fault> {
    move |rest: Rest<'a>| {
        let start = skip_space(rest);
        match start.strip_prefix(expected.as_bytes()) {
            Some(tail) if tail.first().is_none_or(|&byte| is_space(byte)) => Ok((tail, expected)),
            _ => Fault::expected(start, format!("`{expected}`")),
        }
    }
}

/// A tag of a block, its value, and nothing else on the line. Unknown text before it is kept in the block.
pub(crate) fn field<'a, T>(
    cx: &Context<'a>,
    block: &Block,
    tag: &'static str,
    value: impl Parser<Rest<'a>, Output = T, Error = Fault>,
) -> impl Parser<Rest<'a>, Output = T, Error = Fault> {
    let mut tag = block_tag(cx, block, tag);
    let mut value = nom::combinator::cut(value);
    move |rest: Rest<'a>| {
        let (rest, _) = tag.parse(rest)?;
        let (rest, value) = value.parse(rest)?;
        let (rest, ()) = line_end(cx, rest)?;
        Ok((rest, value))
    }
}

/// A tag of a block; the caller reads on. Unknown text before it is kept in the block.
pub(crate) fn block_tag<'a>(
    cx: &Context<'a>,
    block: &Block,
    tag: &'static str,
) -> impl Parser<Rest<'a>, Output = &'static str, Error = Fault> {
    move |rest: Rest<'a>| {
        let (start, ()) = keep_unknown(cx, block, rest)?;
        let (tail, _) = word(tag).parse(start)?;
        block.meet(rest, tag);
        Ok((tail, tag))
    }
}

/// The tag that must come now: if it is missing, says whether it is misspelt, or another tag of the block stands in its
/// place.
pub(crate) fn required<'a, T>(
    block: &Block,
    tag: &'static str,
    mut field: impl Parser<Rest<'a>, Output = T, Error = Fault>,
) -> impl Parser<Rest<'a>, Output = T, Error = Fault> {
    move |rest: Rest<'a>| match field.parse(rest) {
        Err(nom::Err::Error(fault)) => {
            let at = &rest[rest.len() - fault.left.min(rest.len())..];
            misspelt(block, rest, tag)?;
            match block.known(peek_word(at)) {
                Some(known) if known != tag && block.tags.last() != Some(&known) => {
                    Fault::fatal(skip_space(at), "syntax/tag-order", out_of_order(block, tag, known))
                }
                _ => Err(nom::Err::Failure(fault)),
            }
        }
        other => other,
    }
}

/// Refuses an unknown word that was probably meant to be a tag which is missing.
pub(crate) fn misspelt(block: &Block, from: Rest<'_>, tag: &'static str) -> Result<(), nom::Err<Fault>> {
    let Some((left, line)) = block.misspelt(from, tag) else { return Ok(()) };
    let word = peek_word(line.bytes());
    let meant = suggestion(word, [tag]).unwrap_or_else(|| format!("`{tag}`"));
    let message = format!("{} is unknown; did you mean {meant}, which must come here?", found(line.bytes()));
    Err(nom::Err::Failure(Fault { left, code: "syntax/misspelt-tag", message: Message::Text(message) }))
}

fn out_of_order(block: &Block, expected: &'static str, known: &'static str) -> String {
    let place = |tag| block.tags.iter().position(|&other| other == tag);
    if place(known) < place(expected) {
        format!("expected `{expected}`, found `{known}`, which belongs before it and only once")
    } else {
        format!("expected `{expected}`, found `{known}`, which belongs after it")
    }
}

/// Only blanks up to the end of the line; anything else is skipped with a warning.
pub(crate) fn line_end<'a>(cx: &Context<'a>, rest: Rest<'a>) -> Parsed<'a, ()> {
    let mut at = rest;
    while let [b' ' | b'\t', tail @ ..] = at {
        at = tail;
    }
    if at.first().is_none_or(|&byte| byte == b'\n' || byte == b'\r') {
        return Ok((at, ()));
    }
    cx.warn(at, "syntax/trailing-text", format!("{} is left over at the end of the line", found(at)))?;
    let end = memchr::memchr2(b'\n', b'\r', at).unwrap_or(at.len());
    Ok((&at[end..], ()))
}

/// The rest of the line, without blanks at its ends.
pub(crate) fn text(rest: Rest<'_>) -> Parsed<'_, Text> {
    let (tail, line) = line(rest);
    Ok((tail, Text::from(line)))
}

/// The rest of the line without blanks at its ends, and what follows before the line end.
pub(crate) fn line(rest: Rest<'_>) -> (Rest<'_>, &[u8]) {
    let end = memchr::memchr2(b'\n', b'\r', rest).unwrap_or(rest.len());
    (&rest[end..], trim_blanks(&rest[..end]))
}

/// One word on this line.
pub(crate) fn one_word(rest: Rest<'_>) -> Parsed<'_, Text> {
    let (_, on_line) = line(rest);
    if on_line.is_empty() {
        return Fault::expected(rest, "a word");
    }
    let word = peek_word(rest);
    let start = skip_space(rest);
    Ok((&start[word.len()..], Text::from(word)))
}

/// `N` real numbers, which may go on over line ends. Values that are not finite are kept with a warning.
pub(crate) fn reals<'a, const N: usize>(cx: &Context<'a>) -> impl Parser<Rest<'a>, Output = [f32; N], Error = Fault> {
    move |mut rest: Rest<'a>| {
        let mut values = [0.0; N];
        for value in &mut values {
            let (tail, number) = real(rest)?;
            if !number.is_finite() {
                not_finite(cx, skip_space(rest), number)?;
            }
            *value = number;
            rest = tail;
        }
        Ok((rest, values))
    }
}

/// Warns of a value that is not finite.
#[cold]
pub(crate) fn not_finite(cx: &Context<'_>, at: Rest<'_>, value: f32) -> Result<(), nom::Err<Fault>> {
    let what = if value.is_nan() { "not a number" } else { "too large for 32 bits" };
    cx.warn(at, "value/not-finite", format!("{} is {what}", found(at)))
}

/// One real number.
pub(crate) fn scalar<'a>(cx: &Context<'a>) -> impl Parser<Rest<'a>, Output = f32, Error = Fault> {
    reals::<1>(cx).map(|[value]| value)
}

/// 0 or 1.
pub(crate) fn zero_or_one(rest: Rest<'_>) -> Parsed<'_, bool> {
    match integer(rest)? {
        (tail, 0) => Ok((tail, false)),
        (tail, 1) => Ok((tail, true)),
        _ => Fault::expected(skip_space(rest), "0 or 1"),
    }
}

/// `N`, or `Y`.
pub(crate) fn yes_or_no(rest: Rest<'_>) -> Parsed<'_, bool> {
    let start = skip_space(rest);
    match peek_word(start) {
        b"N" => Ok((&start[1..], false)),
        b"Y" => Ok((&start[1..], true)),
        _ => Fault::expected(start, "`Y` or `N`"),
    }
}

/// Refuses a count of things that the bytes left cannot hold.
pub(crate) fn fits<'a>(
    at: Rest<'a>,
    rest: Rest<'a>,
    count: usize,
    bytes_each: usize,
    what: &str,
) -> Result<(), nom::Err<Fault>> {
    if count.checked_mul(bytes_each).is_none_or(|bytes| bytes > rest.len() + 1) {
        return Fault::fatal(
            skip_space(at),
            "count/too-large",
            format!("{count} {what} cannot fit into the {} bytes that are left", rest.len()),
        );
    }
    Ok(())
}

/// Keeps lines that start with a word that the block does not know, with the block and number rows after each.
fn keep_unknown<'a>(cx: &Context<'a>, block: &Block, mut rest: Rest<'a>) -> Parsed<'a, ()> {
    loop {
        let start = skip_space(rest);
        let word = peek_word(start);
        if word.is_empty() || block.known(word).is_some() || !starts_tag(word) {
            return Ok((start, ()));
        }
        if let Some(known) = block.tags.iter().find(|tag| tag.as_bytes().eq_ignore_ascii_case(word)) {
            return Fault::fatal(
                start,
                "syntax/tag-case",
                format!("expected `{known}`, found {}; tags are case-sensitive", found(start)),
            );
        }
        if cx.binary.get() && word.ends_with(b"_List:") {
            return Fault::fatal(
                start,
                "syntax/unknown-list",
                unknown_message(block, start, "is unknown, and nobody knows how long its binary data is"),
            );
        }
        cx.warn_with(start, "syntax/unknown-tag", || unknown_message(block, start, "is unknown and kept as it is"))?;
        let (tail, text) = unknown_lines(start)?;
        block.keep(start, Unknown { before: None, text });
        rest = tail;
    }
}

fn starts_tag(word: &[u8]) -> bool {
    word.first().is_some_and(|byte| byte.is_ascii_alphabetic() || *byte == b'_')
}

fn unknown_message(block: &Block, start: Rest<'_>, what: &str) -> String {
    let hint = match block.suggestion(peek_word(start)) {
        Some(tag) => format!("; did you mean {tag}?"),
        None => String::new(),
    };
    format!("{} {what}{hint}", found(start))
}

/// One unknown line, the `{ }` block right after it, and the number rows right after that.
fn unknown_lines(rest: Rest<'_>) -> Parsed<'_, Text> {
    let first_line = skip_space(rest);
    let (mut rest, first) = line(first_line);
    let mut lines = first.to_vec();
    let mut depth = 0usize;
    loop {
        let start = skip_space(rest);
        let word = peek_word(start);
        let is_number = real(start).is_ok();
        match word {
            b"{" => depth += 1,
            b"}" if depth > 0 => depth -= 1,
            _ if depth > 0 && !word.is_empty() => {}
            _ if is_number => {}
            _ if depth > 0 => {
                let message = format!(
                    "expected `}}` at the end of the block of {}, found the end of the file",
                    found(first_line)
                );
                return Fault::fatal(first_line, "syntax/expected", message);
            }
            _ => return Ok((rest, Text::from(&lines[..]))),
        }
        let (tail, text) = line(start);
        lines.push(b'\n');
        lines.extend_from_slice(text);
        rest = tail;
    }
}

/// `SHADERS … ENDSHADERS`, kept line by line.
pub(crate) fn shaders<'a>(cx: &Context<'a>, rest: Rest<'a>) -> Parsed<'a, Unknown> {
    let start = skip_space(rest);
    let (mut rest, _) = word("SHADERS").parse(start)?;
    cx.warn(start, "syntax/unknown-tag", "the SHADERS section is kept as it is")?;
    let mut lines = b"SHADERS".to_vec();
    loop {
        let next = skip_space(rest);
        if next.is_empty() {
            let message = "expected `ENDSHADERS` at the end of `SHADERS`, found the end of the file";
            return Fault::fatal(start, "syntax/expected", message);
        }
        let (tail, text) = line(next);
        lines.push(b'\n');
        lines.extend_from_slice(text);
        rest = tail;
        if text == b"ENDSHADERS" {
            return Ok((rest, Unknown { before: Some(("MATERIALS", 0)), text: Text::from(&lines[..]) }));
        }
    }
}
