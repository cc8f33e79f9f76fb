// SPDX-License-Identifier: GPL-3.0-or-later
//! Long arrays of layers, which are read here instead of by the library: it decodes an array for each question about it,
//! on one thread. A layer hands it [stand-ins](crate::stand_in) instead, which it composes as any other value.
//! Values at moments are not replaced: the library blends them. Tests: `tests/arrays.rs`.

use std::cell::RefCell;
use std::sync::{Mutex, PoisonError};

use gnurt_scene::io::reader::Access;
use openusd::sdf::Value;

use crate::bytes::Fault;
use crate::packed_array::PackedArray;
use crate::stand_in::{MOST, number};

/// Elements from which on arrays are decoded side by side.
const LONG: u64 = 1 << 15;

/// An array.
#[derive(Debug)]
pub(crate) enum Array {
    Read(Value),
    Packed(PackedArray),
}

/// Arrays by the numbers of their stand-ins.
#[derive(Debug, Default)]
pub(crate) struct Arrays(RefCell<Vec<Array>>);

impl Arrays {
    /// The number of one more array; `None` if there are too many.
    pub(crate) fn add(&self, array: Array) -> Option<usize> {
        let mut all = self.0.borrow_mut();
        let number = all.len();
        (number < MOST).then(|| all.push(array))?;
        Some(number)
    }

    /// Values with the arrays in place of their stand-ins; long ones are decoded side by side.
    pub(crate) fn replace<const N: usize>(
        &self,
        mut values: [Option<Value>; N],
        access: &Access,
    ) -> [Result<Option<Value>, Fault>; N] {
        let all = self.0.borrow();
        let found = std::array::from_fn::<_, N, _>(|i| all.get(number(values[i].as_ref()?)?));
        let packed: Vec<(usize, &PackedArray)> = found
            .iter()
            .enumerate()
            .filter_map(|(i, array)| match array {
                Some(Array::Packed(packed)) => Some((i, packed)),
                _ => None,
            })
            .collect();
        let decoded: [Mutex<Option<Result<Value, Fault>>>; N] = std::array::from_fn(|_| Mutex::default());
        let decode = |i: usize| {
            let (place, packed) = packed[i];
            let value = packed.read();
            *decoded[place].lock().unwrap_or_else(PoisonError::into_inner) = Some(value);
        };
        match packed.len() > 1 && packed.iter().map(|(_, packed)| packed.count).sum::<u64>() >= LONG {
            true => access.work(packed.len(), &decode),
            false => (0..packed.len()).for_each(decode),
        }
        let mut decoded =
            decoded.into_iter().map(|slot| slot.into_inner().unwrap_or_else(PoisonError::into_inner));
        std::array::from_fn(|i| match (decoded.next().flatten(), found[i]) {
            (Some(value), _) => value.map(Some),
            (None, Some(Array::Read(value))) => Ok(Some(value.clone())),
            _ => Ok(values[i].take()),
        })
    }
}
