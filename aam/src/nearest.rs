//! "Did you mean …?"

/// Longer words are not compared, so that a hostile file costs little.
const LONGEST: usize = 64;

/// The known word that a misspelt one most likely stands for: the one with the fewest slips (a letter too many, missing,
/// wrong, or exchanged with its neighbour; case does not count), at most one for every four letters, but one in three.
///
/// ```
/// let known = ["MatID:", "UserProp:"];
/// assert_eq!(aam::nearest(b"MadID:", known), Some("MatID:"));
/// assert_eq!(aam::nearest(b"Radius:", known), None);
/// ```
pub fn nearest<'k>(word: &[u8], known: impl IntoIterator<Item = &'k str>) -> Option<&'k str> {
    let slips = |candidate: &'k str| {
        let allowed = (candidate.len() / 4).max(usize::from(candidate.len() >= 3));
        let comparable = candidate.len() <= LONGEST && candidate.len().abs_diff(word.len()) <= allowed;
        Some((comparable.then(|| distance(word, candidate.as_bytes())).filter(|slips| *slips <= allowed)?, candidate))
    };
    known.into_iter().filter_map(slips).min_by_key(|(slips, _)| *slips).map(|(_, candidate)| candidate)
}

/// The optimal string alignment distance (Damerau–Levenshtein without editing what was exchanged).
fn distance(a: &[u8], b: &[u8]) -> usize {
    let mut rows = [vec![0; b.len() + 1], (0..=b.len()).collect(), vec![0; b.len() + 1]];
    let same = |x: u8, y: u8| x.eq_ignore_ascii_case(&y);
    for i in 0..a.len() {
        let [before, last, next] = &mut rows;
        next[0] = i + 1;
        for j in 0..b.len() {
            let replaced = last[j] + usize::from(!same(a[i], b[j]));
            next[j + 1] = replaced.min(last[j + 1] + 1).min(next[j] + 1);
            if i > 0 && j > 0 && same(a[i], b[j - 1]) && same(a[i - 1], b[j]) {
                next[j + 1] = next[j + 1].min(before[j - 1] + 1);
            }
        }
        rows.rotate_left(1);
    }
    rows[1][b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slips_are_counted() {
        for (a, b, expected) in [
            ("", "", 0),
            ("", "abc", 3),
            ("abc", "", 3),
            ("abc", "abc", 0),
            ("abc", "ABC", 0),
            ("abc", "acb", 1),
            ("abc", "axc", 1),
            ("abc", "abcd", 1),
            ("abcd", "bcd", 1),
            ("kitten", "sitting", 3),
            ("ca", "abc", 3),
        ] {
            assert_eq!(distance(a.as_bytes(), b.as_bytes()), expected, "{a} {b}");
            assert_eq!(distance(b.as_bytes(), a.as_bytes()), expected, "{b} {a}");
        }
    }

    #[test]
    fn only_what_is_close_is_suggested() {
        let known = ["Name:", "Class:", "Tx:", "TS:", "}"];
        assert_eq!(nearest(b"Nmae:", known), Some("Name:"));
        assert_eq!(nearest(b"Class", known), Some("Class:"));
        assert_eq!(nearest(b"Tz:", known), Some("Tx:"));
        assert_eq!(nearest(b"{", known), None);
        assert_eq!(nearest(b"Gloss:", known), None);
        assert_eq!(nearest(&[b'x'; 1 << 20], known), None);
    }
}
