// SPDX-License-Identifier: GPL-3.0-or-later
//! Packages (`.usdz`): zip archives whose entries are stored as they are.
//! Source: PKWARE's application note of zip; the USDZ specification, which allows neither compression nor encryption.
//! Invariant: an entry is a part of the file, so that no package becomes larger than it is. Tests: `tests/packages.rs`.

/// An archive in memory.
pub(crate) struct Package<'a> {
    bytes: &'a [u8],
    entries: Vec<Entry>,
}

struct Entry {
    name: String,
    is_stored: bool,
    /// Of its own header.
    header: usize,
    length: usize,
}

const NO_ARCHIVE: &str = "not a zip archive; a USDZ package is one";

fn number(bytes: &[u8], at: usize, width: usize) -> Option<usize> {
    let digits = bytes.get(at..at.checked_add(width)?)?;
    Some(digits.iter().rev().fold(0, |sum, &digit| sum << 8 | usize::from(digit)))
}

impl<'a> Package<'a> {
    /// Reads the list of entries.
    pub(crate) fn open(bytes: &'a [u8]) -> Result<Self, String> {
        const END: &[u8] = b"PK\x05\x06";
        // A comment of up to 65535 bytes may follow.
        let least = bytes.len().saturating_sub(22 + 65535);
        let end = (least..bytes.len().saturating_sub(21)).rev().find(|&at| bytes[at..].starts_with(END));
        let end = end.ok_or(NO_ARCHIVE)?;
        let damaged = || "damaged list of entries".to_owned();
        let count = number(bytes, end + 10, 2).ok_or_else(damaged)?;
        let mut at = number(bytes, end + 16, 4).ok_or_else(damaged)?;
        let mut entries = Vec::new();
        for _ in 0..count {
            if !bytes.get(at..).is_some_and(|rest| rest.starts_with(b"PK\x01\x02")) {
                return Err(damaged());
            }
            let field = |offset: usize, width: usize| number(bytes, at + offset, width).ok_or_else(damaged);
            let (flags, method, length) = (field(8, 2)?, field(10, 2)?, field(20, 4)?);
            let [name, extra, comment] = [field(28, 2)?, field(30, 2)?, field(32, 2)?];
            let name_bytes = bytes.get(at + 46..at + 46 + name).ok_or_else(damaged)?;
            entries.push(Entry {
                name: String::from_utf8_lossy(name_bytes).into_owned(),
                is_stored: method == 0 && flags & 1 == 0,
                header: field(42, 4)?,
                length,
            });
            at += 46 + name + extra + comment;
        }
        Ok(Self { bytes, entries })
    }

    /// The name of the entry that the package shows: the first one, which must be a layer.
    pub(crate) fn first_layer(&self) -> Result<&str, String> {
        let is_layer = |name: &str| {
            let name = name.to_ascii_lowercase();
            [".usd", ".usda", ".usdc"].iter().any(|extension| name.ends_with(extension))
        };
        let first = self.entries.first().map(|entry| &entry.name[..]);
        first.filter(|name| is_layer(name)).ok_or_else(|| match first {
            Some(first) => {
                format!("its first entry is '{first}'; a package begins with a .usd, .usda or .usdc")
            }
            None => "no entries; a package begins with a .usd, .usda or .usdc".to_owned(),
        })
    }

    /// The bytes of an entry.
    pub(crate) fn entry(&self, name: &str) -> Result<&'a [u8], String> {
        let entry = self.entries.iter().find(|entry| entry.name == name);
        let entry = entry.ok_or_else(|| format!("no entry '{name}'"))?;
        if !entry.is_stored {
            return Err(format!(
                "entry '{name}' is compressed or encrypted; USDZ stores entries as they are"
            ));
        }
        let damaged = || format!("entry '{name}' is damaged");
        let names = |at| number(self.bytes, entry.header + at, 2).ok_or_else(damaged);
        let begin = entry.header + 30 + names(26)? + names(28)?;
        self.bytes.get(begin..begin.saturating_add(entry.length)).ok_or_else(damaged)
    }
}
