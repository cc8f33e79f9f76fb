// SPDX-License-Identifier: GPL-3.0-or-later
//! Queries of objects and scenes: the same methods for both. Each file defines them once, for both. See
//! docs/reference/queries.md.

mod faces;
mod many;
mod rays;
mod surfaces;
