// SPDX-License-Identifier: GPL-3.0-or-later
//! SIMD lanes, masks and CPU levels: the only crate that names `core::arch` or a SIMD library.
//! Source: a thin layer around the library `fearless_simd`; reasons in docs/decisions/0001-simd-layer.md.
//!
//! Three steps lead from a query to its instructions. A caller holds a [`Level`]. [`dispatch!`] turns it into
//! a token type and enters a function that is compiled for that CPU. Every function in there that is generic
//! over `S: Simd` is `#[inline(always)]`; otherwise the lane operations become calls and the kernel six times
//! slower. Kernels that are chosen at run time are kept in tables of functions, one for each level:
//! [`by_level!`] picks the table.
//!
//! Invariant: kernels whose numbers are results use plain `*` and `+`, never `mul_add`, so that every level
//! gives the same bits. Conservative tests (boxes that a ray may hit) are free to fuse.
//! Tests: `level::tests`, `stack::tests`.

mod level;
mod memory;
mod stack;
mod token;

pub use fearless_simd::{
    SimdFloat, f32x4, f32x8, f32x16, f64x8, i32x4, i32x16, mask32x4, mask32x8, mask32x16, prelude, u32x8,
    u32x16,
};
pub use level::{Level, UnknownLevel};
pub use memory::{prefer_huge_pages, prefetch};
pub use stack::{Stack, StackBuffer};
pub use token::Simd;

/// Proof that the CPU has the instructions of some level: the result of [`Level::token`].
pub use fearless_simd::Level as Token;

#[doc(hidden)]
#[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
pub use fearless_simd::Fallback as __Fallback;
#[doc(hidden)]
pub use fearless_simd::Simd as __Base;
#[doc(hidden)]
#[cfg(target_arch = "aarch64")]
pub use fearless_simd::aarch64 as __arm;
#[doc(hidden)]
#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
pub use fearless_simd::x86 as __x86;

/// Runs an expression with the token of a [`Level`]: `dispatch!(level, simd => kernel(simd, rays))`.
///
/// Enter once per batch. The expression is compiled once per level, so keep it to one call of an
/// `#[inline(always)]` function. Unlike the library's own macro it leaves out tokens that no [`Level`] has: on
/// x86 that is the one of arrays.
#[macro_export]
macro_rules! dispatch {
    ($level:expr, $simd:pat => $body:expr) => {
        $crate::dispatch_wide!($level, $simd => $body, else match $crate::Level::token($level) {
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            $crate::Token::Sse4_2(token) => $crate::__enter!(token, $simd => $body),
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            $crate::Token::Sse2(token) => $crate::__enter!(token, $simd => $body),
            #[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
            $crate::Token::Fallback(token) => $crate::__enter!(token, $simd => $body),
            other => unreachable!("no level has the token {other:?}"),
        })
    };
}

/// As [`dispatch!`], but only for levels whose registers are wide enough for sixteen lanes to pay (AVX2,
/// AVX-512, NEON). On others, and on none, the expression behind `else` is taken: lanes that are arrays take
/// minutes to compile, and gain nothing. `dispatch_wide!(level, simd => kernel(simd, paths), else
/// one_by_one(paths))`.
#[macro_export]
macro_rules! dispatch_wide {
    ($level:expr, $simd:pat => $body:expr, else $other:expr) => {
        match $crate::Level::token($level) {
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            $crate::Token::Avx2(token) => $crate::__enter!(token, $simd => $body),
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            $crate::Token::Avx512(token) => $crate::__enter!(token, $simd => $body),
            #[cfg(target_arch = "aarch64")]
            $crate::Token::Neon(token) => $crate::__enter!(token, $simd => $body),
            _ => $other,
        }
    };
}

/// As [`dispatch!`], but compiled twice instead of four times: with AVX2 or NEON where the CPU has them, and
/// at the scalar level. For code other than kernels of rays: builders.
#[macro_export]
macro_rules! dispatch_two {
    ($level:expr, $simd:pat => $body:expr) => {
        match $crate::Level::token_of_two($level) {
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            $crate::Token::Avx2(token) => $crate::__enter!(token, $simd => $body),
            #[cfg(target_arch = "aarch64")]
            $crate::Token::Neon(token) => $crate::__enter!(token, $simd => $body),
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            $crate::Token::Sse2(token) => $crate::__enter!(token, $simd => $body),
            #[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
            $crate::Token::Fallback(token) => $crate::__enter!(token, $simd => $body),
            other => unreachable!("no level of two has the token {other:?}"),
        }
    };
}

/// The value for the level of a [`Token`], by the type `S` of its own token: `by_level!(token, S =>
/// &For::<S>::TABLE)`. So tables of functions are chosen, one for each level, once for a call or a batch.
#[macro_export]
macro_rules! by_level {
    ($token:expr, $S:ident => $value:expr) => {
        match $token {
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            $crate::Token::Sse4_2(_) => {
                type $S = $crate::__x86::Sse4_2;
                $value
            }
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            $crate::Token::Avx2(_) => {
                type $S = $crate::__x86::Avx2;
                $value
            }
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            $crate::Token::Avx512(_) => {
                type $S = $crate::__x86::Avx512;
                $value
            }
            #[cfg(target_arch = "aarch64")]
            $crate::Token::Neon(_) => {
                type $S = $crate::__arm::Neon;
                $value
            }
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            $crate::Token::Sse2(_) => {
                type $S = $crate::__x86::Sse2;
                $value
            }
            #[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
            $crate::Token::Fallback(_) => {
                type $S = $crate::__Fallback;
                $value
            }
            other => unreachable!("no level has the token {other:?}"),
        }
    };
}

/// As [`by_level!`], by the levels of [`dispatch_two!`]: for kernels that are not the fastest paths of rays through
/// triangles. `token` is the result of [`Level::token_of_two`].
#[macro_export]
macro_rules! by_level_of_two {
    ($token:expr, $S:ident => $value:expr) => {
        match $token {
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            $crate::Token::Avx2(_) => {
                type $S = $crate::__x86::Avx2;
                $value
            }
            #[cfg(target_arch = "aarch64")]
            $crate::Token::Neon(_) => {
                type $S = $crate::__arm::Neon;
                $value
            }
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            $crate::Token::Sse2(_) => {
                type $S = $crate::__x86::Sse2;
                $value
            }
            #[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
            $crate::Token::Fallback(_) => {
                type $S = $crate::__Fallback;
                $value
            }
            other => unreachable!("no level of two has the token {other:?}"),
        }
    };
}

/// A function of a table for the level `S`, called with that level's [`Token`] first: `kernel!(S, |simd, index, ray|
/// index.search(simd, ray))`.
#[macro_export]
macro_rules! kernel {
    ($S:ident, |$simd:ident $(, $argument:ident)*| $body:expr) => {
        |token, $($argument),*| {
            let $simd = <$S as $crate::Simd>::from_token(token);
            $crate::__Base::vectorize(
                $simd,
                #[inline(always)]
                || $body,
            )
        }
    };
}

/// As [`kernel!`], where the level has kernels for tiles; `None` elsewhere.
#[macro_export]
macro_rules! tile_kernel {
    ($S:ident, |$($argument:ident),*| $body:expr) => {
        if <$S as $crate::Simd>::HAS_TILES { Some($crate::kernel!($S, |$($argument),*| $body)) } else { None }
    };
}

/// The body, compiled with the instructions of `token`.
#[doc(hidden)]
#[macro_export]
macro_rules! __enter {
    ($token:expr, $simd:pat => $body:expr) => {{
        let token = $token;
        let $simd = token;
        $crate::__Base::vectorize(
            token,
            #[inline(always)]
            || $body,
        )
    }};
}
