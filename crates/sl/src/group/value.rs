// SPDX-License-Identifier: GPL-3.0-or-later
//! Values of parameters as programs and command lines give them.
//! The forms are those of OSL's tools.

use crate::hir::Data;
use crate::types::{Base, Type};

/// A value and its type.
#[derive(Clone, Debug, PartialEq)]
pub struct Value {
    /// Its type.
    pub ty: Type,
    /// The value.
    pub data: Data,
}

impl Value {
    /// The value for a parameter of type `to`: triples of any meaning fit each other, a float fits all made of floats, arrays
    /// of fixed length take shorter and equal ones. The type is that of the parameter, its length now known.
    #[must_use]
    pub fn fit(&self, to: Type) -> Option<(Type, Data)> {
        let (a, b) = (self.ty, to);
        let triple = |t: Type| t.base.is_triple();
        let same = a.base == b.base || (triple(a) && triple(b));
        let ints = a.base == Base::Int && b.base == Base::Float;
        let data = match (&self.data, ints) {
            (Data::Int(list), true) => Data::Float(list.iter().map(|&v| v as f32).collect()),
            (data, _) => data.clone(),
        };
        if same || ints {
            if a.array == b.array {
                return Some((to, data));
            }
            if b.array < 0 && a.array >= 0 {
                return Some((to.array_of(a.array.max(1)), data));
            }
            if a.array > 0 && b.array >= a.array || a.array == 0 && b.array == 1 {
                return Some((to, data));
            }
        }
        // Plain floats for a triple, or an array of them.
        if a.base == Base::Float && triple(b) && a.array == 3 * b.array.max(1) {
            return Some((to, data));
        }
        let scalar = matches!(a.base, Base::Float | Base::Int) && !a.is_array() && !b.is_array();
        if scalar && (triple(b) || b.base == Base::Float) {
            let number = match &self.data {
                Data::Int(list) => list.first().map_or(0.0, |&v| v as f32),
                Data::Float(list) => list.first().copied().unwrap_or(0.0),
                Data::Str(_) => return None,
            };
            return Some((to, Data::Float(vec![number; b.size()])));
        }
        None
    }
}

impl From<f32> for Value {
    fn from(value: f32) -> Self {
        Self { ty: Type::FLOAT, data: Data::Float(vec![value]) }
    }
}

impl From<i32> for Value {
    fn from(value: i32) -> Self {
        Self { ty: Type::INT, data: Data::Int(vec![value]) }
    }
}

impl From<f64> for Value {
    /// A float: the nearest one.
    fn from(value: f64) -> Self {
        (value as f32).into()
    }
}

impl From<&str> for Value {
    fn from(value: &str) -> Self {
        Self { ty: Type::STRING, data: Data::Str(vec![value.into()]) }
    }
}

impl From<String> for Value {
    fn from(value: String) -> Self {
        value.as_str().into()
    }
}

impl From<[f32; 3]> for Value {
    /// A colour, point, vector or normal, as the parameter wants it.
    fn from(value: [f32; 3]) -> Self {
        Self { ty: Type::COLOR, data: Data::Float(value.to_vec()) }
    }
}

impl From<[f32; 16]> for Value {
    /// A matrix, row by row; points are rows.
    fn from(value: [f32; 16]) -> Self {
        Self { ty: Type::MATRIX, data: Data::Float(value.to_vec()) }
    }
}

impl From<[[f32; 4]; 4]> for Value {
    /// A matrix by its rows; points are rows.
    fn from(value: [[f32; 4]; 4]) -> Self {
        Self { ty: Type::MATRIX, data: Data::Float(value.concat()) }
    }
}

impl From<&[f32]> for Value {
    /// An array of floats; or of triples, by three floats for each.
    fn from(value: &[f32]) -> Self {
        Self { ty: Type::FLOAT.array_of(value.len() as i32), data: Data::Float(value.to_vec()) }
    }
}

impl From<&[[f32; 3]]> for Value {
    /// An array of colours, points, vectors or normals.
    fn from(value: &[[f32; 3]]) -> Self {
        Self { ty: Type::COLOR.array_of(value.len() as i32), data: Data::Float(value.concat()) }
    }
}

impl From<&[i32]> for Value {
    /// An array of ints.
    fn from(value: &[i32]) -> Self {
        Self { ty: Type::INT.array_of(value.len() as i32), data: Data::Int(value.to_vec()) }
    }
}

impl From<&[&str]> for Value {
    /// An array of texts.
    fn from(value: &[&str]) -> Self {
        let texts = value.iter().map(|text| (*text).into()).collect();
        Self { ty: Type::STRING.array_of(value.len() as i32), data: Data::Str(texts) }
    }
}

fn floats(text: &str) -> Option<Vec<f32>> {
    text.split(',').map(|keyword| keyword.trim().parse().ok()).collect()
}

/// A value from a command line: of the type, or of a type guessed from its text.
#[must_use]
pub fn parse_value(ty: Option<Type>, text: &str) -> Value {
    let free = ty.is_none();
    let is = |expected: Type| ty == Some(expected);
    if let Some(list) = floats(text) {
        if list.len() == 16 && (free || is(Type::MATRIX)) {
            return Value { ty: Type::MATRIX, data: Data::Float(list) };
        }
        if list.len() == 3 && (free || ty.is_some_and(Type::is_triple)) {
            return Value { ty: ty.unwrap_or(Type::VECTOR), data: Data::Float(list) };
        }
    }
    if let (Ok(number), true) = (text.trim().parse::<i32>(), free || is(Type::INT)) {
        return Value { ty: Type::INT, data: Data::Int(vec![number]) };
    }
    if let (Ok(number), true) = (text.trim().parse::<f32>(), free || is(Type::FLOAT)) {
        return Value { ty: Type::FLOAT, data: Data::Float(vec![number]) };
    }
    let ty = ty.unwrap_or(Type::STRING);
    let tokens = || text.split(',').map(str::trim);
    let data = match ty.base {
        Base::Int => {
            let mut list: Vec<i32> = tokens().map(|w| w.parse().unwrap_or(0)).collect();
            list.resize(ty.size().min(1 << 20), 0);
            Data::Int(list)
        }
        base if base.is_float_based() => {
            let mut list: Vec<f32> = tokens().map(|w| w.parse().unwrap_or(0.0)).collect();
            list.resize(ty.size().min(1 << 20), 0.0);
            Data::Float(list)
        }
        _ if ty.is_array() => {
            let mut list: Vec<_> = text.splitn(ty.elements().max(1), ',').map(Into::into).collect();
            list.resize(ty.elements().min(1 << 20), "".into());
            Data::Str(list)
        }
        _ => return Value { ty: Type::STRING, data: Data::Str(vec![text.into()]) },
    };
    Value { ty, data }
}
