// SPDX-License-Identifier: GPL-3.0-or-later
//! What an object and a scene can be asked: the same, in the same words. Each file says it once, for both.
//! See docs/reference/queries.md.

mod faces;
mod many;
mod rays;
mod surfaces;
