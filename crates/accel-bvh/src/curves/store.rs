// SPDX-License-Identifier: GPL-3.0-or-later
//! Curves and their blocks in files. Tests: `tests/curves.rs` and `tests/saved.rs` of `gnurt-accel`.

use std::io::{self, Read, Write};
use std::sync::Arc;

use gnurt_accel_core::curve::{CurveBasis, CurveForm, OwnedCurves, Starts};
use gnurt_accel_core::store::{LoadError, Reader, StoredRecord, Writer, get_floats, put_floats};

use super::block::CurveBlock;
use crate::blocked::{BlockData, BlockKind};
use crate::node::WIDTH;

impl BlockData for Arc<OwnedCurves> {
    fn memory_bytes(&self) -> usize {
        OwnedCurves::memory_bytes(self)
    }

    fn save(&self, writer: &mut Writer<'_, impl Write>) -> io::Result<()> {
        let flags = self.basis as u64 | (self.form as u64) << 8 | u64::from(self.is_seen_from_outside) << 16;
        let flags = flags | u64::from(self.pieces) << 24;
        writer.number(flags)?;
        writer.list(self.vertices.as_flattened())?;
        writer.list(&self.indices)?;
        writer.list(self.tangents.as_flattened())?;
        writer.list(self.normals.as_flattened())?;
        writer.list(self.normal_tangents.as_flattened())?;
        writer.list(&self.joints.iter().map(|&bits| u32::from(bits)).collect::<Vec<_>>())
    }

    fn load(reader: &mut Reader<'_, impl Read>) -> Result<Self, LoadError> {
        const BASES: [CurveBasis; 5] = [
            CurveBasis::Linear,
            CurveBasis::Bezier,
            CurveBasis::BSpline,
            CurveBasis::CatmullRom,
            CurveBasis::Hermite,
        ];
        const FORMS: [CurveForm; 3] = [CurveForm::Flat, CurveForm::Round, CurveForm::Oriented];
        let flags = reader.number()?;
        let basis = BASES.get(flags as usize & 0xff);
        let form = FORMS.get(flags as usize >> 8 & 0xff);
        let (Some(&basis), Some(&form)) = (basis, form) else {
            return Err(LoadError::Damaged("curves of no kind"));
        };
        let mut floats = || reader.list::<f32>(u32::MAX as usize);
        let vertices = floats()?.as_chunks().0.to_vec();
        let indices = reader.list(u32::MAX as usize)?;
        let mut floats = || reader.list::<f32>(u32::MAX as usize);
        let tangents = floats()?.as_chunks().0.to_vec();
        let normals = floats()?.as_chunks().0.to_vec();
        let normal_tangents = floats()?.as_chunks().0.to_vec();
        let joints: Vec<u32> = reader.list(u32::MAX as usize)?;
        Ok(Self::new(OwnedCurves {
            starts: Starts::new(&indices),
            basis,
            form,
            vertices,
            indices,
            tangents,
            normals,
            normal_tangents,
            joints: joints.into_iter().map(|bits| bits as u8).collect(),
            is_seen_from_outside: flags >> 16 & 1 != 0,
            pieces: (flags >> 24) as u8,
        }))
    }
}

impl StoredRecord for CurveBlock {
    const LENGTH: usize = 3 * WIDTH + WIDTH / 4 + 5;

    fn put(&self, data: &mut [u32]) {
        let (words, rest) = data.split_at_mut(3 * WIDTH);
        let (radii, rest) = rest.split_at_mut(WIDTH / 4);
        let (origin, steps) = rest.split_at_mut(3);
        words[..2 * WIDTH].copy_from_slice(self.ends.as_flattened());
        words[2 * WIDTH..].copy_from_slice(&self.numbers);
        for (word, &four) in radii.iter_mut().zip(self.radius.as_chunks().0) {
            *word = u32::from_le_bytes(four);
        }
        put_floats(origin, &self.origin);
        for (word, two) in steps.iter_mut().zip(self.steps.as_chunks().0) {
            let &[low, high] = two;
            *word = u32::from(low) | u32::from(high) << 16;
        }
    }

    fn get(data: &[u32]) -> Self {
        let mut block = Self::empty();
        let (words, rest) = data.split_at(3 * WIDTH);
        let (radii, rest) = rest.split_at(WIDTH / 4);
        let (origin, steps) = rest.split_at(3);
        block.ends.as_flattened_mut().copy_from_slice(&words[..2 * WIDTH]);
        block.numbers.copy_from_slice(&words[2 * WIDTH..]);
        for (four, word) in block.radius.as_chunks_mut().0.iter_mut().zip(radii) {
            *four = word.to_le_bytes();
        }
        get_floats(&mut block.origin, origin);
        for (two, word) in block.steps.as_chunks_mut().0.iter_mut().zip(steps) {
            *two = [*word as u16, (word >> 16) as u16];
        }
        block
    }
}
