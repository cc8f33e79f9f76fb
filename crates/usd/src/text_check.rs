// SPDX-License-Identifier: GPL-3.0-or-later
//! A look at text layers (`.usda`) before the library reads them: that they are text, and not too deep.
//! Tests: `tests/broken.rs`.

use crate::text_arrays::TextArray;

/// Brackets that may be open at once.
const DEEPEST: u32 = 512;

/// Looks a layer over. Returns its long arrays.
pub(crate) fn check(bytes: &[u8]) -> Result<Vec<TextArray>, String> {
    let begin = if bytes.starts_with(b"\xef\xbb\xbf") { 3 } else { 0 };
    if !bytes[begin..].starts_with(b"#usda ") {
        return Err("neither '#usda' nor 'PXR-USDC' at its beginning; this is no USD layer".to_owned());
    }
    if let Err(error) = std::str::from_utf8(bytes) {
        let line = 1 + bytes[..error.valid_up_to()].iter().filter(|&&byte| byte == b'\n').count();
        return Err(format!("line {line}: text that is no UTF-8"));
    }
    let (mut depth, mut line, mut at) = (0_u32, 1_usize, begin);
    let mut arrays = Vec::new();
    while let Some(&byte) = bytes.get(at) {
        match byte {
            b'\n' => line += 1,
            b'#' => at += bytes[at..].iter().position(|&byte| byte == b'\n').unwrap_or(bytes.len() - at) - 1,
            quote @ (b'"' | b'\'' | b'@') => {
                let end = string_end(&bytes[at..], quote)
                    .ok_or_else(|| format!("line {line}: text without end"))?;
                line += bytes[at..at + end].iter().filter(|&&byte| byte == b'\n').count();
                at += end - 1;
            }
            b'[' if let Some(array) = TextArray::at(bytes, at) => {
                line += bytes[at..array.end()].iter().filter(|&&byte| byte == b'\n').count();
                at = array.end() - 1;
                arrays.push(array);
            }
            b'{' | b'[' | b'(' => depth += 1,
            b'}' | b']' | b')' => depth = depth.saturating_sub(1),
            _ => {}
        }
        if depth > DEEPEST {
            return Err(format!("line {line}: more than {DEEPEST} brackets are open"));
        }
        at += 1;
    }
    Ok(arrays)
}

/// The end of the comment or the text in quotes that begins at a place, if one does.
pub(crate) fn quiet_end(text: &[u8], at: usize) -> Option<usize> {
    let rest = &text[at..];
    let length = match rest.first()? {
        b'#' => rest.iter().position(|&byte| byte == b'\n'),
        quote @ (b'"' | b'\'' | b'@') => string_end(rest, *quote),
        _ => return None,
    };
    Some(at + length.unwrap_or(rest.len()))
}

/// The length of the text in quotes at the beginning.
fn string_end(bytes: &[u8], quote: u8) -> Option<usize> {
    let triple = [quote; 3];
    let (mut at, close) = match bytes.starts_with(&triple) {
        true => (3, &triple[..]),
        false => (1, &triple[..1]),
    };
    loop {
        match bytes.get(at)? {
            b'\\' if quote != b'@' => at += 2,
            _ if bytes[at..].starts_with(close) => return Some(at + close.len()),
            _ => at += 1,
        }
    }
}
