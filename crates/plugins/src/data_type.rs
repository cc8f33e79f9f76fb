// SPDX-License-Identifier: GPL-3.0-or-later
//! The types of a parameter's numbers: their codes in `openrt/types.h`, their sizes, and numbers from and to bytes.
//! Bytes are in the machine's order, as in C's memory. Tests: `tests`.

/// The type of a parameter's numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DataType {
    /// RT_BYTE.
    I8,
    /// RT_UNSIGNED_BYTE.
    U8,
    /// RT_SHORT.
    I16,
    /// RT_UNSIGNED_SHORT.
    U16,
    /// RT_INT: also the number of a texture.
    I32,
    /// RT_UNSIGNED_INT.
    U32,
    /// RT_FLOAT.
    F32,
    /// RT_DOUBLE.
    F64,
    /// RT_STRING.
    Text,
}

/// Codes of `openrt/types.h`.
const CODES: [(u32, DataType); 9] = [
    (0x1400, DataType::I8),
    (0x1401, DataType::U8),
    (0x1402, DataType::I16),
    (0x1403, DataType::U16),
    (0x1404, DataType::I32),
    (0x1405, DataType::U32),
    (0x1406, DataType::F32),
    (0x140A, DataType::F64),
    (0x140B, DataType::Text),
];

impl DataType {
    /// The type of this code, if parameters can have it.
    #[must_use]
    pub fn from_code(code: u32) -> Option<Self> {
        CODES.iter().find(|(known, _)| *known == code).map(|(_, kind)| *kind)
    }

    /// Bytes of one.
    #[must_use]
    pub fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
            Self::Text => size_of::<*const u8>(),
        }
    }

    /// A number from as many bytes as it has; texts are 0.
    #[must_use]
    pub fn decode(self, bytes: &[u8]) -> f64 {
        fn take<const N: usize>(bytes: &[u8]) -> [u8; N] {
            bytes.first_chunk().copied().unwrap_or([0; N])
        }
        match self {
            Self::I8 => f64::from(i8::from_ne_bytes(take(bytes))),
            Self::U8 => f64::from(u8::from_ne_bytes(take(bytes))),
            Self::I16 => f64::from(i16::from_ne_bytes(take(bytes))),
            Self::U16 => f64::from(u16::from_ne_bytes(take(bytes))),
            Self::I32 => f64::from(i32::from_ne_bytes(take(bytes))),
            Self::U32 => f64::from(u32::from_ne_bytes(take(bytes))),
            Self::F32 => f64::from(f32::from_ne_bytes(take(bytes))),
            Self::F64 => f64::from_ne_bytes(take(bytes)),
            Self::Text => 0.0,
        }
    }

    /// The bytes of an integer; `None` if the type does not hold it or is of another sort.
    #[must_use]
    pub fn encode_integer(self, value: i32) -> Option<Vec<u8>> {
        Some(match self {
            Self::I8 => i8::try_from(value).ok()?.to_ne_bytes().to_vec(),
            Self::U8 => u8::try_from(value).ok()?.to_ne_bytes().to_vec(),
            Self::I16 => i16::try_from(value).ok()?.to_ne_bytes().to_vec(),
            Self::U16 => u16::try_from(value).ok()?.to_ne_bytes().to_vec(),
            // No call takes unsigned integers: their bits come through the signed ones, as in OpenGL 1.x.
            Self::I32 | Self::U32 => value.to_ne_bytes().to_vec(),
            Self::F32 | Self::F64 | Self::Text => return None,
        })
    }

    /// The bytes of a number that people wrote; `None` if it is none of this type, or not finite.
    #[must_use]
    pub fn encode_text(self, text: &str) -> Option<Vec<u8>> {
        macro_rules! bytes {
            ($type:ty) => {
                text.parse::<$type>().ok().map(|number| number.to_ne_bytes().to_vec())
            };
        }
        match self {
            Self::I8 => bytes!(i8),
            Self::U8 => bytes!(u8),
            Self::I16 => bytes!(i16),
            Self::U16 => bytes!(u16),
            Self::I32 => bytes!(i32),
            Self::U32 => bytes!(u32),
            Self::F32 | Self::F64 if !text.parse::<f64>().is_ok_and(f64::is_finite) => None,
            Self::F32 => bytes!(f32),
            Self::F64 => bytes!(f64),
            Self::Text => None,
        }
    }

    /// Whether it is one of the integers.
    #[must_use]
    pub fn is_integer(self) -> bool {
        !matches!(self, Self::F32 | Self::F64 | Self::Text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integers_fit_or_are_refused() {
        let back = |kind: DataType, value| kind.encode_integer(value).map(|bytes| kind.decode(&bytes));
        assert_eq!(back(DataType::I8, -128), Some(-128.0), "the least byte");
        assert_eq!(back(DataType::I8, 128), None, "one more than the greatest");
        assert_eq!(back(DataType::U16, 65535), Some(65535.0), "the greatest");
        assert_eq!(back(DataType::U16, -1), None, "no sign");
        assert_eq!(back(DataType::U32, -1), Some(4_294_967_295.0), "its bits");
        assert_eq!(back(DataType::F32, 1), None, "a float is no integer");
    }

    #[test]
    fn codes_are_those_of_the_header() {
        assert_eq!(DataType::from_code(0x140A), Some(DataType::F64), "RT_DOUBLE");
        assert_eq!(DataType::from_code(0x1407), None, "RT_2_BYTES is no parameter's");
        assert_eq!(CODES.map(|(_, kind)| kind.size())[..8], [1, 1, 2, 2, 4, 4, 4, 8], "bytes");
    }
}
