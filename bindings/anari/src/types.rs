// SPDX-License-Identifier: GPL-3.0-or-later
//! ANARI's data types: their numbers, names and sizes, and the values of elements as four floats.
//! Source: the enumeration ANARIDataType of ANARI 1.1, whose facts are restated.
//! Numeric types come in groups of four, one for each number of components.
//! Tests: `tests`.

use gnurt::image::srgb;

/// A number of ANARIDataType.
pub type DataType = i32;

macro_rules! types {
    ($($name:ident = $value:literal),* $(,)?) => {
        $(pub const $name: DataType = $value;)*
        const NAMED: &[(&str, DataType)] = &[$((stringify!($name), $value)),*];
    };
}

types! {
    UNKNOWN = 0, DATA_TYPE = 100, STRING = 101, VOID_POINTER = 102, BOOL = 103,
    STRING_LIST = 150, DATA_TYPE_LIST = 151, PARAMETER_LIST = 152,
    FUNCTION_POINTER = 200, MEMORY_DELETER = 201, STATUS_CALLBACK = 202, FRAME_COMPLETION_CALLBACK = 203,
    LIBRARY = 500, DEVICE = 501, OBJECT = 502, ARRAY = 503, ARRAY1D = 504, ARRAY2D = 505, ARRAY3D = 506,
    CAMERA = 507, FRAME = 508, GEOMETRY = 509, GROUP = 510, INSTANCE = 511, LIGHT = 512, MATERIAL = 513,
    RENDERER = 514, SURFACE = 515, SAMPLER = 516, SPATIAL_FIELD = 517, VOLUME = 518, WORLD = 519,
    UFIXED8_R_SRGB = 2000, UFIXED8_RA_SRGB = 2001, UFIXED8_RGB_SRGB = 2002, UFIXED8_RGBA_SRGB = 2003,
    INT32_BOX1 = 2004, INT32_BOX2 = 2005, INT32_BOX3 = 2006, INT32_BOX4 = 2007,
    FLOAT32_BOX1 = 2008, FLOAT32_BOX2 = 2009, FLOAT32_BOX3 = 2010, FLOAT32_BOX4 = 2011,
    FLOAT32_MAT2 = 2012, FLOAT32_MAT3 = 2013, FLOAT32_MAT4 = 2014, FLOAT32_MAT2x3 = 2015,
    FLOAT32_MAT3x4 = 2016, FLOAT32_QUAT_IJKW = 2017,
    UINT64_REGION1 = 2104, UINT64_REGION2 = 2105, UINT64_REGION3 = 2106, UINT64_REGION4 = 2107,
    FLOAT64_BOX1 = 2208, FLOAT64_BOX2 = 2209, FLOAT64_BOX3 = 2210, FLOAT64_BOX4 = 2211,
}

/// First number of the numeric types.
const NUMERIC: DataType = 1000;
/// Their groups: name, bytes of a component, greatest value of those that stand for numbers up to 1.
const GROUPS: [(&str, usize, f64); 19] = [
    ("INT8", 1, 0.0),
    ("UINT8", 1, 0.0),
    ("INT16", 2, 0.0),
    ("UINT16", 2, 0.0),
    ("INT32", 4, 0.0),
    ("UINT32", 4, 0.0),
    ("INT64", 8, 0.0),
    ("UINT64", 8, 0.0),
    ("FIXED8", 1, i8::MAX as f64),
    ("UFIXED8", 1, u8::MAX as f64),
    ("FIXED16", 2, i16::MAX as f64),
    ("UFIXED16", 2, u16::MAX as f64),
    ("FIXED32", 4, i32::MAX as f64),
    ("UFIXED32", 4, u32::MAX as f64),
    ("FIXED64", 8, i64::MAX as f64),
    ("UFIXED64", 8, u64::MAX as f64),
    ("FLOAT16", 2, 0.0),
    ("FLOAT32", 4, 0.0),
    ("FLOAT64", 8, 0.0),
];

/// The type of a group's name with so many components, 1 to 4.
const fn numeric(group: i32, components: i32) -> DataType {
    NUMERIC + 4 * group + components - 1
}

pub const INT32: DataType = numeric(4, 1);
pub const UINT8: DataType = numeric(1, 1);
pub const UINT32: DataType = numeric(5, 1);
pub const UINT32_VEC2: DataType = numeric(5, 2);
pub const UINT32_VEC3: DataType = numeric(5, 3);
pub const UINT32_VEC4: DataType = numeric(5, 4);
pub const UINT64: DataType = numeric(7, 1);
pub const UINT64_VEC2: DataType = numeric(7, 2);
pub const UINT64_VEC3: DataType = numeric(7, 3);
pub const UINT64_VEC4: DataType = numeric(7, 4);
pub const FIXED8_VEC3: DataType = numeric(8, 3);
pub const FIXED8_VEC4: DataType = numeric(8, 4);
pub const UFIXED8: DataType = numeric(9, 1);
pub const UFIXED8_VEC2: DataType = numeric(9, 2);
pub const UFIXED8_VEC3: DataType = numeric(9, 3);
pub const UFIXED8_VEC4: DataType = numeric(9, 4);
pub const FIXED16: DataType = numeric(10, 1);
pub const FIXED16_VEC3: DataType = numeric(10, 3);
pub const FIXED16_VEC4: DataType = numeric(10, 4);
pub const UFIXED16: DataType = numeric(11, 1);
pub const UFIXED16_VEC2: DataType = numeric(11, 2);
pub const UFIXED16_VEC3: DataType = numeric(11, 3);
pub const UFIXED16_VEC4: DataType = numeric(11, 4);
pub const UFIXED32: DataType = numeric(13, 1);
pub const UFIXED32_VEC2: DataType = numeric(13, 2);
pub const UFIXED32_VEC3: DataType = numeric(13, 3);
pub const UFIXED32_VEC4: DataType = numeric(13, 4);
pub const FLOAT16: DataType = numeric(16, 1);
pub const FLOAT32: DataType = numeric(17, 1);
pub const FLOAT32_VEC2: DataType = numeric(17, 2);
pub const FLOAT32_VEC3: DataType = numeric(17, 3);
pub const FLOAT32_VEC4: DataType = numeric(17, 4);
pub const FLOAT64: DataType = numeric(18, 1);
pub const FLOAT64_VEC3: DataType = numeric(18, 3);

/// A numeric type's group, and its number of components.
fn group(kind: DataType) -> Option<(usize, usize)> {
    let index = usize::try_from(kind - NUMERIC).ok()?;
    (index / 4 < GROUPS.len()).then_some((index / 4, index % 4 + 1))
}

/// Bytes of a value; `None` for unknown types and those without a size.
pub fn size(kind: DataType) -> Option<usize> {
    if let Some((group, components)) = group(kind) {
        return Some(GROUPS[group].1 * components);
    }
    let floats = |count: usize| Some(4 * count);
    match kind {
        DATA_TYPE => Some(4),
        BOOL => Some(1),
        STRING | VOID_POINTER | STRING_LIST..=PARAMETER_LIST => Some(8),
        FUNCTION_POINTER..=FRAME_COMPLETION_CALLBACK | LIBRARY..=WORLD => Some(8),
        UFIXED8_R_SRGB..=UFIXED8_RGBA_SRGB => Some((kind - UFIXED8_R_SRGB + 1) as usize),
        INT32_BOX1..=INT32_BOX4 => Some(8 * (kind - INT32_BOX1 + 1) as usize),
        FLOAT32_BOX1..=FLOAT32_BOX4 => Some(8 * (kind - FLOAT32_BOX1 + 1) as usize),
        FLOAT64_BOX1..=FLOAT64_BOX4 => Some(16 * (kind - FLOAT64_BOX1 + 1) as usize),
        UINT64_REGION1..=UINT64_REGION4 => Some(16 * (kind - UINT64_REGION1 + 1) as usize),
        FLOAT32_MAT2 | FLOAT32_QUAT_IJKW => floats(4),
        FLOAT32_MAT3 => floats(9),
        FLOAT32_MAT4 => floats(16),
        FLOAT32_MAT2x3 => floats(6),
        FLOAT32_MAT3x4 => floats(12),
        _ => None,
    }
}

/// Its name as ANARI writes it.
pub fn name(kind: DataType) -> String {
    if let Some((group, components)) = group(kind) {
        let suffix = if components > 1 { format!("_VEC{components}") } else { String::new() };
        return format!("ANARI_{}{suffix}", GROUPS[group].0);
    }
    match NAMED.iter().find(|(_, value)| *value == kind) {
        Some((name, _)) => format!("ANARI_{name}"),
        None => format!("type {kind}"),
    }
}

/// Whether values are handles of objects.
pub fn is_object(kind: DataType) -> bool {
    (LIBRARY..=WORLD).contains(&kind)
}

/// Whether values are arrays.
pub fn is_array(kind: DataType) -> bool {
    (ARRAY..=ARRAY3D).contains(&kind)
}

/// A value as four floats: components that it lacks are 0, the fourth is 1; sRGB becomes linear. `None` for types that are no numbers, and
/// where bytes are missing.
pub fn decode(kind: DataType, bytes: &[u8]) -> Option<[f32; 4]> {
    let mut value = [0.0, 0.0, 0.0, 1.0];
    if let UFIXED8_R_SRGB..=UFIXED8_RGBA_SRGB = kind {
        let components = (kind - UFIXED8_R_SRGB + 1) as usize;
        let bytes = bytes.get(..components)?;
        for (c, &byte) in bytes.iter().enumerate() {
            // Red with opacity has its opacity in the second place.
            let opacity = (components == 4 && c == 3) || (components == 2 && c == 1);
            value[c] = if opacity { f32::from(byte) / 255.0 } else { srgb::decode(f32::from(byte) / 255.0) };
        }
        return Some(value);
    }
    let (group, components) = group(kind)?;
    let (_, width, most) = GROUPS[group];
    for (c, bytes) in bytes.get(..width * components)?.chunks_exact(width).enumerate() {
        let number = component(group, bytes)?;
        value[c] = if most > 0.0 { (number / most).max(-1.0) as f32 } else { number as f32 };
    }
    Some(value)
}

fn component(group: usize, bytes: &[u8]) -> Option<f64> {
    Some(match group {
        0 | 8 => f64::from(i8::from_ne_bytes(bytes.try_into().ok()?)),
        1 | 9 => f64::from(u8::from_ne_bytes(bytes.try_into().ok()?)),
        2 | 10 => f64::from(i16::from_ne_bytes(bytes.try_into().ok()?)),
        3 | 11 => f64::from(u16::from_ne_bytes(bytes.try_into().ok()?)),
        4 | 12 => f64::from(i32::from_ne_bytes(bytes.try_into().ok()?)),
        5 | 13 => f64::from(u32::from_ne_bytes(bytes.try_into().ok()?)),
        6 | 14 => i64::from_ne_bytes(bytes.try_into().ok()?) as f64,
        7 | 15 => u64::from_ne_bytes(bytes.try_into().ok()?) as f64,
        16 => f64::from(half::f16::from_ne_bytes(bytes.try_into().ok()?)),
        17 => f64::from(f32::from_ne_bytes(bytes.try_into().ok()?)),
        _ => f64::from_ne_bytes(bytes.try_into().ok()?),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_names_and_sizes_are_those_of_the_enumeration() {
        for (kind, name, size) in [
            (FLOAT32, "ANARI_FLOAT32", 4),
            (FLOAT32_VEC4, "ANARI_FLOAT32_VEC4", 16),
            (UFIXED8_VEC4, "ANARI_UFIXED8_VEC4", 4),
            (FIXED16_VEC3, "ANARI_FIXED16_VEC3", 6),
            (UINT64_VEC2, "ANARI_UINT64_VEC2", 16),
            (UFIXED8_RGBA_SRGB, "ANARI_UFIXED8_RGBA_SRGB", 4),
            (FLOAT32_BOX3, "ANARI_FLOAT32_BOX3", 24),
            (FLOAT32_MAT4, "ANARI_FLOAT32_MAT4", 64),
            (BOOL, "ANARI_BOOL", 1),
        ] {
            assert_eq!((super::name(kind).as_str(), super::size(kind)), (name, Some(size)), "type {kind}");
        }
        assert_eq!((FLOAT32, FLOAT32_VEC4, UFIXED8_VEC4, UINT32), (1068, 1071, 1039, 1020));
        assert_eq!((FIXED16_VEC3, UFIXED16_VEC4, FLOAT64, UINT64), (1042, 1047, 1072, 1028));
        assert_eq!(size(77), None, "no such type");
    }

    #[test]
    fn elements_become_floats() {
        assert_eq!(decode(UFIXED8_VEC2, &[255, 0]), Some([1.0, 0.0, 0.0, 1.0]), "what lacks is 0 0 0 1");
        assert_eq!(decode(FLOAT32, &0.25_f32.to_ne_bytes()), Some([0.25, 0.0, 0.0, 1.0]));
        assert_eq!(decode(FIXED16, &i16::MIN.to_ne_bytes()), Some([-1.0, 0.0, 0.0, 1.0]), "never below -1");
        let [red, green, blue, alpha] = decode(UFIXED8_RGBA_SRGB, &[255, 128, 0, 128]).expect("a colour");
        assert!((red - 1.0).abs() < 1e-6 && (green - 0.2159).abs() < 1e-3 && blue == 0.0, "sRGB is decoded");
        assert!((alpha - 128.0 / 255.0).abs() < 1e-6, "opacity is not");
        assert_eq!(decode(FLOAT32_VEC3, &[0; 8]), None, "bytes are missing");
        assert_eq!(decode(STRING, &[0; 8]), None, "no number");
    }
}
