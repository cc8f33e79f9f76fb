// SPDX-License-Identifier: GPL-3.0-or-later
//! Subdivision surfaces: refined evenly ([`refine`]), their limit at single points ([`Cage`]), or cut by levels of edges ([`Tessellation`]).
//! Catmull-Clark, Loop and bilinear rules with creases, corners and boundaries; after the last step points lie on the limit surface.
//! Source: \[CC78\], \[Loo87\], \[DKT98\] (semi-sharp creases); names and rules of boundaries as in USD's mesh schema.
//! Space: that of the control mesh. Cost: O(faces 4^level). Tests: `tests/subdivision.rs`.
//!
//! ```
//! use gnurt_subdivision::{Boundary, Cage, Faces, Place, Scheme, Surface, Tessellation};
//!
//! // A sheet of three by three quadrangles with a tip in the middle.
//! let height = |i: u32| if i == 5 { 9.0 } else { 0.0 };
//! let corners: Vec<i32> = (0..9).map(|i| i / 3 * 4 + i % 3).flat_map(|i| [i, i + 1, i + 5, i + 4]).collect();
//! let faces = Faces::new(&[4; 9], &corners, 16)?;
//! let (creases, corners) = (Vec::new(), Vec::new());
//! let surface = Surface { scheme: Scheme::CatmullClark, boundary: Boundary::EdgeOnly, faces, creases, corners };
//! let cage = Cage::new(surface);
//! let mut fill = |vertex: u32, values: &mut [f64]| values[0] = height(vertex);
//! cage.evaluate(Place { face: 4, part: 0 }, &[[0.0, 0.0]], 1, true, &mut fill, &mut |_, jet| {
//!     assert!((jet[0] - 4.0).abs() < 1e-6 && jet[1].abs() < 1e-6, "four ninths of the tip, and level there");
//! });
//! let cut = Tessellation::new(&cage, |_corner| 4.0, 1_000_000).expect("few cells");
//! assert_eq!((cut.len(), cut.vertices()), (9 * 16, 13 * 13));
//! # Ok::<(), gnurt_subdivision::FacesError>(())
//! ```
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
