// SPDX-License-Identifier: GPL-3.0-or-later
//! Edits of `inactiveIds` in text layers as plain lists, since the library reads lists of other metadata alone.
//! `append`, `prepend` and `add` of a layer count as its list; what it deletes or orders is left out. Words become blanks, so
//! that lines stay where they are. Tests: `tests/instancing.rs`.

use crate::text_check::quiet_end;

const NAME: &[u8] = b"inactiveIds";

/// The text with plain lists; `None` = it has no such edits. The text is one that `text_check` has looked over.
pub(crate) fn plain(text: &[u8]) -> Option<Vec<u8>> {
    if !text.windows(NAME.len()).any(|some| some == NAME) {
        return None;
    }
    let mut plain = text.to_vec();
    let (mut at, mut before) = (0, 0..0);
    while at < text.len() {
        if let Some(end) = quiet_end(text, at) {
            at = end;
            continue;
        }
        match text[at] {
            byte if byte.is_ascii_alphabetic() => {
                let length = text[at..].iter().position(|byte| !is_of_word(*byte)).unwrap_or(text.len() - at);
                let word = at..at + length;
                let blank = match (&text[word.clone()], &text[before.clone()]) {
                    (NAME, b"append" | b"prepend" | b"add") => before.clone(),
                    (NAME, b"delete" | b"reorder") => before.start..end_of_list(text, word.end),
                    _ => 0..0,
                };
                for byte in plain[blank].iter_mut().filter(|byte| **byte != b'\n') {
                    *byte = b' ';
                }
                (at, before) = (word.end, word);
            }
            _ => at += 1,
        }
    }
    Some(plain)
}

fn is_of_word(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || matches!(byte, b'_' | b':')
}

/// Behind the closing bracket of the list after a name.
fn end_of_list(text: &[u8], name: usize) -> usize {
    text[name..].iter().position(|&byte| byte == b']').map_or(name, |length| name + length + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_become_blanks() {
        let text = b"def A \"append inactiveIds\" (\n  append inactiveIds = [2]\n  delete inactiveIds = [3,\n 4]\n) # add inactiveIds\n";
        let found = plain(text).expect("edits");
        let expected = b"def A \"append inactiveIds\" (\n         inactiveIds = [2]\n                          \n   \n) # add inactiveIds\n";
        assert_eq!(String::from_utf8_lossy(&found), String::from_utf8_lossy(expected));
        assert_eq!(plain(b"#usda 1.0\n"), None);
    }
}
