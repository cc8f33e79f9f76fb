// SPDX-License-Identifier: GPL-3.0-or-later
//! Subdivision surfaces: refined evenly ([`refine`]), or their limit at single points ([`Cage`]).
//! Catmull-Clark, Loop and bilinear rules with creases, corners and boundaries; after the last step points lie on the limit surface.
//! Source: \[CC78\], \[Loo87\], \[DKT98\] (semi-sharp creases); names and rules of boundaries as in USD's mesh schema.
//! Space: that of the control mesh. Cost: O(faces 4^level). Tests: `tests/subdivision.rs`.
#![forbid(unsafe_code)]

mod cage;
mod catmull_clark;
mod limit;
mod linear;
mod loop_scheme;
mod normals;
mod patch;
mod refine;
mod ring;
mod sharpness;
mod stencils;
mod surface;
mod tessellation;
mod topology;

pub use cage::{Cage, Place, boundary_vertices};
pub use normals::smooth_normals;
pub use refine::{affordable_level, refine};
pub use surface::{Boundary, Channel, LEVEL, MOST_TRIANGLES, Refined, Scheme, Surface};
pub use tessellation::{MOST_LEVEL, Tessellation, TooManyCells};
pub use topology::{Faces, FacesError};
