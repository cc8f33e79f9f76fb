// SPDX-License-Identifier: GPL-3.0-or-later
//! Long arrays of numbers in text layers: found while the text is looked over, read in pieces by all threads.
//! Anything that is not written plainly stays in the text, for the library to read or to reject. Tests: `tests/arrays.rs`.

use std::ops::Range;
use std::sync::{Mutex, PoisonError};

use gnurt_scene::io::reader::{Access, Cursor};
use openusd::gf::{Vec2f, Vec3f, Vec4f};
use openusd::sdf::Value;

use crate::arrays::{Array, Arrays};
use crate::layer::{Edit, Replacement};
use crate::stand_in::Kind;

/// Bytes of text; shorter arrays stay.
const LEAST: usize = 1024;
/// Bytes that a thread reads at a time.
const PIECE: usize = 1 << 18;

/// An array in a text.
#[derive(Clone, Debug)]
pub(crate) struct TextArray {
    kind: Kind,
    /// With its brackets.
    range: Range<usize>,
}

impl TextArray {
    /// The long array whose bracket opens at a place, if it is the value of an attribute: `float3[] name = [`.
    pub(crate) fn at(text: &[u8], at: usize) -> Option<Self> {
        let before = text[..at].trim_ascii_end().strip_suffix(b"=")?.trim_ascii_end();
        let is_of_name = |byte: &u8| byte.is_ascii_alphanumeric() || matches!(byte, b'_' | b':');
        let before = before.trim_suffix_of(is_of_name)?.trim_ascii_end().strip_suffix(b"[]")?;
        let kind = match before.suffix_of(u8::is_ascii_alphanumeric) {
            b"int" => Kind::Int,
            b"float" => Kind::Floats(1),
            b"float2" | b"texCoord2f" => Kind::Floats(2),
            b"float3" | b"point3f" | b"normal3f" | b"vector3f" | b"color3f" | b"texCoord3f" => {
                Kind::Floats(3)
            }
            b"float4" | b"color4f" => Kind::Floats(4),
            _ => return None,
        };
        let end = at + 1 + text[at..].chunks(64).position(|some| some.contains(&b']'))? * 64;
        let end = end + text[end - 1..].iter().position(|&byte| byte == b']')?;
        (end - at >= LEAST).then_some(Self { kind, range: at..end })
    }

    /// The place behind it.
    pub(crate) fn end(&self) -> usize {
        self.range.end
    }

    /// Its elements in pieces that end behind commas.
    fn pieces<'a>(&self, text: &'a [u8]) -> Vec<&'a [u8]> {
        let mut rest = &text[self.range.start + 1..self.range.end - 1];
        let mut pieces = Vec::new();
        while rest.len() > PIECE {
            let is_end = |at: &usize| match self.kind {
                Kind::Int | Kind::Floats(1) => rest[*at] == b',',
                // The comma behind a vector.
                Kind::Floats(_) => rest[*at] == b',' && rest[..*at].trim_ascii_end().ends_with(b")"),
            };
            let Some(end) = (PIECE..rest.len()).find(is_end) else { break };
            let (piece, behind) = rest.split_at(end + 1);
            pieces.push(piece);
            rest = behind;
        }
        pieces.push(rest);
        pieces
    }
}

/// Whether one of these words is anywhere outside of the arrays.
pub(crate) fn mentions(text: &[u8], found: &[TextArray], words: &[&[u8]]) -> bool {
    let ends = found.iter().map(|array| array.range.start).chain([text.len()]);
    let begins = [0].into_iter().chain(found.iter().map(TextArray::end));
    begins.zip(ends).any(|(begin, end)| {
        let some = &text[begin..end];
        words.iter().any(|word| some.windows(word.len()).any(|here| here == *word))
    })
}

/// Ends of texts.
trait Suffix {
    /// The last bytes of a kind.
    fn suffix_of(&self, is_of: impl Fn(&u8) -> bool) -> &Self;
    /// The text without them; `None` where there are none.
    fn trim_suffix_of(&self, is_of: impl Fn(&u8) -> bool) -> Option<&Self>;
}

impl Suffix for [u8] {
    fn suffix_of(&self, is_of: impl Fn(&u8) -> bool) -> &Self {
        &self[self.iter().rposition(|byte| !is_of(byte)).map_or(0, |at| at + 1)..]
    }

    fn trim_suffix_of(&self, is_of: impl Fn(&u8) -> bool) -> Option<&Self> {
        let length = self.suffix_of(is_of).len();
        (length > 0).then(|| &self[..self.len() - length])
    }
}

/// Edits that replace arrays by stand-ins.
pub(crate) fn edits(text: &[u8], found: &[TextArray], arrays: &Arrays, access: &Access) -> Vec<Edit> {
    let of = |array: usize| found[array].pieces(text).into_iter().map(move |piece| (array, piece));
    let pieces: Vec<(usize, &[u8])> = (0..found.len()).flat_map(of).collect();
    let read: Vec<Mutex<Option<Value>>> = pieces.iter().map(|_| Mutex::default()).collect();
    access.work(pieces.len(), &|i| {
        let (array, piece) = pieces[i];
        let value = elements(found[array].kind, piece);
        *read[i].lock().unwrap_or_else(PoisonError::into_inner) = value;
    });
    let mut read = read.into_iter().map(|slot| slot.into_inner().unwrap_or_else(PoisonError::into_inner));
    let mut counts = vec![0; found.len()];
    pieces.iter().for_each(|(array, _)| counts[*array] += 1);
    let mut edits = Vec::new();
    for (array, count) in found.iter().zip(counts) {
        let parts: Vec<Option<Value>> = read.by_ref().take(count).collect();
        let Some(value) = parts.into_iter().collect::<Option<Vec<Value>>>().and_then(joined) else {
            continue;
        };
        let Some(number) = arrays.add(Array::Read(value)) else { break };
        let mut by = array.kind.stand_in_text(number).into_bytes();
        // Places that the library names stay those of the file.
        by.extend(text[array.range.clone()].iter().filter(|&&byte| byte == b'\n'));
        edits.push(Edit { range: array.range.clone(), by: Replacement::Bytes(by) });
    }
    edits
}

/// The elements of pieces in one list.
fn joined(parts: Vec<Value>) -> Option<Value> {
    let mut parts = parts.into_iter();
    let mut all = parts.next()?;
    for part in parts {
        match (&mut all, part) {
            (Value::IntVec(all), Value::IntVec(part)) => all.extend(part),
            (Value::FloatVec(all), Value::FloatVec(part)) => all.extend(part),
            (Value::Vec2fVec(all), Value::Vec2fVec(part)) => all.extend(part),
            (Value::Vec3fVec(all), Value::Vec3fVec(part)) => all.extend(part),
            (Value::Vec4fVec(all), Value::Vec4fVec(part)) => all.extend(part),
            _ => return None,
        }
    }
    Some(all)
}

/// The elements of a piece.
fn elements(kind: Kind, piece: &[u8]) -> Option<Value> {
    Some(match kind {
        Kind::Int => Value::IntVec(list(piece, |cursor| i32::try_from(cursor.integer()?).ok())?),
        Kind::Floats(1) => Value::FloatVec(list(piece, Cursor::single)?),
        Kind::Floats(2) => Value::Vec2fVec(list(piece, |c| vector(c).map(|[x, y]| Vec2f { x, y }))?),
        Kind::Floats(3) => Value::Vec3fVec(list(piece, |c| vector(c).map(|[x, y, z]| Vec3f { x, y, z }))?),
        Kind::Floats(_) => {
            Value::Vec4fVec(list(piece, |c| vector(c).map(|[x, y, z, w]| Vec4f { x, y, z, w }))?)
        }
    })
}

/// Elements with commas between them, and perhaps behind the last.
#[inline(always)]
fn list<'a, T>(piece: &'a [u8], element: impl Fn(&mut Cursor<'a>) -> Option<T>) -> Option<Vec<T>> {
    let mut cursor = Cursor::new(piece);
    let mut all = Vec::new();
    loop {
        cursor.skip_while(is_blank);
        if cursor.at() == piece.len() {
            return Some(all);
        }
        all.push(element(&mut cursor)?);
        cursor.skip_while(is_blank);
        if cursor.at() < piece.len() {
            cursor.word(b",")?;
        }
    }
}

/// `(1, 2, 3)`.
#[inline(always)]
fn vector<const N: usize>(cursor: &mut Cursor<'_>) -> Option<[f32; N]> {
    cursor.word(b"(")?;
    let mut all = [0.0; N];
    for (k, number) in all.iter_mut().enumerate() {
        if k > 0 {
            cursor.word(b",")?;
        }
        cursor.skip_while(is_blank);
        *number = cursor.single()?;
        cursor.skip_while(is_blank);
    }
    cursor.word(b")")?;
    Some(all)
}

fn is_blank(byte: u8) -> bool {
    matches!(byte, b' ' | b'\n' | b'\t' | b'\r')
}

#[cfg(test)]
mod tests {
    use gnurt_scene::io::LoadOptions;
    use openusd::sdf::{AbstractData, Path};

    use super::*;

    /// The array of a text as it is read here, and by the library.
    fn both(kind: &str, array: &str) -> [Option<Value>; 2] {
        let head = format!("def \"A\" {{ {kind}[] a = ");
        let text = format!("#usda 1.0\n{head}{array} ( doc = \"x\" )\n}}\n");
        let access = Access::new(&LoadOptions { threads: 2, ..LoadOptions::default() }).expect("no folder");
        let (arrays, found) = (Arrays::default(), crate::text_check::check(text.as_bytes()).expect("text"));
        let edits = edits(text.as_bytes(), &found, &arrays, &access);
        let edited =
            crate::layer::Layer::new(std::sync::Arc::new(text.clone().into_bytes()), edits.clone()).bytes();
        let of = |text: &str| {
            let data = openusd::usda::parse(text).ok()?;
            let value = data.try_field(&Path::new("/A.a").expect("a path"), "default").expect("a field");
            value.map(std::borrow::Cow::into_owned)
        };
        let stand_in = of(std::str::from_utf8(&edited).expect("text"));
        let [ours] = arrays.replace([stand_in], &access);
        let lines = |text: &[u8]| text.iter().filter(|&&byte| byte == b'\n').count();
        assert_eq!(lines(&edited), lines(text.as_bytes()), "lines stay where they are");
        [(edits.len() == 1).then(|| ours.expect("an array")).flatten(), of(&text)]
    }

    #[test]
    fn arrays_are_those_of_the_library() {
        let numbers: Vec<String> = (0..90_000).map(|i| format!("{}", (i as f32 - 4e4) * 1.37e-3)).collect();
        let vectors = |width: usize| {
            let vectors = numbers.chunks_exact(width).map(|some| format!("({})", some.join(", ")));
            format!("[{}]", vectors.collect::<Vec<_>>().join(",\n  "))
        };
        let integers: Vec<String> = (0..90_000).map(|i| (i * 7919 % 100_003 - 500).to_string()).collect();
        for (kind, array) in [
            ("int", format!("[{}]", integers.join(","))),
            ("int", format!("[ {} , ]", integers.join(" ,\n"))),
            ("float", format!("[{}]", numbers.join(", "))),
            ("float", format!("[0.1234567890123456789, 1e-50, 7e38, {}]", numbers.join(", "))),
            ("float2", vectors(2)),
            ("texCoord2f", vectors(2)),
            ("point3f", vectors(3)),
            ("color4f", vectors(4)),
        ] {
            let [ours, theirs] = both(kind, &array);
            assert!(ours.is_some(), "{kind} is read here");
            assert!(ours == theirs, "{kind}: {}", &array[..60]);
        }
    }

    #[test]
    fn others_are_left_to_the_library() {
        let many = "1, ".repeat(1000);
        for (kind, array) in [
            ("int", "[1, 2, 3]".to_owned()),
            ("int", format!("[{many} # more\n 2]")),
            ("int", format!("[{many} 2.5]")),
            ("int", format!("[{many} 3000000000]")),
            ("int", format!("[{many} , 3]")),
            ("float", format!("[{many} inf]")),
            ("float", format!("[{many} nan]")),
            ("double", format!("[{many} 5]")),
            ("float3", format!("[{} (1, 2)]", "(1, 2, 3), ".repeat(500))),
            ("float3", format!("[{} (1, 2, 3, 4)]", "(1, 2, 3), ".repeat(500))),
        ] {
            let [ours, theirs] = both(kind, &array);
            assert!(ours.is_none() || ours == theirs, "{kind} {}", &array[array.len() - 20..]);
        }
    }
}
