// SPDX-License-Identifier: GPL-3.0-or-later
//! Values of attributes as plain numbers and words, whatever precision they are kept in. Tests: `tests/composition.rs`.

use openusd::gf::{Vec3f, f16};
use openusd::sdf::Value;

fn half(x: f16) -> f32 {
    x.to_f32()
}

/// One number.
pub(crate) fn number(value: &Value) -> Option<f64> {
    Some(match value {
        Value::Double(x) => *x,
        Value::Float(x) => f64::from(*x),
        Value::Half(x) => half(*x).into(),
        Value::Int(x) => f64::from(*x),
        Value::Uint(x) => f64::from(*x),
        Value::Int64(x) => *x as f64,
        Value::Uint64(x) => *x as f64,
        Value::Uchar(x) => f64::from(*x),
        Value::Bool(x) => f64::from(u8::from(*x)),
        Value::TimeCode(x) => x.0,
        _ => return None,
    })
}

/// Yes or no.
pub(crate) fn flag(value: &Value) -> Option<bool> {
    match value {
        Value::Bool(x) => Some(*x),
        other => number(other).map(|x| x != 0.0),
    }
}

/// A token or a string.
pub(crate) fn word(value: &Value) -> Option<String> {
    match value {
        Value::Token(token) => Some(token.as_str().to_owned()),
        Value::String(text) => Some(text.clone()),
        _ => None,
    }
}

/// Tokens or strings.
pub(crate) fn words(value: &Value) -> Option<Vec<String>> {
    match value {
        Value::TokenVec(tokens) => Some(tokens.iter().map(|token| token.as_str().to_owned()).collect()),
        Value::StringVec(texts) => Some(texts.clone()),
        _ => None,
    }
}

/// Whole numbers.
pub(crate) fn integers(value: &Value) -> Option<Vec<i32>> {
    match value {
        Value::IntVec(values) => Some(values.clone()),
        Value::UintVec(values) => Some(values.iter().map(|&x| i32::try_from(x).unwrap_or(-1)).collect()),
        Value::Int64Vec(values) => Some(values.iter().map(|&x| i32::try_from(x).unwrap_or(-1)).collect()),
        _ => None,
    }
}

/// The same; a list of 32 bits is not copied.
pub(crate) fn into_integers(value: Value) -> Option<Vec<i32>> {
    match value {
        Value::IntVec(values) => Some(values),
        other => integers(&other),
    }
}

/// Whole numbers of 64 bits.
pub(crate) fn long_integers(value: &Value) -> Option<Vec<i64>> {
    match value {
        Value::Int64Vec(values) => Some(values.clone()),
        Value::IntVec(values) => Some(values.iter().map(|&x| i64::from(x)).collect()),
        _ => None,
    }
}

/// All numbers of an array or of a single value, and how many make one element.
pub(crate) fn floats(value: &Value) -> Option<(usize, Vec<f32>)> {
    macro_rules! flat {
        ($values:expr, $width:expr, $($field:ident)+, $convert:expr) => {
            ($width, {
                let mut flat = Vec::with_capacity($width * $values.len());
                $values.iter().for_each(|v| flat.extend_from_slice(&[$($convert(v.$field)),+]));
                flat
            })
        };
    }
    let same = |x: f32| x;
    let single = |x: f64| x as f32;
    let whole = |x: i32| x as f32;
    Some(match value {
        Value::FloatVec(v) => (1, v.clone()),
        Value::DoubleVec(v) => (1, v.iter().map(|&x| x as f32).collect()),
        Value::HalfVec(v) => (1, v.iter().map(|&x| half(x)).collect()),
        Value::IntVec(v) => (1, v.iter().map(|&x| x as f32).collect()),
        Value::Vec2fVec(v) => flat!(v, 2, x y, same),
        Value::Vec2dVec(v) => flat!(v, 2, x y, single),
        Value::Vec2hVec(v) => flat!(v, 2, x y, half),
        Value::Vec3fVec(v) => flat!(v, 3, x y z, same),
        Value::Vec3dVec(v) => flat!(v, 3, x y z, single),
        Value::Vec3hVec(v) => flat!(v, 3, x y z, half),
        Value::Vec4fVec(v) => flat!(v, 4, x y z w, same),
        Value::Vec4dVec(v) => flat!(v, 4, x y z w, single),
        Value::Vec4hVec(v) => flat!(v, 4, x y z w, half),
        Value::Vec2f(v) => flat!([v], 2, x y, same),
        Value::Vec2d(v) => flat!([v], 2, x y, single),
        Value::Vec2h(v) => flat!([v], 2, x y, half),
        Value::Vec2i(v) => flat!([v], 2, x y, whole),
        Value::Vec3f(v) => flat!([v], 3, x y z, same),
        Value::Vec3d(v) => flat!([v], 3, x y z, single),
        Value::Vec3h(v) => flat!([v], 3, x y z, half),
        Value::Vec3i(v) => flat!([v], 3, x y z, whole),
        Value::Vec4f(v) => flat!([v], 4, x y z w, same),
        Value::Vec4d(v) => flat!([v], 4, x y z w, single),
        Value::Vec4h(v) => flat!([v], 4, x y z w, half),
        other => (1, vec![number(other)? as f32]),
    })
}

/// The same; lists of floats, also of two or three each, are not copied.
pub(crate) fn into_floats(value: Value) -> Option<(usize, Vec<f32>)> {
    match value {
        Value::FloatVec(values) => Some((1, values)),
        Value::Vec2fVec(values) => {
            let pairs: Vec<[f32; 2]> = values.into_iter().map(|v| [v.x, v.y]).collect();
            Some((2, pairs.into_flattened()))
        }
        Value::Vec3fVec(values) => Some((3, triples(values).into_flattened())),
        other => floats(&other),
    }
}

/// Groups of three numbers; lists of floats are not copied.
pub(crate) fn into_points(value: Value) -> Option<Vec<[f32; 3]>> {
    match value {
        Value::Vec3fVec(values) => Some(triples(values)),
        other => vectors(&other),
    }
}

/// In the same memory.
fn triples(values: Vec<Vec3f>) -> Vec<[f32; 3]> {
    values.into_iter().map(|v| [v.x, v.y, v.z]).collect()
}

/// Groups of `N` numbers: an array of vectors, or one vector.
pub(crate) fn vectors<const N: usize>(value: &Value) -> Option<Vec<[f32; N]>> {
    let (width, flat) = floats(value)?;
    (width == N).then(|| flat.as_chunks::<N>().0.to_vec())
}

/// One vector, in double precision.
pub(crate) fn vector<const N: usize>(value: &Value) -> Option<[f64; N]> {
    let doubles: Vec<f64> = match value {
        Value::Vec2d(v) => vec![v.x, v.y],
        Value::Vec3d(v) => vec![v.x, v.y, v.z],
        Value::Vec4d(v) => vec![v.x, v.y, v.z, v.w],
        other => floats(other)?.1.into_iter().map(f64::from).collect(),
    };
    (doubles.len() == N).then(|| std::array::from_fn(|k| doubles[k]))
}

/// Quaternions: the real part first.
pub(crate) fn quaternions(value: &Value) -> Option<Vec<[f64; 4]>> {
    let doubles = |v: [f32; 4]| v.map(f64::from);
    Some(match value {
        Value::QuatfVec(v) => v.iter().map(|q| doubles([q.w, q.x, q.y, q.z])).collect(),
        Value::QuathVec(v) => v.iter().map(|q| doubles([q.w, q.x, q.y, q.z].map(half))).collect(),
        Value::QuatdVec(v) => v.iter().map(|q| [q.w, q.x, q.y, q.z]).collect(),
        Value::Quatf(q) => vec![doubles([q.w, q.x, q.y, q.z])],
        Value::Quath(q) => vec![doubles([q.w, q.x, q.y, q.z].map(half))],
        Value::Quatd(q) => vec![[q.w, q.x, q.y, q.z]],
        _ => return None,
    })
}

/// Matrices of four rows: as rows that points are multiplied to from the left, which is as columns of our transforms.
pub(crate) fn matrices(value: &Value) -> Option<Vec<[f64; 16]>> {
    match value {
        Value::Matrix4d(m) => Some(vec![m.0]),
        Value::Matrix4dVec(all) => Some(all.iter().map(|m| m.0).collect()),
        _ => None,
    }
}
