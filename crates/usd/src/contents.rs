// SPDX-License-Identifier: GPL-3.0-or-later
//! Equal meshes: files that many prims refer to become one object, although no prim is instanceable.
//! Meshes are equal where two hashes of all that is read agree. Tests: `tests/composition.rs`.

use std::collections::hash_map::DefaultHasher;
use std::hash::{Hash, Hasher};

use gnurt_scene::subdivision::{Faces, Surface};

use crate::attributes::{Attribute, Elements, Spread};

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

    /// A long list, as words of 32 bits.
    #[inline]
    fn add_list<T: Copy>(&mut self, list: &[T], word: impl Fn(T) -> u32) {
        let (blocks, rest) = list.as_chunks::<{ 2 * LANES }>();
        let mut last = [0; 2 * LANES];
        last.iter_mut().zip(rest).for_each(|(to, &from)| *to = word(from));
        for words in blocks.iter().map(|block| block.map(&word)).chain([last]) {
            for ((lane, odd), [high, low]) in self.1.iter_mut().zip(ODD).zip(words.as_chunks::<2>().0) {
                let word = u64::from(*high) << 32 | u64::from(*low);
                let product = u128::from(*lane ^ word) * u128::from(odd);
                *lane = (product as u64 ^ (product >> 64) as u64).wrapping_add(word).rotate_left(23);
            }
        }
        self.add(&list.len());
    }

    pub(crate) fn add_floats(&mut self, values: &[f32]) {
        // Bits: all floats are equal to themselves.
        self.add_list(values, f32::to_bits);
    }

    pub(crate) fn add_flags(&mut self, flags: &[bool]) {
        self.add_list(flags, u32::from);
    }

    pub(crate) fn add_faces(&mut self, faces: &Faces) {
        self.add_list(faces.ends(), |end| end);
        self.add_list(faces.corners(), |corner| corner);
    }

    fn add_elements(&mut self, elements: &Elements) {
        match elements {
            Elements::InOrder(count) => self.add(&(0, count)),
            Elements::Listed(all) => self.add_list(all, |element| element),
        }
    }

    pub(crate) fn add_attribute(&mut self, attribute: Option<&Attribute>) {
        let Some(Attribute { width, values, spread }) = attribute else { return self.add(&0_usize) };
        self.add(width);
        self.add_floats(values);
        match spread {
            Spread::Constant => self.add(&0),
            Spread::Faces(elements) => {
                self.add(&1);
                self.add_elements(elements);
            }
            Spread::Points(elements, is_linear) => {
                self.add(&(2, is_linear));
                self.add_elements(elements);
            }
            Spread::Corners(elements) => {
                self.add(&3);
                self.add_elements(elements);
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
