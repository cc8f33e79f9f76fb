// SPDX-License-Identifier: GPL-3.0-or-later
//! Entering code for sixteen lanes where registers are wide enough for it to pay: AVX2, AVX-512, NEON.
//! Source: original. On narrower levels, and on none, the scalar way with the same bits is taken instead: lanes that are
//! arrays take minutes to compile, and gain nothing.
//! Proof: crates/render/tests/lanes.rs.

/// `dispatch!` of `gnurt_simd` for wide levels; the other ones get what comes after `else`.
macro_rules! dispatch_wide {
    ($level:expr, $simd:pat => $body:expr, else $other:expr) => {
        match gnurt_simd::Level::token($level) {
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            gnurt_simd::__Token::Avx2(token) => gnurt_simd::__enter!(token, $simd => $body),
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            gnurt_simd::__Token::Avx512(token) => gnurt_simd::__enter!(token, $simd => $body),
            #[cfg(target_arch = "aarch64")]
            gnurt_simd::__Token::Neon(token) => gnurt_simd::__enter!(token, $simd => $body),
            _ => $other,
        }
    };
}
