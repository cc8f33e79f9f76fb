// SPDX-License-Identifier: GPL-3.0-or-later
//! Shaders of all kinds, asked as the renderer asks them.

#[path = "scripts/attributes.rs"]
mod attributes;
#[path = "scripts/closures.rs"]
mod closures;
#[path = "scripts/displacement.rs"]
mod displacement;
#[path = "scripts/floor.rs"]
mod floor;
#[path = "scripts/kinds.rs"]
mod kinds;
#[path = "scripts/lanes.rs"]
mod lanes;
#[path = "scripts/live.rs"]
mod live;
#[cfg(feature = "materialx")]
#[path = "scripts/mtlx.rs"]
mod mtlx;
#[path = "scripts/outputs.rs"]
mod outputs;
#[path = "scripts/pixels.rs"]
mod pixels;
#[path = "scripts/recipes.rs"]
mod recipes;
#[path = "scripts/relief.rs"]
mod relief;
#[path = "scripts/stored.rs"]
mod stored;
#[path = "scripts/tiles.rs"]
mod tiles;
#[path = "scripts/volumes.rs"]
mod volumes;
#[path = "scripts/wrong.rs"]
mod wrong;
