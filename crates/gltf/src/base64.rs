// SPDX-License-Identifier: GPL-3.0-or-later
//! Data URIs.
//! Source: RFC 2397 (data URIs), RFC 4648 (base64, both alphabets, padding optional).
//! Tests: `tests::decodes_and_refuses`.

/// The bytes of a data URI; `None` if `uri` is none or is broken.
pub(super) fn data_uri(uri: &str) -> Option<Vec<u8>> {
    let (kind, data) = uri.strip_prefix("data:")?.split_once(',')?;
    match kind.ends_with(";base64") {
        true => decode(data.as_bytes()),
        false => Some(gnurt_scene::io::reader::percent_decode(data)),
    }
}

fn decode(text: &[u8]) -> Option<Vec<u8>> {
    let mut bytes = Vec::with_capacity(text.len() / 4 * 3 + 3);
    let (mut bits, mut count) = (0_u32, 0);
    for &symbol in text.iter().filter(|b| !b.is_ascii_whitespace() && **b != b'=') {
        let six = match symbol {
            b'A'..=b'Z' => symbol - b'A',
            b'a'..=b'z' => symbol - b'a' + 26,
            b'0'..=b'9' => symbol - b'0' + 52,
            b'+' | b'-' => 62,
            b'/' | b'_' => 63,
            _ => return None,
        };
        bits = bits << 6 | u32::from(six);
        count += 6;
        if count >= 8 {
            count -= 8;
            bytes.push((bits >> count) as u8);
        }
    }
    Some(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decodes_and_refuses() {
        assert_eq!(data_uri("data:,%00%80%3f"), Some(vec![0, 0x80, 0x3f]), "bytes that are no text");
        let decoded = |uri| data_uri(uri).map(|b| String::from_utf8_lossy(&b).into_owned());
        assert_eq!(decoded("data:;base64,SGVsbG8="), Some("Hello".into()), "padded");
        assert_eq!(decoded("data:a/b;base64,SGVsbG8"), Some("Hello".into()), "not padded");
        assert_eq!(decoded("data:,a%20b"), Some("a b".into()), "percent-encoded");
        assert_eq!(decoded("data:;base64,S*"), None, "no base64");
        assert_eq!(decoded("mesh.bin"), None, "a file name");
    }
}
