// SPDX-License-Identifier: GPL-3.0-or-later
//! Cryptomatte: for each pixel the things that cover it, ranked by coverage.
//! Source: see each file.

mod gather;
mod kinds;
mod layers;
mod name;
mod names;
mod tile;

pub(crate) use gather::gather;
pub use kinds::{MatteKind, Mattes};
pub(crate) use layers::add_mattes;
pub use name::matte_id;
pub use names::matte_names;
pub(crate) use names::{id_of_material, ids_of_instance};
pub(crate) use tile::TileMattes;
