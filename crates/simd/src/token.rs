// SPDX-License-Identifier: GPL-3.0-or-later
//! The traits of kernels' type parameters: a token type for each level, with the operations that this project
//! needs.
//! Source: the library's trait, and two functions more. Tests: `level::tests::every_level_runs`.

use fearless_simd::Level as Token;

/// A token that proves that the CPU has a level's instructions. All lane operations come with it.
pub trait Simd: fearless_simd::Simd {
    /// Floats in one register; 1 at the scalar level, whatever its lanes are.
    const LANES: usize;

    /// Whether kernels of sixteen lanes are compiled for it. Not at the scalar level: those of arrays take minutes to compile
    /// and gain nothing.
    const HAS_TILES: bool = Self::LANES > 1;

    /// The token of this level that `token` holds.
    ///
    /// # Panics
    /// If it holds another one: the function belongs to another level's table.
    fn from_token(token: Token) -> Self;
}

/// Of another level than was expected.
#[cold]
fn mismatch(token: Token, requested: &str) -> ! {
    panic!("a kernel for {requested} was given the token of {token:?}")
}

#[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
impl Simd for fearless_simd::Fallback {
    const LANES: usize = 1;

    #[inline(always)]
    fn from_token(token: Token) -> Self {
        match token {
            Token::Fallback(token) => token,
            other => mismatch(other, "no SIMD instructions"),
        }
    }
}

#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
mod x86 {
    use fearless_simd::x86::{Avx2, Avx512, Sse2, Sse4_2};

    use super::{Token, mismatch};

    impl super::Simd for Sse2 {
        const LANES: usize = 1;

        #[inline(always)]
        fn from_token(token: Token) -> Self {
            match token {
                Token::Sse2(token) => token,
                other => mismatch(other, "Sse2"),
            }
        }
    }

    impl super::Simd for Sse4_2 {
        const LANES: usize = 4;

        #[inline(always)]
        fn from_token(token: Token) -> Self {
            match token {
                Token::Sse4_2(token) => token,
                other => mismatch(other, "Sse4_2"),
            }
        }
    }
    impl super::Simd for Avx2 {
        const LANES: usize = 8;

        #[inline(always)]
        fn from_token(token: Token) -> Self {
            match token {
                Token::Avx2(token) => token,
                other => mismatch(other, "Avx2"),
            }
        }
    }
    impl super::Simd for Avx512 {
        const LANES: usize = 16;

        #[inline(always)]
        fn from_token(token: Token) -> Self {
            match token {
                Token::Avx512(token) => token,
                other => mismatch(other, "Avx512"),
            }
        }
    }
}

#[cfg(target_arch = "aarch64")]
impl Simd for fearless_simd::aarch64::Neon {
    const LANES: usize = 4;

    #[inline(always)]
    fn from_token(token: Token) -> Self {
        match token {
            Token::Neon(token) => token,
            other => mismatch(other, "Neon"),
        }
    }
}
