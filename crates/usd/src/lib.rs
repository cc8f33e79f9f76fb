// SPDX-License-Identifier: GPL-3.0-or-later
//! Universal Scene Description: stages as scenes, and scenes as layers.
//! The library `openusd` reads layers and composes them; here prims become meshes, materials, lights and cameras of a scene, at one moment.
//! See docs/reference/usd.md and docs/decisions/0035-usd.md.
#![forbid(unsafe_code)]

mod arrays;
mod atlas;
mod attributes;
mod bent;
mod binding;
mod builder;
mod bytes;
mod cameras;
mod contents;
mod crate_arrays;
mod crate_check;
mod crate_fields;
mod crate_parts;
mod crate_values;
mod files;
mod instancer;
mod layer;
mod lights;
mod load;
mod material;
mod mesh;
mod mtlx;
mod mtlx_layer;
mod network;
mod package;
mod packed_array;
mod pose;
mod reader;
mod save;
mod shapes;
mod skeleton;
mod skin;
mod stand_in;
mod strands;
mod text_arrays;
mod text_check;
mod text_lists;
mod text_numbers;
mod textures;
mod transform;
mod value;
mod volumes;
mod walk;
mod weld;

use gnurt_scene::io::Format;

/// The format, for a program's table.
pub const FORMAT: Format = Format {
    name: "USD",
    extensions: &["usda", "usdc", "usd", "usdz"],
    notes: "read at one moment: [USD](usd.md)",
    read: Some(load::load),
    read_whole: false,
    says_up: true,
    write: Some(save::WRITER),
};
