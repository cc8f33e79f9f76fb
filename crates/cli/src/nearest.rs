// SPDX-License-Identifier: GPL-3.0-or-later
//! Unknown names: the valid ones, and the most similar one. The distance is that of optimal string alignment
//! (Damerau 1964).
//! Tests: `tests::{finds_slips, leaves_strangers_alone}`.

use strsim::osa_distance;

/// The valid name that is nearest to `name`, if one is near enough to have been meant.
pub(crate) fn nearest<'a>(name: &str, valid: &[&'a str]) -> Option<&'a str> {
    let name = name.to_lowercase();
    let near_enough = name.chars().count().div_ceil(3).max(1);
    let distances =
        valid.iter().map(|&candidate| (osa_distance(&name, &candidate.to_lowercase()), candidate));
    let slip =
        distances.filter(|&(distance, _)| distance <= near_enough).min_by_key(|&(distance, _)| distance);
    // The beginning of a name selects that name, even if another one has the same length as the input.
    let begun = valid.iter().copied().find(|candidate| name.len() >= 3 && candidate.starts_with(&name));
    begun.or_else(|| slip.map(|(_, candidate)| candidate))
}

/// `unknown WHAT 'NAME'; did you mean 'NEAREST'? valid are: ...`
pub(crate) fn unknown(what: &str, name: &str, valid: &[&str]) -> String {
    let meant = nearest(name, valid).map(|meant| format!("did you mean '{meant}'? ")).unwrap_or_default();
    format!("unknown {what} '{name}'; {meant}valid are: {}", valid.join(", "))
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
