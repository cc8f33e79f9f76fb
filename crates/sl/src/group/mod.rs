// SPDX-License-Identifier: GPL-3.0-or-later
//! Groups of shaders: layers, their parameters' values, connections between them, and all that as a text.
//! Rules and text are OSL's.

mod connect;
mod layers;
mod reparameter;
mod serialize;
mod value;

pub use layers::{Connection, Group, Hint, Layer, Part};
pub use serialize::{Find, read_group, write_group};
pub use value::{Value, parse_value};
