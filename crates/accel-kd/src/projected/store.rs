// SPDX-License-Identifier: GPL-3.0-or-later
//! Saving and loading of projected triangles. The format is that of `crate::store`. Tests: `tests/saved.rs`.

use std::io::{self, Read, Write};

use super::{Projected, ProjectedTriangles};
use gnurt_accel_core::store::{LoadError, Reader, StoredRecord, Writer, get_floats, put_floats};

impl StoredRecord for Projected {
    const LENGTH: usize = 10;

    #[inline(always)]
    fn put(&self, words: &mut [u32]) {
        let Self { k, corner: [a, b, c], normal: [d, e], second: [f, g], third: [h, i] } = *self;
        words[0] = k;
        put_floats(&mut words[1..], &[a, b, c, d, e, f, g, h, i]);
    }

    #[inline(always)]
    fn get(words: &[u32]) -> Self {
        let mut floats = [0.0; 9];
        get_floats(&mut floats, &words[1..]);
        let [a, b, c, d, e, f, g, h, i] = floats;
        Self { k: words[0], corner: [a, b, c], normal: [d, e], second: [f, g], third: [h, i] }
    }
}

impl ProjectedTriangles {
    pub(crate) fn save(&self, writer: &mut Writer<'_, impl Write>) -> io::Result<()> {
        writer.list(&self.triangles)
    }

    pub(crate) fn load(reader: &mut Reader<'_, impl Read>, most: usize) -> Result<Self, LoadError> {
        Ok(Self { triangles: reader.list(most)? })
    }

    /// How many they are, if all of them can be tested. NaN only misses.
    pub(crate) fn check(&self) -> Result<usize, LoadError> {
        if self.triangles.iter().any(|triangle| triangle.k > 2) {
            return Err(LoadError::Damaged("a triangle is projected along no axis"));
        }
        Ok(self.triangles.len())
    }
}
