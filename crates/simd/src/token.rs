// SPDX-License-Identifier: GPL-3.0-or-later
//! What kernels are generic over: a token type for each level, with what this project asks of it.
//! Source: the library's trait, and two answers more. Proof: `level::tests::every_level_runs`.

/// A token that proves that the CPU has a level's instructions. All lane operations come with it.
pub trait Simd: fearless_simd::Simd {
    /// Floats in one register; 1 where lanes are arrays.
    const LANES: usize;

    /// Runs a part of a kernel. Inlined where lanes are registers; a function of its own where they are arrays: there the
    /// compiler's time grows with the square of a kernel's size, and calls cost nothing beside sixteen of everything.
    /// `f` must be `#[inline(always)]`.
    #[inline(always)]
    fn part<R>(self, f: impl FnOnce() -> R) -> R {
        f()
    }
}

impl Simd for fearless_simd::Fallback {
    const LANES: usize = 1;

    #[inline(never)]
    fn part<R>(self, f: impl FnOnce() -> R) -> R {
        f()
    }
}

#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
mod x86 {
    use fearless_simd::x86::{Avx2, Avx512, Sse4_2};

    impl super::Simd for Sse4_2 {
        const LANES: usize = 4;
    }
    impl super::Simd for Avx2 {
        const LANES: usize = 8;
    }
    impl super::Simd for Avx512 {
        const LANES: usize = 16;
    }
}

#[cfg(target_arch = "aarch64")]
impl Simd for fearless_simd::aarch64::Neon {
    const LANES: usize = 4;
}
