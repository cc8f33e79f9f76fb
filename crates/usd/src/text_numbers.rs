// SPDX-License-Identifier: GPL-3.0-or-later
//! Numbers of text layers that begin or end with their point (`.5`, `-.5`, `2.`): edits that add the zero that the library expects
//! there. Source: the text format's grammar, which has such numbers. Tests: `tests`, and `tests/arrays.rs` with long arrays.

use crate::layer::{Edit, Replacement};
use crate::text_check::quiet_end;

/// Edits of the text outside of the ranges that `others` replace, which ascend. The text is one that `text_check` has looked over.
pub(crate) fn edits(text: &[u8], others: &[Edit]) -> Vec<Edit> {
    let mut others = others.iter().map(|edit| &edit.range).peekable();
    let mut edits = Vec::new();
    let mut at = 0;
    while at < text.len() {
        if let Some(range) = others.next_if(|range| range.start <= at) {
            at = range.end.max(at);
        } else if let Some(end) = quiet_end(text, at) {
            at = end;
        } else {
            if text[at] == b'.'
                && let Some(place) = lacking_zero(text, at)
            {
                edits.push(Edit { range: place..place, by: Replacement::Bytes(vec![b'0']) });
            }
            at += 1;
        }
    }
    edits
}

/// The place of the zero that a number lacks at its point.
fn lacking_zero(text: &[u8], point: usize) -> Option<usize> {
    let before = point.checked_sub(1).map(|at| text[at]);
    let begins = before.is_none_or(|byte| b"([,=:-+ \t\n\r".contains(&byte));
    if begins && text.get(point + 1).is_some_and(u8::is_ascii_digit) {
        return Some(point);
    }
    ends_a_number(text, point).then_some(point + 1)
}

/// Whether a point is the last of a number: behind digits that are part of no word, and before none.
fn ends_a_number(text: &[u8], point: usize) -> bool {
    let digits = text[..point].iter().rev().take_while(|byte| byte.is_ascii_digit()).count();
    let is_of_name = |byte: u8| byte.is_ascii_alphanumeric() || matches!(byte, b'_' | b'.');
    let before = (point - digits).checked_sub(1).map(|at| text[at]);
    digits > 0
        && !before.is_some_and(is_of_name)
        && !text.get(point + 1).is_some_and(|&byte| is_of_name(byte) || byte == b':')
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::layer::Layer;

    fn whole(text: &str) -> String {
        let edits = edits(text.as_bytes(), &[]);
        String::from_utf8(Layer::new(Arc::new(text.as_bytes().to_vec()), edits).bytes()).expect("text")
    }

    #[test]
    fn points_get_zeros() {
        let text = "a = (.5, -.25, 2., -3.) # .5\n\"x .5 2.\" @./a.2.usd@ b = 1.5 c.d [.5e3] rel = </A.x> inputs:a.connect = 1.e2\n";
        let expected = "a = (0.5, -0.25, 2.0, -3.0) # .5\n\"x .5 2.\" @./a.2.usd@ b = 1.5 c.d [0.5e3] rel = </A.x> inputs:a.connect = 1.e2\n";
        assert_eq!(whole(text), expected);
        assert_eq!(whole("#usda 1.0\nfloat a = 0.5\n"), "#usda 1.0\nfloat a = 0.5\n");
    }

    #[test]
    fn replaced_parts_are_left_alone() {
        let replaced = Edit { range: 4..12, by: Replacement::Zeros };
        let places: Vec<usize> =
            edits(b"a = [.5, .5] .5", &[replaced]).iter().map(|edit| edit.range.start).collect();
        assert_eq!(places, [13]);
    }

    #[test]
    fn the_library_reads_them() {
        let text = "#usda 1.0\ndef \"A\" { double3 a = (.5, -.25, 2.) }\n";
        assert!(openusd::usda::parse(&whole(text)).is_ok());
        // Once it reads them by itself, this file can go.
        assert!(openusd::usda::parse(text).is_err());
    }
}
