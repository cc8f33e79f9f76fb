// SPDX-License-Identifier: GPL-3.0-or-later
//! The objects that the device knows, and their parameters.

mod all;
mod entry;
mod geometries;
mod lights;
mod materials;
mod moving;
mod scenes;
mod views;

pub(crate) use all::{EXTENSIONS, extension_number, find, subtypes};
pub(crate) use entry::{Entry, Info, Parameter, Values};
