// SPDX-License-Identifier: GPL-3.0-or-later
//! Unknown names: the valid ones, and the one that was probably meant.
//! Source: original; the distance is that of optimal string alignment (Damerau 1964).
//! Proof: `tests::{finds_slips, leaves_strangers_alone}`.

/// The valid name that is nearest to `name`, if one is near enough to have been meant.
pub(crate) fn nearest<'a>(name: &str, valid: &[&'a str]) -> Option<&'a str> {
    let name = name.to_lowercase();
    let near_enough = name.chars().count().div_ceil(3).max(1);
    let distances = valid.iter().map(|&candidate| (distance(&name, &candidate.to_lowercase()), candidate));
    let slip =
        distances.filter(|&(distance, _)| distance <= near_enough).min_by_key(|&(distance, _)| distance);
    // Whoever writes the beginning of a name means the name, even if another one is as long as what was written.
    let begun = valid.iter().copied().find(|candidate| name.len() >= 3 && candidate.starts_with(&name));
    begun.or_else(|| slip.map(|(_, candidate)| candidate))
}

/// `unknown WHAT 'NAME'; did you mean 'NEAREST'? valid are: ...`
pub(crate) fn unknown(what: &str, name: &str, valid: &[&str]) -> String {
    let meant = nearest(name, valid).map(|meant| format!("did you mean '{meant}'? ")).unwrap_or_default();
    format!("unknown {what} '{name}'; {meant}valid are: {}", valid.join(", "))
}

/// How many letters must be put in, taken out, replaced or swapped with their neighbour.
fn distance(a: &str, b: &str) -> usize {
    let (a, b): (Vec<char>, Vec<char>) = (a.chars().take(64).collect(), b.chars().take(64).collect());
    // Rows of the table: row i holds the distances of a's first i letters to all beginnings of b.
    let mut above_last: Vec<usize> = Vec::new();
    let mut last: Vec<usize> = (0..=b.len()).collect();
    for i in 1..=a.len() {
        let mut row = vec![i];
        for j in 1..=b.len() {
            let replaced = last[j - 1] + usize::from(a[i - 1] != b[j - 1]);
            let swappable = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
            let swapped = if swappable { above_last[j - 2] + 1 } else { usize::MAX };
            row.push(replaced.min(last[j] + 1).min(row[j - 1] + 1).min(swapped));
        }
        above_last = std::mem::replace(&mut last, row);
    }
    last[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    const NAMES: [&str; 4] = ["eyelight", "normals", "whitted", "box"];

    #[test]
    fn finds_slips() {
        for (slip, meant) in [
            ("witted", "whitted"),
            ("nromals", "normals"),
            ("Eyelight", "eyelight"),
            ("bx", "box"),
            ("eye", "eyelight"),
        ] {
            assert_eq!(nearest(slip, &NAMES), Some(meant), "'{slip}' is near to '{meant}'");
        }
        assert_eq!(distance("abcd", "acbd"), 1, "a swap is one slip");
        assert_eq!(distance("", "abc"), 3, "three letters are missing");
    }

    #[test]
    fn leaves_strangers_alone() {
        assert_eq!(nearest("pathtracer", &NAMES), None, "nothing like it");
        assert_eq!(nearest("", &NAMES), None, "nothing was written");
        let message = unknown("filter", "tent", &NAMES);
        assert_eq!(
            message, "unknown filter 'tent'; valid are: eyelight, normals, whitted, box",
            "the list stands alone"
        );
    }
}
