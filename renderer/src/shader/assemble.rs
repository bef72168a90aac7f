//! A small preprocessor for WGSL: `#import name`, and `#if` … `#elif` … `#else` … `#endif` over feature names joined by
//! `&&`, `||` and `!` (`&&` binds tighter; no parentheses).

use std::collections::BTreeSet;

/// Why a shader's text cannot be assembled.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ShaderError {
    /// An imported file does not exist.
    #[error("{file}:{line}: there is no shader file {name:?}")]
    UnknownImport {
        /// The file.
        file: String,
        /// Its line.
        line: usize,
        /// What was asked for.
        name: String,
    },
    /// A condition names a feature that nobody defines: a spelling mistake would otherwise count as absent.
    #[error("{file}:{line}: {name:?} is no shader feature")]
    UnknownFeature {
        /// The file.
        file: String,
        /// Its line.
        line: usize,
        /// The name.
        name: String,
    },
    /// A directive cannot be understood, or `#if` and `#endif` do not match.
    #[error("{file}:{line}: {reason}")]
    Directive {
        /// The file.
        file: String,
        /// Its line.
        line: usize,
        /// What is wrong.
        reason: String,
    },
}

/// The names that conditions may use, each with its value.
pub(crate) type Features = Vec<(&'static str, bool)>;

/// The text of `root` with imports inserted (each file once, where it is first asked for) and conditions decided.
/// `find` gives the text of a file by name.
pub(crate) fn assemble<'a>(
    root: &str,
    find: &dyn Fn(&str) -> Option<&'a str>,
    features: &[(&'static str, bool)],
) -> Result<String, ShaderError> {
    let mut assembler = Assembler { find, features, seen: BTreeSet::new(), out: String::new() };
    assembler.file(root, "the program", 0)?;
    Ok(assembler.out)
}

struct Assembler<'a, 'b> {
    find: &'b dyn Fn(&str) -> Option<&'a str>,
    features: &'b [(&'static str, bool)],
    seen: BTreeSet<String>,
    out: String,
}

/// One open `#if`.
struct Condition {
    line: usize,
    /// The text around it is kept.
    outer: bool,
    /// The present branch is kept.
    active: bool,
    /// A branch was kept already.
    taken: bool,
    after_else: bool,
}

impl<'a> Assembler<'a, '_> {
    /// Depth of recursion is bounded by the number of files, since each is entered once.
    fn file(&mut self, name: &str, importer: &str, importer_line: usize) -> Result<(), ShaderError> {
        if !self.seen.insert(name.to_owned()) {
            return Ok(());
        }
        let text: &'a str = (self.find)(name).ok_or_else(|| ShaderError::UnknownImport {
            file: importer.to_owned(),
            line: importer_line,
            name: name.to_owned(),
        })?;
        let mut open: Vec<Condition> = Vec::new();
        for (index, text_line) in text.lines().enumerate() {
            let line = index + 1;
            let fault =
                |reason: &str| ShaderError::Directive { file: name.to_owned(), line, reason: reason.to_owned() };
            let active = open.last().is_none_or(|condition| condition.active);
            let Some(directive) = text_line.trim_start().strip_prefix('#') else {
                if active {
                    self.out.push_str(text_line);
                    self.out.push('\n');
                }
                continue;
            };
            let (word, rest) = directive.split_once(char::is_whitespace).unwrap_or((directive, ""));
            let rest = rest.trim();
            match word {
                "import" if active => self.file(rest, name, line)?,
                "import" => {}
                "if" => {
                    let holds = self.condition(rest, name, line)?;
                    open.push(Condition {
                        line,
                        outer: active,
                        active: active && holds,
                        taken: holds,
                        after_else: false,
                    });
                }
                "elif" => {
                    let holds = self.condition(rest, name, line)?;
                    let condition = open.last_mut().ok_or_else(|| fault("#elif without #if"))?;
                    if condition.after_else {
                        return Err(fault("#elif after #else"));
                    }
                    condition.active = condition.outer && !condition.taken && holds;
                    condition.taken |= holds;
                }
                "else" => {
                    let condition = open.last_mut().ok_or_else(|| fault("#else without #if"))?;
                    if condition.after_else {
                        return Err(fault("a second #else"));
                    }
                    condition.active = condition.outer && !condition.taken;
                    condition.after_else = true;
                }
                "endif" => {
                    open.pop().ok_or_else(|| fault("#endif without #if"))?;
                }
                _ => return Err(fault(&format!("unknown directive #{word}"))),
            }
        }
        match open.last() {
            None => Ok(()),
            Some(condition) => Err(ShaderError::Directive {
                file: name.to_owned(),
                line: condition.line,
                reason: "#if without #endif".to_owned(),
            }),
        }
    }

    fn condition(&self, text: &str, file: &str, line: usize) -> Result<bool, ShaderError> {
        let mut any = false;
        for alternative in text.split("||") {
            let mut all = true;
            for term in alternative.split("&&") {
                let term = term.trim();
                let (name, negated) = term.strip_prefix('!').map_or((term, false), |rest| (rest.trim(), true));
                let value = self.features.iter().find(|(feature, _)| *feature == name).map(|(_, value)| *value);
                let value = value.ok_or_else(|| ShaderError::UnknownFeature {
                    file: file.to_owned(),
                    line,
                    name: name.to_owned(),
                })?;
                all &= value != negated;
            }
            any |= all;
        }
        Ok(any)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FEATURES: &[(&str, bool)] = &[("YES", true), ("NO", false)];

    fn run(files: &[(&str, &str)]) -> Result<String, ShaderError> {
        let find = |name: &str| files.iter().find(|(file, _)| *file == name).map(|(_, text)| *text);
        assemble("main", &find, FEATURES)
    }

    #[test]
    fn conditions_choose_one_branch() {
        let text = "#if NO\na\n#elif YES\nb\n#elif YES\nc\n#else\nd\n#endif\ne\n";
        assert_eq!(run(&[("main", text)]).unwrap(), "b\ne\n");
        let text = "#if YES && !NO\na\n#endif\n#if NO || NO && YES\nb\n#else\nc\n#endif\n";
        assert_eq!(run(&[("main", text)]).unwrap(), "a\nc\n");
    }

    #[test]
    fn nothing_inside_an_absent_branch_counts() {
        let text = "#if NO\n#import missing\n#if YES\na\n#else\nb\n#endif\n#endif\nc\n";
        assert_eq!(run(&[("main", text)]).unwrap(), "c\n");
    }

    #[test]
    fn an_import_appears_once_and_before_its_user() {
        let files = [("main", "#import a\n#import b\nm\n"), ("a", "#import b\na\n"), ("b", "#import a\nb\n")];
        assert_eq!(run(&files).unwrap(), "b\na\nm\n");
    }

    #[test]
    fn mistakes_are_told_with_their_place() {
        let message = |text: &str| run(&[("main", text)]).unwrap_err().to_string();
        assert_eq!(message("x\n#import lost\n"), "main:2: there is no shader file \"lost\"");
        assert_eq!(message("#if MAYBE\n#endif\n"), "main:1: \"MAYBE\" is no shader feature");
        assert_eq!(message("\n#if YES\n"), "main:2: #if without #endif");
        assert_eq!(message("#endif\n"), "main:1: #endif without #if");
        assert_eq!(message("#if YES\n#else\n#else\n#endif\n"), "main:3: a second #else");
        assert_eq!(message("#define A\n"), "main:1: unknown directive #define");
    }
}
