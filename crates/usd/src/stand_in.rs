// SPDX-License-Identifier: GPL-3.0-or-later
//! Stand-ins for long arrays: two elements of the array's type, a mark and the number of the array. Tests: `tests`.

use openusd::sdf::Value;

/// The bits of a stand-in's first element, as a float or as an integer.
const MARK: u32 = 0x7e57_a11d;
/// Stand-ins of all layers: single precision holds their numbers.
pub(crate) const MOST: usize = 1 << 24;

/// A type of elements.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Int,
    /// Vectors of so many floats.
    Floats(usize),
}

impl Kind {
    /// Numbers of an element.
    fn width(self) -> usize {
        match self {
            Self::Int => 1,
            Self::Floats(width) => width,
        }
    }

    /// The two elements that stand for an array, as bytes.
    pub(crate) fn stand_in(self, number: usize) -> Vec<u8> {
        let second = match self {
            Self::Int => (number as u32).to_le_bytes(),
            Self::Floats(_) => (number as f32).to_le_bytes(),
        };
        [vec![MARK.to_le_bytes(); self.width()], vec![second; self.width()]].concat().into_flattened()
    }

    /// The same as text in brackets.
    pub(crate) fn stand_in_text(self, number: usize) -> String {
        let element = |text: String| match self.width() {
            1 => text,
            width => format!("({})", vec![text; width].join(", ")),
        };
        let mark = match self {
            Self::Int => MARK.to_string(),
            Self::Floats(_) => format!("{:e}", f32::from_bits(MARK)),
        };
        format!("[{}, {}]", element(mark), element(number.to_string()))
    }
}

/// The number of the array that a value stands for.
pub(crate) fn number(value: &Value) -> Option<usize> {
    let (mark, number) = match value {
        Value::IntVec(v) if v.len() == 2 => (v[0] as u32, v[1] as f32),
        Value::FloatVec(v) if v.len() == 2 => (v[0].to_bits(), v[1]),
        Value::Vec2fVec(v) if v.len() == 2 => (v[0].x.to_bits(), v[1].x),
        Value::Vec3fVec(v) if v.len() == 2 => (v[0].x.to_bits(), v[1].x),
        Value::Vec4fVec(v) if v.len() == 2 => (v[0].x.to_bits(), v[1].x),
        _ => return None,
    };
    (mark == MARK).then_some(number as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_read_as_the_same_numbers() {
        let types = [("int", Kind::Int), ("float", Kind::Floats(1)), ("texCoord2f", Kind::Floats(2))];
        let others = [("point3f", Kind::Floats(3)), ("color4f", Kind::Floats(4))];
        for (kind, of) in types.into_iter().chain(others) {
            for array in [0, 1, 77, MOST - 1] {
                let text = format!("#usda 1.0\ndef \"A\" {{ {kind}[] a = {} }}\n", of.stand_in_text(array));
                let data = openusd::usda::parse(&text).expect("a layer");
                let path = openusd::sdf::Path::new("/A.a").expect("a path");
                let value = openusd::sdf::AbstractData::try_field(&data, &path, "default").expect("a field");
                assert_eq!(number(&value.expect("a value")), Some(array), "{text}");
            }
        }
        assert_eq!(number(&Value::IntVec(vec![3, 4])), None);
    }
}
