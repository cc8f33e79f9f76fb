// SPDX-License-Identifier: GPL-3.0-or-later
//! What a shader asks of the program that runs it.
//! Source: original; the questions are those of OSL's renderer services.

use super::components::ClosureDecl;
use crate::hir::Data;
use crate::types::Type;
use gnurt_sl_lib::Dual;

/// The point that is shaded. Space: common.
#[derive(Clone, Debug, Default)]
pub struct Point {
    /// Position.
    pub p: Dual<[f32; 3]>,
    /// Direction of the ray that came here.
    pub i: Dual<[f32; 3]>,
    /// Shading normal.
    pub n: [f32; 3],
    /// Geometric normal.
    pub ng: [f32; 3],
    /// First surface parameter.
    pub u: Dual<f32>,
    /// Second surface parameter.
    pub v: Dual<f32>,
    /// Change of position with `u`.
    pub dpdu: [f32; 3],
    /// Change of position with `v`.
    pub dpdv: [f32; 3],
    /// Position that is lit, in light shaders.
    pub ps: Dual<[f32; 3]>,
    /// Time.
    pub time: f32,
    /// How long the shutter is open.
    pub dtime: f32,
    /// Motion of the point.
    pub dpdtime: [f32; 3],
    /// Area of the surface.
    pub surface_area: f32,
    /// Whether the back is seen.
    pub backfacing: bool,
    /// Whether the surface is mirrored.
    pub flipped: bool,
    /// Bits of the kinds of the ray, see [`Host::ray_kind`].
    pub ray_kinds: u32,
    /// Number of the point.
    pub index: i32,
}

/// A value from outside, with its derivatives if it has some.
#[derive(Clone, Debug)]
pub struct Given {
    /// The value.
    pub value: Data,
    /// Changes in x and y; empty for none.
    pub derivs: [Vec<f32>; 2],
}

impl From<Data> for Given {
    /// A value that does not change from pixel to pixel.
    fn from(value: Data) -> Self {
        Self { value, derivs: [Vec::new(), Vec::new()] }
    }
}

/// Answers. All have a default: the world is empty.
pub trait Host {
    /// The matrix from a named space to common space.
    fn common_from(&self, space: &str, point: &Point) -> Option<[[f32; 4]; 4]> {
        let _ = (space, point);
        None
    }

    /// The matrix from common space to a named one, where it is known without inverting the other.
    fn to_common_inverse(&self, space: &str, point: &Point) -> Option<[[f32; 4]; 4]> {
        self.common_from(space, point).map(|m| gnurt_sl_lib::matrix::inverse(&m))
    }

    /// A value that the geometry carries.
    fn userdata(&self, name: &str, ty: Type, point: &Point) -> Option<Given> {
        let _ = (name, ty, point);
        None
    }

    /// What `getattribute` asks for. `object` is empty for the object that is shaded.
    fn attribute(
        &self,
        object: &str,
        name: &str,
        index: Option<i32>,
        ty: Type,
        point: &Point,
    ) -> Option<Given> {
        let _ = (object, name, index, ty, point);
        None
    }

    /// Whether a ray hits something.
    fn trace(&self, p: Dual<[f32; 3]>, r: Dual<[f32; 3]>, point: &Point) -> bool {
        let _ = (p, r, point);
        false
    }

    /// What `getmessage("trace", ...)` asks for: a value, and whether the last ray hit.
    fn trace_message(&self, name: &str, ty: Type, point: &Point) -> (bool, Option<Given>) {
        let _ = (name, ty, point);
        (false, None)
    }

    /// What a closure takes; none if the program does not know it.
    fn closure(&self, name: &str) -> Option<&ClosureDecl> {
        let _ = name;
        None
    }

    /// The bit of a kind of ray; 0 if it is not known.
    fn ray_kind(&self, name: &str) -> u32 {
        let _ = name;
        0
    }

    /// The colour system of the shaders.
    fn color_system(&self) -> &gnurt_sl_lib::color::ColorSystem;
}
