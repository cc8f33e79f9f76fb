// SPDX-License-Identifier: GPL-3.0-or-later
//! One glTF primitive and its location, as `mesh` reads and `skin` deforms it. Source: glTF 2.0 section
//! 3.7.2.

use super::document::Document;
use super::json::Primitive;

/// One primitive and its location.
pub(super) struct PrimitiveReader<'a> {
    pub(super) document: &'a Document<'a>,
    pub(super) primitive: &'a Primitive,
    pub(super) location: &'a str,
}
