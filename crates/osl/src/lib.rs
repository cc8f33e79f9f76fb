// SPDX-License-Identifier: GPL-3.0-or-later
//! Open Shading Language for renderers in Rust, without LLVM and C++.
//!
//! A renderer compiles shaders ([`ShadingSystem`]), joins them in groups ([`GroupBuilder`]), and runs a group for the points that
//! its rays hit ([`ShaderGroup::run`]). It gets back the closures of each point as a flat list ([`Lobe`]), outputs, and
//! messages. Queries of a shader, such as textures and transforms, go to a [`Host`], all of whose methods have defaults.
//!
//! ```
//! use gnurt_osl::{Empty, Point, ShadingSystem};
//!
//! # fn main() -> Result<(), gnurt_osl::Error> {
//! let system = ShadingSystem::new();
//! let stripes = system.compile("stripes.osl", "shader stripes (float number = 4, output color Cout = 0) {
//!     Cout = mod (floor (u * number), 2);
//! }")?;
//! let matte = system.compile("matte.osl", "surface matte (color Cs = 0.5, float Kd = 1) { Ci = Kd * Cs * diffuse (N); }")?;
//! let group = system
//!     .group("striped")
//!     .param("number", 10.0)
//!     .shader(&stripes, "pattern")
//!     .live_param("Kd", 0.8)
//!     .shader(&matte, "surface")
//!     .connect("pattern", "Cout", "surface", "Cs")
//!     .output("pattern.Cout")
//!     .build()?;
//! assert!(group.needs().globals.contains("u"), "and N, Ci; nothing else has to be filled in");
//!
//! let points: Vec<Point> =
//!     [0.05, 0.15].map(|u: f32| Point { u: u.into(), n: [0.0, 0.0, 1.0], ..Point::default() }).into();
//! let shaded = group.run(&Empty, &points);
//! assert_eq!(shaded.output("pattern.Cout").unwrap().values, [0.0, 0.0, 0.0, 1.0, 1.0, 1.0]);
//! assert!(shaded.lobes(0).is_empty(), "a black stripe: closures without weight are left out");
//! let [lobe] = shaded.lobes(1) else { panic!("one closure") };
//! assert_eq!((&*lobe.name, lobe.weight, lobe.triple(0)), ("diffuse", [0.8; 3], [0.0, 0.0, 1.0]));
//!
//! group.set("surface", "Kd", 0.25)?; // without compiling
//! assert_eq!(group.run(&Empty, &points).lobes(1)[0].weight, [0.25; 3]);
//! # Ok(())
//! # }
//! ```
//!
//! A path tracer of spheres with such shaders: `examples/tiny_path_tracer.rs`. The reference is complete without it:
//!
//! * [`closures`]: parameters and units of all closures, the meaning of weights, closures of one's own.
//! * [`Point`]: orientation and defaults of its fields.
//! * [`GroupBuilder`]: the order of layers.
//! * [`Host`]: matrices, spaces, and how a query finds its object.
//! * [`ShaderGroup::run`]: how many points to run at once.
//! * [`Needs`]: the fields that a group reads.
//!
//! Of a [`Dual`] a renderer uses `Dual::new (value, dx, dy)`, `value.into ()` where there are no derivatives, and the field
//! `value`; its other methods are the library's. For the derivatives of a hit intersect the rays of the next pixels in
//! x and y with the plane through the hit: `dx` of `p` is the way from the hit to the first intersection. Of `u` and
//! `v` it is that way, taken apart along `dpdu` and `dpdv`.
//!
//! Space: positions and directions of a [`Point`] are in the renderer's space, which shaders call `common`.
//! Invariant: values are the interpreter's, bit for bit, on all processors, but for NaNs. Tests: `tests/stranger.rs`.
#![forbid(unsafe_code)]

mod builder;
pub mod closures;
mod engine;
mod error;
mod faults;
mod group;
mod live;
mod needs;
mod shaded;
mod shader;
mod system;
mod world;

pub use builder::GroupBuilder;
pub use error::Error;
pub use gnurt_sl::exec::{
    Arriving, ClosureDecl, ClosureParam, Event, Given, Host, Point, Subimage, TextureOptions, TraceOptions,
    standard_closures,
};
pub use gnurt_sl::group::Value;
pub use gnurt_sl::hir::Data;
pub use gnurt_sl::types::{Base, Type};
pub use gnurt_sl_lib::Dual;
pub use gnurt_sl_lib::color::ColorSystem;
pub use group::{ShaderGroup, Statistics};
pub use needs::Needs;
pub use shaded::{Argument, Lobe, Output, Shaded};
pub use shader::{Parameter, Shader};
pub use system::ShadingSystem;

/// A host without textures, attributes, named spaces and rays.
#[derive(Clone, Copy, Debug, Default)]
pub struct Empty;

impl Host for Empty {}

/// The examples of the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
