//! Names that are kept, and made unique only where two would be the same.

use std::collections::{BTreeMap, BTreeSet};

/// Names that were given so far. Two names that differ in letter case alone count as the same, since file systems and
/// tools may not tell them apart.
#[derive(Debug, Default)]
pub(super) struct Names {
    taken: BTreeSet<String>,
    next: BTreeMap<String, u32>,
    /// How many names had to be changed.
    pub changed: usize,
}

impl Names {
    /// Takes a name as it is.
    pub(super) fn reserve(&mut self, name: &str) {
        self.taken.insert(name.to_lowercase());
    }

    /// A name on one line, with `.001`, `.002` … before `ending` where it is taken already.
    pub(super) fn unique(&mut self, name: &str, ending: &str) -> String {
        let cleaned: String = name.chars().map(|letter| if letter.is_control() { ' ' } else { letter }).collect();
        let name = cleaned.trim();
        let whole = format!("{name}{ending}");
        if self.taken.insert(whole.to_lowercase()) {
            return whole;
        }
        self.changed += 1;
        let next = self.next.entry(whole.to_lowercase()).or_insert(0);
        loop {
            *next += 1;
            let numbered = format!("{name}.{next:03}{ending}");
            if self.taken.insert(numbered.to_lowercase()) {
                return numbered;
            }
        }
    }
}

/// A part of a file name: letters, digits, `-`, `_` and single blanks or dots between them stay, all else becomes `_`.
pub(super) fn file_stem(name: &str) -> String {
    let mut stem = String::new();
    for letter in name.chars() {
        let plain = letter.is_alphanumeric() || letter == '-' || letter == '_';
        let inner = (letter == '.' || letter == ' ') && !stem.is_empty() && !stem.ends_with(['.', ' ']);
        stem.push(if plain || inner { letter } else { '_' });
        if stem.len() > 100 {
            break;
        }
    }
    stem.trim_end_matches(['.', ' ']).to_owned()
}
