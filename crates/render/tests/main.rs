// SPDX-License-Identifier: GPL-3.0-or-later
//! Pictures and light.
//!
//! One program for all files: each of its own takes a second to link.

mod accumulation;
mod agreement;
mod appearance;
mod auto;
mod bands;
mod beams;
mod bumps;
mod caustics;
mod caustics_focus;
mod checkpoint;
mod commit;
mod common;
mod curves;
mod determinism;
mod displacement;
mod edits;
mod filtering;
mod guide;
mod holdouts;
mod interleave;
mod lanes;
mod light_layers;
mod light_links;
mod lights;
mod many_lights;
mod mattes;
mod media;
mod mirrors;
mod motion;
mod nested;
mod noise_color;
mod offsets;
mod opacity;
mod panes;
mod path;
mod persistent_lights;
mod pixels;
mod ray_masks;
mod references;
mod restricted;
mod scene_queries;
mod seen;
mod shader_emission;
mod shader_lights;
mod shadow_catcher;
mod shutter;
#[path = "common/signed.rs"]
mod signed;
mod sphere_lights;
mod subsurface;
mod terminator;
mod unlit;
mod velocity;
mod working_space;
