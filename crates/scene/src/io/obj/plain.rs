// SPDX-License-Identifier: GPL-3.0-or-later
//! Words of a line of an OBJ file as nearly all files write them: numbers and corners, each a word of its own.
//! `None` leaves the others to [`statements`](super::statements). Tests: `tests`.

use crate::io::plain::Cursor;

/// Indices of a corner's position, texture coordinate and normal, or [`MISSING`].
pub(super) type PlainCorner = [i32; 3];

/// An index that is not written.
pub(super) const MISSING: i32 = i32::MIN;

/// Words of a line.
pub(super) trait Words {
    /// Steps over blanks; `None` where there is none.
    fn blanks(&mut self) -> Option<()>;
    /// Steps over blanks and the end of the line; `None`, and over blanks only, if there is more.
    fn end(&mut self) -> Option<()>;
    /// A decimal number that is a word.
    fn double(&mut self) -> Option<f64>;
    /// `v`, `v/t`, `v//n` or `v/t/n` as written; 31 bits are enough for nearly all files.
    fn corner(&mut self) -> Option<PlainCorner>;
}

impl Words for Cursor<'_> {
    #[inline(always)]
    fn blanks(&mut self) -> Option<()> {
        let before = self.at();
        self.skip_while(is_blank);
        (self.at() > before).then_some(())
    }

    #[inline(always)]
    fn end(&mut self) -> Option<()> {
        let _ = self.blanks();
        match self.peek() {
            b'\n' => self.skip(1),
            b'\r' => self.skip(if self.second() == Some(b'\n') { 2 } else { 1 }),
            _ => return None,
        }
        Some(())
    }

    #[inline]
    fn double(&mut self) -> Option<f64> {
        self.number().filter(|_| is_behind_word(self))
    }

    #[inline]
    fn corner(&mut self) -> Option<PlainCorner> {
        let mut indices = [MISSING; 3];
        for (k, slot) in indices.iter_mut().enumerate() {
            if k > 0 {
                if self.peek() != b'/' {
                    break;
                }
                self.skip(1);
                if self.peek() == b'/' || is_behind_word(self) {
                    continue;
                }
            }
            *slot = i32::try_from(self.integer()?).ok().filter(|&index| index != MISSING)?;
        }
        is_behind_word(self).then_some(indices)
    }
}

/// Whether blanks or the end of the line are next.
#[inline(always)]
fn is_behind_word(cursor: &Cursor<'_>) -> bool {
    let next = cursor.peek();
    is_blank(next) || next == b'\n' || next == b'\r'
}

#[inline(always)]
fn is_blank(byte: u8) -> bool {
    matches!(byte, b' ' | b'\t' | b'\x0c')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_in_all_forms() {
        let of = |text: &str| {
            let mut cursor = Cursor::new(text.as_bytes());
            let corner = cursor.corner()?;
            (cursor.at() == text.len()).then_some(corner)
        };
        assert_eq!(of("1"), Some([1, MISSING, MISSING]));
        assert_eq!(of("1/-2"), Some([1, -2, MISSING]));
        assert_eq!(of("1//3"), Some([1, MISSING, 3]));
        assert_eq!(of("-1/+2/3"), Some([-1, 2, 3]));
        assert_eq!(of("7/"), Some([7, MISSING, MISSING]));
        assert_eq!(of("7//"), Some([7, MISSING, MISSING]));
        assert_eq!(of("4000000000"), None, "left to others");
        for text in ["", "/1", "1/2/3/4", "1/x", "1.5", "99999999999999999999"] {
            assert_eq!(of(text), None, "{text}");
        }
    }
}
