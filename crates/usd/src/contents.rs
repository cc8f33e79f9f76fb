// SPDX-License-Identifier: GPL-3.0-or-later
//! Equal meshes: files that many prims refer to become one object, although no prim is instanceable.
//! Meshes are equal where two hashes of all that is read agree. Tests: `tests/composition.rs`.

use std::collections::hash_map::DefaultHasher;
use std::hash::{Hash, Hasher};

use gnurt_scene::subdivision::{Faces, Surface};

use crate::attributes::{Attribute, Spread};

/// A sum over the contents of a mesh.
pub(crate) struct Contents([DefaultHasher; 2]);

impl Contents {
    pub(crate) fn new() -> Self {
        let mut second = DefaultHasher::new();
        second.write_u8(1);
        Self([DefaultHasher::new(), second])
    }

    pub(crate) fn add(&mut self, part: &impl Hash) {
        self.0.iter_mut().for_each(|hasher| part.hash(hasher));
    }

    pub(crate) fn add_floats(&mut self, values: &[f32]) {
        self.add(&values.len());
        // Bits: all floats are equal to themselves.
        values
            .iter()
            .for_each(|value| self.0.iter_mut().for_each(|hasher| hasher.write_u32(value.to_bits())));
    }

    pub(crate) fn add_faces(&mut self, faces: &Faces) {
        self.add(&faces.len());
        (0..faces.len()).for_each(|face| self.add(&faces.range(face).end));
        self.add(&faces.corners());
    }

    pub(crate) fn add_attribute(&mut self, attribute: Option<&Attribute>) {
        let Some(Attribute { width, values, spread }) = attribute else { return self.add(&0_usize) };
        self.add(width);
        self.add_floats(values);
        match spread {
            Spread::Constant => self.add(&0),
            Spread::Faces(elements) => self.add(&(1, elements)),
            Spread::Points(elements, is_linear) => self.add(&(2, elements, is_linear)),
            Spread::Corners(elements) => self.add(&(3, elements)),
        }
    }

    /// Rules of subdivision; its faces are those of the mesh.
    pub(crate) fn add_surface(&mut self, surface: Option<&Surface>) {
        let Some(Surface { scheme, boundary, creases, corners, .. }) = surface else { return self.add(&0) };
        self.add(&(1, *scheme as u8, *boundary as u8, creases.len()));
        creases.iter().for_each(|(edge, sharpness)| self.add(&(edge, sharpness.to_bits())));
        corners.iter().for_each(|(vertex, sharpness)| self.add(&(vertex, sharpness.to_bits())));
    }

    pub(crate) fn sum(&self) -> [u64; 2] {
        [self.0[0].finish(), self.0[1].finish()]
    }
}
