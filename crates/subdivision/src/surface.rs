// SPDX-License-Identifier: GPL-3.0-or-later
//! Control meshes, their rules, and their refined surfaces.
//! Names and rules of boundaries as in USD's mesh schema. Tests: `tests/subdivision.rs`.

use super::topology::Faces;

/// Steps of refinement by default.
pub const LEVEL: u32 = 2;
/// Triangles that one surface may become; its level is lowered until it has fewer.
pub const MOST_TRIANGLES: u64 = 4_000_000;

/// Rules of refinement.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scheme {
    /// For all polygons.
    CatmullClark,
    /// For triangles.
    Loop,
    /// Faces are cut, nothing is smoothed.
    Bilinear,
}

/// Treatment of the surface at its boundary.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Boundary {
    /// Faces at the boundary are not shown.
    None,
    /// Boundary edges are sharp.
    EdgeOnly,
    /// So are vertices with one face.
    #[default]
    EdgeAndCorner,
}

/// A control mesh.
#[derive(Clone, Debug)]
pub struct Surface {
    /// Its rules.
    pub scheme: Scheme,
    /// At its boundary.
    pub boundary: Boundary,
    /// Its faces.
    pub faces: Faces,
    /// Sharp edges by their vertices; a sharpness of 10 or more never ends.
    pub creases: Vec<([u32; 2], f32)>,
    /// Sharp vertices.
    pub corners: Vec<(u32, f32)>,
}

/// Values that are refined with a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Floats per value.
    pub width: usize,
    /// The values.
    pub values: Vec<f32>,
    /// Which value each corner of each face has; `None` = one value per vertex.
    pub corners: Option<Vec<u32>>,
    /// Whether values are interpolated linearly, not smoothed.
    pub is_linear: bool,
}

/// A surface after refinement.
#[derive(Clone, Debug)]
pub struct Refined {
    /// Its faces: quadrangles, or triangles by the scheme of Loop.
    pub faces: Faces,
    /// The face of the control mesh that each was cut from.
    pub parents: Vec<u32>,
    /// Edges that stay sharp, by their vertices.
    pub creases: Vec<([u32; 2], f32)>,
    /// Its channels, in their order.
    pub channels: Vec<Channel>,
}
