// SPDX-License-Identifier: GPL-3.0-or-later
//! Embree's scenes of instances, behind safe functions. Source: the public headers of Embree 4.4 (rtcore_geometry.h,
//! rtcore_common.h), from which names and numbers are restated; the other declarations are in `ffi_embree.rs`.
//! Invariant: an instance holds the scene that it shows, so that may be dropped before. Tests: `top::tests`.

use std::ffi::{c_int, c_uint};
use std::marker::PhantomData;

use crate::ffi_embree::{Device, Handle, Scene};

const GEOMETRY_INSTANCE: c_int = 121;
const FORMAT_FLOAT3X4_COLUMNS: c_int = 0x9234;

/// Where an instance is at a step: RTCQuaternionDecomposition.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(16))]
pub(crate) struct Turned {
    scale: [f32; 3],
    skew: [f32; 3],
    shift: [f32; 3],
    /// The real part first.
    quaternion: [f32; 4],
    translation: [f32; 3],
}

impl Turned {
    /// Scaled, rotated about y, moved.
    pub(crate) fn about_y(size: f32, angle: f32, translation: [f32; 3]) -> Self {
        let (sine, cosine) = (0.5 * angle).sin_cos();
        let quaternion = [cosine, 0.0, sine, 0.0];
        Self { scale: [size; 3], skew: [0.0; 3], shift: [0.0; 3], quaternion, translation }
    }
}

/// A scene of instances, with the handles for updates of their transforms.
pub(crate) struct Instances<'a> {
    pub(crate) scene: Scene<'a>,
    geometries: Vec<Handle>,
}

impl<'a> Instances<'a> {
    /// `count` instances of a scene, not yet placed nor committed.
    pub(crate) fn new(
        device: &'a Device<'a>,
        shown: &Scene<'a>,
        count: usize,
        quality: i32,
        flags: i32,
    ) -> Self {
        let library = device.library;
        // SAFETY: handles are used as Embree's manual shows; the scene holds its geometries, which hold their
        // scenes.
        unsafe {
            let raw = (library.new_scene)(device.raw);
            (library.set_quality)(raw, quality);
            (library.set_flags)(raw, flags);
            let geometries = (0..count)
                .map(|_| {
                    let geometry = (library.new_geometry)(device.raw, GEOMETRY_INSTANCE);
                    (library.set_instanced)(geometry, shown.raw);
                    (library.attach)(raw, geometry);
                    (library.release_geometry)(geometry);
                    geometry
                })
                .collect();
            Self { scene: Scene { library, raw, arrays: PhantomData }, geometries }
        }
    }

    /// Moves the instances: columns of affine maps, one for each instance.
    pub(crate) fn set_matrices(&self, columns: &[[[f32; 3]; 4]]) {
        assert_eq!(columns.len(), self.geometries.len(), "a place for each instance");
        let first: c_uint = 0;
        for (geometry, columns) in self.geometries.iter().zip(columns) {
            // SAFETY: the scene holds the geometry; twelve floats are read, and copied.
            unsafe {
                (self.scene.library.set_transform)(
                    *geometry,
                    first,
                    FORMAT_FLOAT3X4_COLUMNS,
                    columns.as_ptr().cast(),
                );
                (self.scene.library.commit_geometry)(*geometry);
            }
        }
    }

    /// Gives each instance transforms evenly spaced over the time, between which it rotates along the arc.
    pub(crate) fn set_moving_matrices(&self, paths: &[Vec<Turned>]) {
        assert_eq!(paths.len(), self.geometries.len(), "a way for each instance");
        let library = self.scene.library;
        for (geometry, path) in self.geometries.iter().zip(paths) {
            // SAFETY: the scene holds the geometry; a structure of sixteen floats is read at each step, and copied.
            unsafe {
                (library.set_time_steps)(*geometry, path.len() as c_uint);
                for (step, turned) in (0..).zip(path) {
                    (library.set_turned)(*geometry, step, (&raw const *turned).cast());
                }
                (library.commit_geometry)(*geometry);
            }
        }
    }

    /// Builds the tree over them.
    pub(crate) fn commit(&mut self) {
        // SAFETY: there is no concurrent query of the scene.
        unsafe { (self.scene.library.commit_scene)(self.scene.raw) };
    }
}
