// SPDX-License-Identifier: GPL-3.0-or-later
//! The lossless codes of WebP: traversed up to the pixels, to find the memory of a decoder's tables. From RFC
//! 9649, section 3. A picture may have 65,536 groups of five codes; two hundred bytes of a file make a group
//! of which the decoder makes 120 KiB. Only the codes of one small picture are stored here.
//! Invariant: the decoder's tables are counted in full, unless both end with the same error.
//! Tests: `tests`, `tests/growth.rs`.

use std::io::Result;

use super::source::Source;

/// Symbols of the five codes of a group; the first has those of the cache of colours besides.
const ALPHABETS: [usize; 5] = [280, 256, 256, 256, 40];
/// Codes of lengths come in this order.
const LENGTH_ORDER: [usize; 19] = [17, 18, 0, 1, 2, 3, 4, 5, 16, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15];

/// Longest code that the decoder finds by one access to its table of 4 bytes an entry.
const TABLE_BITS: usize = 10;
/// The decoder's memory for each symbol with a longer code.
const LONG_SYMBOL_BYTES: u64 = 32;
/// And for a group with any codes.
const GROUP_BYTES: u64 = 1024;

/// Bytes that the decoder's tables take for a picture of this size whose codes are the next `length` bytes; no more than a
/// little above `most` are counted.
pub(super) fn table_bytes(source: &mut dyn Source, length: u64, size: [u32; 2], most: u64) -> Result<u64> {
    let mut codes = Codes { source, left: length, hold: 0, held: 0, tables: 0, most };
    // `None`: the codes end, or are none; so does the decoder.
    codes.picture(size)?;
    Ok(codes.tables)
}

/// Input bit by bit, the lowest bit of each byte first.
struct Codes<'a> {
    source: &'a mut dyn Source,
    /// Bytes that are left.
    left: u64,
    hold: u64,
    /// Bits in `hold`.
    held: u32,
    /// Memory of the tables, in bytes.
    tables: u64,
    most: u64,
}

/// Symbols by the length of their code and their value.
struct Code {
    /// How many codes have this length.
    counts: [u16; 16],
    symbols: Vec<u16>,
}

/// Gives `None` where there is none.
macro_rules! some {
    ($value:expr) => {
        match $value {
            Some(value) => value,
            None => return Ok(None),
        }
    };
}

impl Codes<'_> {
    /// Transforms, then the picture's groups of codes: how many.
    fn picture(&mut self, [mut width, height]: [u32; 2]) -> Result<Option<u32>> {
        let shrunk = |side: u32, bits: u32| side.div_ceil(1 << bits);
        while some!(self.bits(1)?) == 1 {
            match some!(self.bits(2)?) {
                0 | 1 => {
                    let bits = some!(self.bits(3)?) + 2;
                    some!(self.small_picture([shrunk(width, bits), shrunk(height, bits)])?);
                }
                2 => {}
                _ => {
                    let colors = some!(self.bits(8)?) + 1;
                    some!(self.small_picture([colors, 1])?);
                    width = shrunk(
                        width,
                        [0, 3, 3, 2, 2].get(colors as usize).copied().unwrap_or(u32::from(colors <= 16)),
                    );
                }
            }
        }
        let cached = some!(self.cache()?);
        let mut groups = 1;
        if some!(self.bits(1)?) == 1 {
            let bits = some!(self.bits(3)?) + 2;
            groups = some!(self.small_picture([shrunk(width, bits), shrunk(height, bits)])?) + 1;
        }
        for _ in 0..groups {
            some!(self.group(cached)?);
            if self.tables > self.most {
                return Ok(None);
            }
        }
        Ok(Some(groups))
    }

    /// A picture of one group of codes: gives the largest of its pixels' red and green, as one number.
    fn small_picture(&mut self, [width, height]: [u32; 2]) -> Result<Option<u32>> {
        let cached = some!(self.cache()?);
        let before = self.tables;
        let group = some!(self.group(cached)?);
        // They are gone before those of the picture are made.
        self.tables = before;
        let [green, red, blue, alpha, distance] = &group[..] else { return Ok(None) };
        let is_flat = [green, red, blue, alpha].iter().all(|code| code.symbols.len() == 1);
        let (mut largest, mut left) = (0, u64::from(width) * u64::from(height));
        while left > 0 {
            let first = some!(self.symbol(green)?);
            match first {
                0..256 => {
                    let pixel = some!(self.symbol(red)?) << 8 | first;
                    some!(self.symbol(blue)?);
                    some!(self.symbol(alpha)?);
                    largest = largest.max(pixel);
                    left -= if is_flat { left } else { 1 };
                }
                256..280 => {
                    let length = some!(self.prefixed(first - 256)?);
                    let from = some!(self.symbol(distance)?);
                    some!(self.prefixed(from)?);
                    left = some!(left.checked_sub(length.into()));
                }
                // The value before, or 0.
                _ => left -= 1,
            }
        }
        Ok(Some(largest))
    }

    /// Symbols of the cache of colours.
    fn cache(&mut self) -> Result<Option<usize>> {
        if some!(self.bits(1)?) == 0 {
            return Ok(Some(0));
        }
        let bits = some!(self.bits(4)?);
        Ok((1..=11).contains(&bits).then_some(1 << bits))
    }

    fn group(&mut self, cached: usize) -> Result<Option<Vec<Code>>> {
        self.tables += GROUP_BYTES;
        let mut group = Vec::with_capacity(ALPHABETS.len());
        for (i, symbols) in ALPHABETS.into_iter().enumerate() {
            group.push(some!(self.code(if i == 0 { symbols + cached } else { symbols })?));
        }
        Ok(Some(group))
    }

    fn code(&mut self, symbols: usize) -> Result<Option<Code>> {
        if some!(self.bits(1)?) == 1 {
            let count = some!(self.bits(1)?) + 1;
            let bits = if some!(self.bits(1)?) == 1 { 8 } else { 1 };
            let mut given = vec![some!(self.bits(bits)?) as u16];
            if count == 2 {
                given.push(some!(self.bits(8)?) as u16);
            }
            // Two are distinguished by a bit even if they are the same.
            let is_code = given.iter().all(|&symbol| usize::from(symbol) < symbols);
            let mut counts = [0; 16];
            counts[1] = count as u16;
            return Ok(is_code.then_some(Code { counts, symbols: given }));
        }
        let mut lengths = vec![0; symbols];
        let mut length_lengths = [0; LENGTH_ORDER.len()];
        let given = some!(self.bits(4)?) as usize + 4;
        for &index in &LENGTH_ORDER[..given] {
            length_lengths[index] = some!(self.bits(3)?) as u8;
        }
        let code = some!(Code::new(&length_lengths));
        some!(self.lengths(&code, &mut lengths)?);
        let code = some!(Code::new(&lengths));
        self.tables += code.table_bytes();
        Ok(Some(code))
    }

    /// Lengths of codes, with runs.
    fn lengths(&mut self, code: &Code, lengths: &mut [u8]) -> Result<Option<()>> {
        let mut steps = lengths.len();
        if some!(self.bits(1)?) == 1 {
            let bits = 2 + 2 * some!(self.bits(3)?);
            steps = 2 + some!(self.bits(bits)?) as usize;
            if steps > lengths.len() {
                return Ok(None);
            }
        }
        let (mut at, mut last) = (0, 8);
        while at < lengths.len() && steps > 0 {
            steps -= 1;
            let length = some!(self.symbol(code)?) as u8;
            let (length, run) = match length {
                0..16 => (length, 1),
                16 => (last, 3 + some!(self.bits(2)?) as usize),
                17 => (0, 3 + some!(self.bits(3)?) as usize),
                _ => (0, 11 + some!(self.bits(7)?) as usize),
            };
            some!(lengths.get_mut(at..at + run)).fill(length);
            if length != 0 {
                last = length;
            }
            at += run;
        }
        Ok(Some(()))
    }

    /// A length or a distance.
    fn prefixed(&mut self, prefix: u32) -> Result<Option<u32>> {
        if prefix < 4 {
            return Ok(Some(prefix + 1));
        }
        let bits = (prefix - 2) >> 1;
        Ok(Some(((2 + (prefix & 1)) << bits) + some!(self.bits(bits)?) + 1))
    }

    fn symbol(&mut self, code: &Code) -> Result<Option<u32>> {
        if let [only] = code.symbols[..] {
            return Ok(Some(only.into()));
        }
        // Codes of a length are successive numbers, after those of the length before.
        let (mut number, mut first, mut before) = (0_usize, 0, 0);
        for &count in &code.counts[1..] {
            number |= some!(self.bits(1)?) as usize;
            let count = usize::from(count);
            if number < first + count {
                return Ok(Some(code.symbols[before + number - first].into()));
            }
            before += count;
            first = (first + count) << 1;
            number <<= 1;
        }
        Ok(None)
    }

    /// The next `count` bits, at most 32.
    fn bits(&mut self, count: u32) -> Result<Option<u32>> {
        while self.held < count {
            let byte = match self.source.fill_buf()?.first() {
                Some(&byte) if self.left > 0 => byte,
                _ => return Ok(None),
            };
            self.source.consume(1);
            self.left -= 1;
            self.hold |= u64::from(byte) << self.held;
            self.held += 8;
        }
        let bits = self.hold & ((1 << count) - 1);
        self.hold >>= count;
        self.held -= count;
        Ok(Some(bits as u32))
    }
}

impl Code {
    /// Of the lengths of all symbols, 0 where a symbol has none; `None` if they are no code.
    fn new(lengths: &[u8]) -> Option<Self> {
        let mut symbols: Vec<u16> =
            (0..lengths.len() as u16).filter(|&s| lengths[usize::from(s)] > 0).collect();
        symbols.sort_by_key(|&symbol| lengths[usize::from(symbol)]);
        let mut counts = [0; 16];
        symbols.iter().for_each(|&symbol| counts[usize::from(lengths[usize::from(symbol)])] += 1);
        let taken: u32 = (1..16).map(|length| u32::from(counts[length]) << (15 - length)).sum();
        match symbols.len() {
            0 => None,
            1 => Some(Self { counts, symbols }),
            _ => (taken == 1 << 15).then_some(Self { counts, symbols }),
        }
    }

    /// The decoder's memory for it.
    fn table_bytes(&self) -> u64 {
        if self.symbols.len() == 1 {
            return 0;
        }
        let longest = self.counts.iter().rposition(|&count| count > 0).unwrap_or(0);
        let long: u64 = self.counts.iter().skip(TABLE_BITS + 1).map(|&count| u64::from(count)).sum();
        4 * (1 << longest.min(TABLE_BITS)) + LONG_SYMBOL_BYTES * long
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Cursor;

    /// Files of libwebp's encoder, with their transforms, caches and groups as another reader counted them.
    const FILES: [(&str, &[u8], u32); 2] = [
        ("green, predicted, correlated, a cache of 512", include_bytes!("../../tests/data/groups.webp"), 3),
        ("a palette of 12", include_bytes!("../../tests/data/palette.webp"), 3),
    ];

    /// Behind the heads of file and chunk, a letter, and the size.
    const BEGIN: usize = 25;

    fn size(file: &[u8]) -> [u32; 2] {
        let packed = u32::from_le_bytes([file[21], file[22], file[23], file[24]]);
        [packed, packed >> 14].map(|side| (side & 0x3fff) + 1)
    }

    fn walk(file: &[u8], length: usize) -> (Option<u32>, u64) {
        let mut source = Cursor::new(&file[BEGIN..]);
        let left = length as u64;
        let mut codes = Codes { source: &mut source, left, hold: 0, held: 0, tables: 0, most: u64::MAX };
        (codes.picture(size(file)).expect("memory can be read"), codes.tables)
    }

    #[test]
    fn groups_are_counted() {
        for (name, file, expected) in FILES {
            let (groups, tables) = walk(file, file.len() - BEGIN);
            assert_eq!(groups, Some(expected), "{name}");
            let least = u64::from(expected) * (GROUP_BYTES + 4);
            assert!((least..=least + 100_000).contains(&tables), "{name}: {tables} bytes");
        }
    }

    #[test]
    fn walks_end_where_files_do() {
        for (name, file, _) in FILES {
            let (_, whole) = walk(file, file.len() - BEGIN);
            let mut before = 0;
            for length in 0..file.len() - BEGIN {
                let (_, tables) = walk(file, length);
                assert!(tables <= whole, "{name} cut to {length}: {tables} of {whole} bytes");
                before = before.max(tables);
            }
            assert_eq!(before, whole, "{name}: all codes come before the last byte");
        }
    }
}
