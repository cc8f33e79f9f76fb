// SPDX-License-Identifier: GPL-3.0-or-later
//! One glTF primitive and its location, as `mesh` reads and `skin` deforms it. Source: glTF 2.0 section
//! 3.7.2.

use super::accessor;
use super::decoded::Decoded;
use super::document::Document;
use super::json::{Index, Primitive};
use gnurt_scene::io::Error;

/// One primitive and its location.
pub(super) struct PrimitiveReader<'a> {
    pub(super) document: &'a Document<'a>,
    pub(super) primitive: &'a Primitive,
    pub(super) location: &'a str,
    /// What Draco's stream holds, which replaces accessors.
    pub(super) decoded: Option<Decoded>,
}

impl PrimitiveReader<'_> {
    /// An accessor of the primitive as floats.
    pub(super) fn floats<const N: usize>(&self, index: Index) -> Result<Vec<[f32; N]>, Error> {
        accessor::floats(self.document, index, self.location, self.decoded.as_ref())
    }

    /// An accessor of the primitive as joints.
    pub(super) fn joints(&self, index: Index) -> Result<Vec<[u32; 4]>, Error> {
        accessor::joints(self.document, index, self.location, self.decoded.as_ref())
    }
}
