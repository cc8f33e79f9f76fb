// SPDX-License-Identifier: GPL-3.0-or-later
//! Equal meshes: files that many prims refer to become one object, although no prim is instanceable.
//! Meshes are equal where two hashes of all that is read agree. Tests: `tests/composition.rs`.

use std::collections::hash_map::DefaultHasher;
use std::hash::{Hash, Hasher};

use gnurt_scene::subdivision::{Faces, Surface};

use crate::attributes::{Attribute, Spread};

/// A sum over the contents of a mesh: of small parts by two hashers, of long lists by lanes that are multiplied and folded.
pub(crate) struct Contents([DefaultHasher; 2], [u64; LANES]);

/// Words of 64 bits that are taken in at once.
const LANES: usize = 4;
/// An odd number for each lane: digits of pi.
const ODD: [u64; LANES] =
    [0x243f_6a88_85a3_08d3, 0x1319_8a2e_0370_7345, 0xa409_3822_299f_31d1, 0x082e_fa98_ec4e_6c89];

impl Contents {
    pub(crate) fn new() -> Self {
        let mut second = DefaultHasher::new();
        second.write_u8(1);
        Self([DefaultHasher::new(), second], ODD)
    }

    pub(crate) fn add(&mut self, part: &impl Hash) {
        self.0.iter_mut().for_each(|hasher| part.hash(hasher));
    }

    /// A long list.
    fn add_words(&mut self, mut words: impl Iterator<Item = u32>) {
        let (mut count, mut is_over) = (0_u64, false);
        while !is_over {
            for (lane, odd) in self.1.iter_mut().zip(ODD) {
                let mut next = || {
                    let word = words.next();
                    (count, is_over) = (count + u64::from(word.is_some()), is_over || word.is_none());
                    u64::from(word.unwrap_or_default())
                };
                let word = next() << 32 | next();
                let product = u128::from(*lane ^ word) * u128::from(odd);
                *lane = (product as u64 ^ (product >> 64) as u64).wrapping_add(word).rotate_left(23);
            }
        }
        self.add(&count);
    }

    pub(crate) fn add_floats(&mut self, values: &[f32]) {
        // Bits: all floats are equal to themselves.
        self.add_words(values.iter().map(|value| value.to_bits()));
    }

    pub(crate) fn add_flags(&mut self, flags: &[bool]) {
        self.add_words(flags.iter().map(|&flag| u32::from(flag)));
    }

    pub(crate) fn add_faces(&mut self, faces: &Faces) {
        self.add_words((0..faces.len()).map(|face| faces.range(face).end as u32));
        self.add_words(faces.corners().iter().copied());
    }

    pub(crate) fn add_attribute(&mut self, attribute: Option<&Attribute>) {
        let Some(Attribute { width, values, spread }) = attribute else { return self.add(&0_usize) };
        self.add(width);
        self.add_floats(values);
        match spread {
            Spread::Constant => self.add(&0),
            Spread::Faces(elements) => {
                self.add(&1);
                self.add_words(elements.iter().copied());
            }
            Spread::Points(elements, is_linear) => {
                self.add(&(2, is_linear));
                self.add_words(elements.iter().copied());
            }
            Spread::Corners(elements) => {
                self.add(&3);
                self.add_words(elements.iter().copied());
            }
        }
    }

    /// Rules of subdivision; its faces are those of the mesh.
    pub(crate) fn add_surface(&mut self, surface: Option<&Surface>) {
        let Some(Surface { scheme, boundary, creases, corners, .. }) = surface else { return self.add(&0) };
        self.add(&(1, *scheme as u8, *boundary as u8, creases.len()));
        creases.iter().for_each(|(edge, sharpness)| self.add(&(edge, sharpness.to_bits())));
        corners.iter().for_each(|(vertex, sharpness)| self.add(&(vertex, sharpness.to_bits())));
    }

    pub(crate) fn sum(mut self) -> [u64; 2] {
        let lanes = self.1;
        self.add(&lanes);
        [self.0[0].finish(), self.0[1].finish()]
    }
}
