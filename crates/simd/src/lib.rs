// SPDX-License-Identifier: GPL-3.0-or-later
//! SIMD lanes, masks and CPU levels: the only crate that names `core::arch` or a SIMD library.
//! Source: a thin door around the library `fearless_simd`; docs/decisions/0001-simd-layer.md says why.
//!
//! From a query to its instructions it is three hops: a caller holds a [`Level`]; [`dispatch!`] turns it into a
//! token type and enters a function that is compiled for that CPU; in there every function that is generic over
//! `S: Simd` is `#[inline(always)]`, or the lane operations become calls and the kernel six times slower.
//!
//! Invariant: kernels use plain `*` and `+`, never `mul_add`, so that every level gives the same bits.
//! Proof: `level::tests`, `lanes::tests`.

mod lanes;
mod level;

pub use fearless_simd::{Simd, f32x4, f32x8, f32x16, mask32x4, mask32x8, mask32x16, prelude, u32x8};
pub use lanes::{lane, load_or, select};
pub use level::{Level, UnknownLevel};

#[doc(hidden)]
pub use fearless_simd::dispatch as __dispatch;

/// Runs an expression with the token of a [`Level`]: `dispatch!(level, simd => kernel(simd, rays))`.
///
/// Enter once per batch. The expression is compiled once per level, so keep it to one call of an
/// `#[inline(always)]` function.
#[macro_export]
macro_rules! dispatch {
    ($level:expr, $simd:pat => $body:expr) => {
        $crate::__dispatch!($crate::Level::token($level), $simd => $body)
    };
}
