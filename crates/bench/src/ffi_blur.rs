// SPDX-License-Identifier: GPL-3.0-or-later
//! Embree's triangles with several time steps, behind safe functions. Source: the public headers of Embree 4.4
//! (rtcore_geometry.h), from which names and numbers are restated; the other declarations are in `ffi_embree.rs`.
//! Invariant: arrays outlive the scene that shares them. Tests: `blur::tests`.

use std::ffi::c_uint;

use crate::ffi_embree::{
    BUFFER_INDEX, BUFFER_VERTEX, Device, FORMAT_FLOAT3, FORMAT_UINT3, GEOMETRY_TRIANGLE, Scene,
};

impl<'a> Scene<'a> {
    /// Builds over triangles whose vertices have these positions at times evenly spaced from 0 to 1: two
    /// lists or more, each with one vertex more than there are; indices must be below the length of that.
    pub(crate) fn build_moving(
        device: &'a Device<'a>,
        keys: &'a [Vec<[f32; 3]>],
        indices: &'a [[u32; 3]],
        flags: i32,
    ) -> Result<Self, String> {
        let highest = indices.iter().flatten().max().map_or(0, |&i| i as usize + 1);
        let shortest = keys.iter().map(Vec::len).min().unwrap_or(0);
        assert!(highest < shortest, "index {highest} needs a vertex and one behind it: {shortest}");
        let library = device.library;
        // SAFETY: handles are used as Embree's manual shows. The arrays outlive the scene, every index is in range of each key,
        // and one vertex behind the last that is used makes 16 bytes readable from each.
        let scene = unsafe {
            let geometry = (library.new_geometry)(device.raw, GEOMETRY_TRIANGLE);
            (library.set_time_steps)(geometry, keys.len() as c_uint);
            let share = library.share_buffer;
            for (step, key) in (0..).zip(keys) {
                share(
                    geometry,
                    BUFFER_VERTEX,
                    step,
                    FORMAT_FLOAT3,
                    key.as_ptr().cast(),
                    0,
                    12,
                    key.len() - 1,
                );
            }
            let triangles = indices.as_ptr().cast();
            share(geometry, BUFFER_INDEX, 0, FORMAT_UINT3, triangles, 0, 12, indices.len());
            Self::of(device, geometry, 1, flags)
        };
        device.check()?;
        Ok(scene)
    }
}
