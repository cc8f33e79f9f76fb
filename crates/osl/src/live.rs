// SPDX-License-Identifier: GPL-3.0-or-later
//! Parameters that change while shaders run. A shader asks for them like for values of the geometry, which are never folded.

use std::sync::atomic::{AtomicU32, Ordering};

use gnurt_sl::exec::Given;
use gnurt_sl::group::Value;
use gnurt_sl::hir::Data;
use gnurt_sl::types::{Base, Type};

/// A parameter that changes without compiling: numbers that all threads read.
#[derive(Debug)]
pub(crate) struct Live {
    pub(crate) layer: String,
    pub(crate) name: String,
    pub(crate) ty: Type,
    numbers: Vec<AtomicU32>,
}

impl Live {
    /// Of a layer's parameter; `None` for texts.
    pub(crate) fn new(layer: &str, name: &str, ty: Type, value: &Data) -> Option<Self> {
        let numbers = Self::bits(value)?.into_iter().map(AtomicU32::new).collect();
        Some(Self { layer: layer.to_owned(), name: name.to_owned(), ty, numbers })
    }

    /// Writes a value that fits; returns whether it does.
    pub(crate) fn set(&self, value: &Value) -> bool {
        let bits = value.fit(self.ty).and_then(|(_, data)| Self::bits(&data));
        let Some(bits) = bits.filter(|bits| bits.len() == self.numbers.len()) else { return false };
        self.numbers.iter().zip(bits).for_each(|(to, from)| to.store(from, Ordering::Relaxed));
        true
    }

    fn bits(value: &Data) -> Option<Vec<u32>> {
        match value {
            Data::Float(list) => Some(list.iter().map(|x| x.to_bits()).collect()),
            Data::Int(list) => Some(list.iter().map(|x| *x as u32).collect()),
            Data::Str(_) => None,
        }
    }

    /// Its value, where a shader asks for it.
    pub(crate) fn given(&self, name: &str, ty: Type) -> Option<Given> {
        if self.name != name || ty.size() != self.numbers.len() {
            return None;
        }
        let bits = self.numbers.iter().map(|number| number.load(Ordering::Relaxed));
        Some(match self.ty.base {
            Base::Int => Data::Int(bits.map(|x| x as i32).collect()).into(),
            _ => Data::Float(bits.map(f32::from_bits).collect()).into(),
        })
    }
}
