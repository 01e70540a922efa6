//! Which loop of one program is which of another, which was edited from it.
//!
//! The loops of a function are numbered, so that a loop that is written before others changes their names. Where a
//! function has as many loops as before, names tell which is which. Where it has not, loops that look alike are the
//! same ones, in their order.

use similar::{Algorithm, DiffOp, capture_diff_slices};
use std::collections::{BTreeMap, BTreeSet};

/// The new names of loops whose names have changed, by the old ones. Each loop comes with its name and with what it looks
/// like.
pub(crate) fn renamed<L: Ord>(old: &[(&str, L)], new: &[(&str, L)]) -> BTreeMap<String, String> {
    let functions: BTreeSet<&str> = old.iter().map(|(name, _)| parts(name).0).collect();
    let mut renamed = BTreeMap::new();
    for of in functions {
        let [before, after] = [old, new].map(|loops| {
            let of_it = loops.iter().filter(|(name, _)| parts(name).0 == of);
            let mut of_it: Vec<_> = of_it.collect();
            of_it.sort_by_key(|(name, _)| parts(name).1);
            of_it
        });
        if before.len() == after.len() {
            continue;
        }
        let looks = |loops: &[&(&str, L)]| -> Vec<usize> {
            // Equal loops have equal numbers.
            let all: BTreeSet<&L> = before.iter().chain(&after).map(|(_, look)| look).collect();
            let all: Vec<&L> = all.into_iter().collect();
            (loops.iter())
                .filter_map(|(_, look)| all.binary_search(&look).ok())
                .collect()
        };
        for op in capture_diff_slices(Algorithm::Myers, &looks(&before), &looks(&after)) {
            if let DiffOp::Equal { .. } | DiffOp::Replace { .. } = op {
                let pairs = op.old_range().zip(op.new_range());
                renamed.extend(pairs.map(|(a, b)| (before[a].0.to_owned(), after[b].0.to_owned())));
            }
        }
        // What has no partner keeps no name that is another's now.
        let taken: BTreeSet<String> = renamed.values().cloned().collect();
        for (name, _) in before {
            if !renamed.contains_key(*name) && taken.contains(*name) {
                renamed.insert((*name).to_owned(), format!("{name} (before)"));
            }
        }
    }
    renamed.retain(|old, new| old != new);
    renamed
}

/// The function of a loop, and its number there: the first has none in its name.
fn parts(name: &str) -> (&str, u32) {
    let numbered = name.rsplit_once('_').and_then(|(function, number)| {
        let is_number = number.bytes().all(|b| b.is_ascii_digit());
        Some((function, number.parse().ok().filter(|_| is_number)?))
    });
    numbered.unwrap_or((name, 1))
}

#[cfg(test)]
mod tests {
    use super::renamed;

    #[test]
    fn a_loop_before_others_renames_them() {
        let old = [("main", 1), ("main_2", 2), ("main_3", 3), ("other", 7)];
        let new = [
            ("main", 1),
            ("main_2", 9),
            ("main_3", 2),
            ("main_4", 3),
            ("other", 8),
        ];
        let names = renamed(&old, &new);
        let pairs: Vec<_> = names
            .iter()
            .map(|(a, b)| (a.as_str(), b.as_str()))
            .collect();
        assert_eq!(pairs, [("main_2", "main_3"), ("main_3", "main_4")]);
        let back: Vec<_> = renamed(&new, &old).into_iter().collect();
        let pair = |a: &str, b: &str| (a.to_owned(), b.to_owned());
        let wanted = [
            pair("main_2", "main_2 (before)"),
            pair("main_3", "main_2"),
            pair("main_4", "main_3"),
        ];
        assert_eq!(back, wanted);
        assert!(renamed(&old, &old).is_empty());
    }
}
