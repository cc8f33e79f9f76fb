// SPDX-License-Identifier: GPL-3.0-or-later
//! The builtin functions of GNU RT's shading language.
//!
//! The language is OSL 1.14 with more kinds of shaders; this is its library as plain Rust, with no knowledge of syntax trees,
//! of the program that calls it or of renderers. Values are `f32`, `[f32; 3]`, `[[f32; 4]; 4]`, `&str` and `i32`; derivatives
//! come as [`Dual`].
//!
//! Most functions are generic over [`Number`]: the same text is compiled for a float, for a float with
//! derivatives, and for any other number, with the same bits in all of them. The compiler of shaders has a
//! number that records operations. Functions that have no derivative (`floor`, `step`, hashes) take a
//! [`Real`]. Triples go through such a function component by component, and those that mix components (`math`
//! of vectors) take `[N; 3]`.
//!
//! ```
//! use gnurt_sl_lib::{Dual, math};
//!
//! assert_eq!(math::pow(-2.0_f32, 1.5), 0.0, "no NaN");
//! let x = Dual::new(0.0_f32, 1.0, 0.5);
//! assert_eq!(math::sin(x), Dual::new(0.0, 1.0, 0.5), "sine and its derivatives");
//! ```
//!
//! Where OSL's documentation leaves a choice, its implementation at commit ad63273a decides, approximations included: shaders
//! print the digits that they print there. Differences are stated at each function.

pub mod color;
pub mod dictionary;
mod dual;
pub mod math;
pub mod matrix;
pub mod noise;
mod number;
pub mod points;
pub mod regex;
pub mod spline;
pub mod text;

pub use dual::Dual;
pub use number::{Arithmetic, Mask, Number, Real, UInt, UInts};
