//! The known name nearest to an unknown one, for the hint of a message.

/// The candidate that `name` is most likely a misspelling of: fewest edits (insertion, deletion,
/// replacement, exchange of neighbours; a change of case is free), the first of equals. `None`
/// where all are further away than a third of the name's length, at least one edit, and none is short for the other.
pub fn nearest<'c>(name: &str, candidates: impl IntoIterator<Item = &'c str>) -> Option<&'c str> {
    // Longer names are never typing mistakes, and the comparison takes quadratic time.
    const LONGEST: usize = 64;
    let text = name;
    let name: Vec<char> = name.to_lowercase().chars().take(LONGEST + 1).collect();
    if name.is_empty() || name.len() > LONGEST {
        return None;
    }
    let worst = (name.len() / 3).max(1);
    let candidates: Vec<&str> = candidates.into_iter().collect();
    let misspelt = (candidates.iter())
        .map(|candidate| (edits(&name, &candidate.to_lowercase()), *candidate))
        .filter(|&(distance, _)| distance <= worst)
        .min_by_key(|&(distance, _)| distance);
    let short = |candidate: &&str| is_short_for(candidate, text) || is_short_for(text, candidate);
    let abbreviated = || candidates.iter().copied().find(short);
    misspelt
        .map(|(_, candidate)| candidate)
        .or_else(abbreviated)
}

/// True if a name, of three letters at least and half as many as another, has its letters in their order from the
/// first on, as `cols` has of `columns`.
fn is_short_for(short: &str, long: &str) -> bool {
    let (short, long) = (short.to_lowercase(), long.to_lowercase());
    let mut rest = long.chars();
    let in_order = short.chars().all(|c| rest.any(|other| other == c));
    let enough = short.len() >= 3 && 2 * short.len() >= long.len();
    enough && in_order && short.chars().next() == long.chars().next()
}

/// Edits between two names (optimal string alignment).
fn edits(a: &[char], b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut before: Vec<usize> = Vec::new();
    let mut last: Vec<usize> = (0..=b.len()).collect();
    for i in 1..=a.len() {
        let mut row = vec![i];
        for j in 1..=b.len() {
            let replaced = last[j - 1] + usize::from(a[i - 1] != b[j - 1]);
            let mut best = replaced.min(last[j] + 1).min(row[j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                best = best.min(before[j - 2] + 1);
            }
            row.push(best);
        }
        before = std::mem::replace(&mut last, row);
    }
    last[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_misspellings_only() {
        let names = ["latency", "interval", "uses", "rows", "cols"];
        assert_eq!(nearest("latnecy", names), Some("latency"));
        assert_eq!(nearest("Rows", names), Some("rows"));
        assert_eq!(nearest("row", names), Some("rows"));
        assert_eq!(nearest("columns", names), Some("cols"));
        assert_eq!(nearest("lat", names), None);
        assert_eq!(nearest("latncy-of-it", names), None);
        assert_eq!(nearest("colour", names), None);
        assert_eq!(nearest("", names), None);
        assert_eq!(nearest(&"x".repeat(100_000), names), None);
    }
}
