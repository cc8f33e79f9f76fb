// SPDX-License-Identifier: GPL-3.0-or-later
//! Which instructions the kernels use: chosen at run time, once, and overridable by name.
//! Invariant: a level that this CPU lacks can be named but never runs: its token is the best one below it.
//! Tests: `tests::{names_round_trip, best_is_available, unknown_names_say_what_there_is, every_level_runs}`.

use std::fmt;
use std::str::FromStr;
use std::sync::OnceLock;

/// An instruction set that the kernels are compiled for, weakest first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Level {
    /// Runs everywhere, one ray at a time, and is the reference for the others. Its lanes are those that every CPU of
    /// the architecture has: SSE2 on x86, arrays of floats elsewhere.
    Scalar,
    /// x86-64-v2: SSE4.2, 4 lanes per register.
    Sse42,
    /// x86-64-v3: AVX2, 8 lanes per register.
    Avx2,
    /// AVX-512 of the Ice Lake kind, 16 lanes per register. Older AVX-512 CPUs use AVX2.
    Avx512,
    /// 64-bit ARM's NEON, 4 lanes per register.
    Neon,
}

impl Level {
    /// All levels, also those that this CPU lacks.
    pub const ALL: [Self; 5] = [Self::Scalar, Self::Sse42, Self::Avx2, Self::Avx512, Self::Neon];

    /// The best level of this CPU; found once.
    #[must_use]
    #[inline]
    pub fn best() -> Self {
        static BEST: OnceLock<Level> = OnceLock::new();
        *BEST
            .get_or_init(|| Self::ALL.into_iter().rfind(|level| level.is_available()).unwrap_or(Self::Scalar))
    }

    /// The levels that this CPU has, weakest first; [`Scalar`](Self::Scalar) is always among them.
    #[must_use]
    pub fn available() -> Vec<Self> {
        Self::ALL.into_iter().filter(|level| level.is_available()).collect()
    }

    /// Whether this CPU has it.
    #[must_use]
    pub fn is_available(self) -> bool {
        self.exact_token().is_some()
    }

    /// Its name on command lines and in settings.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Scalar => "scalar",
            Self::Sse42 => "sse4.2",
            Self::Avx2 => "avx2",
            Self::Avx512 => "avx512",
            Self::Neon => "neon",
        }
    }

    /// The token that [`dispatch!`](crate::dispatch) matches on: this level, or the best one below it that
    /// the CPU has.
    #[must_use]
    #[inline]
    pub fn token(self) -> fearless_simd::Level {
        static TOKENS: OnceLock<[fearless_simd::Level; 5]> = OnceLock::new();
        // A single ray reads it, too: after the first time it is a load.
        TOKENS.get_or_init(|| Self::ALL.map(Self::best_token_up_to))[self as usize]
    }

    /// The token that [`dispatch_two!`](crate::dispatch_two) matches on: AVX2 or NEON, or the
    /// scalar level.
    #[must_use]
    #[inline]
    pub fn token_of_two(self) -> fearless_simd::Level {
        match self.token() {
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            fearless_simd::Level::Avx2(_) | fearless_simd::Level::Avx512(_) => Self::Avx2.token(),
            #[cfg(target_arch = "aarch64")]
            token @ fearless_simd::Level::Neon(_) => token,
            _ => Self::Scalar.token(),
        }
    }

    fn best_token_up_to(self) -> fearless_simd::Level {
        let not_above = Self::ALL.into_iter().filter(|&level| level <= self).rev();
        not_above.filter_map(Self::exact_token).next().expect("every CPU runs the scalar level")
    }

    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    fn exact_token(self) -> Option<fearless_simd::Level> {
        use fearless_simd::{Level as Token, Simd};
        let cpu = Token::new();
        match self {
            Self::Scalar => cpu.as_sse2().map(Simd::level),
            Self::Sse42 => cpu.as_sse4_2().map(Simd::level),
            Self::Avx2 => cpu.as_avx2().map(Simd::level),
            Self::Avx512 => cpu.as_avx512().map(Simd::level),
            Self::Neon => None,
        }
    }

    #[cfg(target_arch = "aarch64")]
    fn exact_token(self) -> Option<fearless_simd::Level> {
        use fearless_simd::{Fallback, Level as Token, Simd};
        match self {
            Self::Scalar => Some(Token::Fallback(Fallback::new())),
            Self::Neon => Token::new().as_neon().map(Simd::level),
            Self::Sse42 | Self::Avx2 | Self::Avx512 => None,
        }
    }

    #[cfg(not(any(target_arch = "x86", target_arch = "x86_64", target_arch = "aarch64")))]
    fn exact_token(self) -> Option<fearless_simd::Level> {
        (self == Self::Scalar).then(|| fearless_simd::Level::Fallback(fearless_simd::Fallback::new()))
    }
}

impl Default for Level {
    /// The best of this CPU.
    #[inline]
    fn default() -> Self {
        Self::best()
    }
}

impl fmt::Display for Level {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Level {
    type Err = UnknownLevel;

    /// One of `scalar|sse4.2|avx2|avx512|neon`, or `auto` for the best. A level that the CPU lacks is an error.
    fn from_str(name: &str) -> Result<Self, UnknownLevel> {
        if name == "auto" {
            return Ok(Self::best());
        }
        match Self::ALL.into_iter().find(|level| level.name() == name) {
            Some(level) if level.is_available() => Ok(level),
            known => Err(UnknownLevel { name: name.to_owned(), is_a_level: known.is_some() }),
        }
    }
}

/// A name that is no level, or the name of one that this CPU lacks: the user's mistake. Lists the valid
/// names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnknownLevel {
    name: String,
    is_a_level: bool,
}

impl fmt::Display for UnknownLevel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let list = |levels: &[Level]| levels.iter().map(|l| l.name()).collect::<Vec<_>>().join(", ");
        let here = list(&Level::available());
        if self.is_a_level {
            write!(f, "this CPU has no {}; it has: auto, {here}", self.name)
        } else {
            let all = list(&Level::ALL);
            write!(f, "unknown instruction set '{}'; valid: auto, {all}; this CPU has: {here}", self.name)
        }
    }
}

impl std::error::Error for UnknownLevel {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_round_trip() {
        for level in Level::available() {
            assert_eq!(level.to_string().parse(), Ok(level), "{level} is read back");
        }
        assert_eq!("auto".parse(), Ok(Level::best()), "auto is the best");
    }

    #[test]
    fn best_is_available() {
        assert!(Level::best().is_available(), "the best can run");
        assert_eq!(Level::available()[0], Level::Scalar, "scalar runs everywhere");
    }

    #[test]
    fn unknown_names_say_what_there_is() {
        let message = "sse9".parse::<Level>().expect_err("no such level").to_string();
        for name in ["sse9", "auto", "scalar", "sse4.2", "avx2", "avx512", "neon"] {
            assert!(message.contains(name), "'{message}' names {name}");
        }
        for level in Level::ALL.into_iter().filter(|level| !level.is_available()) {
            let message = level.name().parse::<Level>().expect_err("not on this CPU").to_string();
            assert!(message.contains(level.name()) && message.contains("scalar"), "'{message}' helps");
        }
    }

    #[test]
    fn every_level_runs() {
        use fearless_simd::Simd;
        for level in Level::available() {
            let ran = crate::dispatch!(level, simd => simd.level());
            let (ran, requested) = (std::mem::discriminant(&ran), std::mem::discriminant(&level.token()));
            assert_eq!(ran, requested, "{level} runs as itself");
        }
    }

    #[test]
    fn tables_and_pairs_go_by_level() {
        use crate::Simd;
        for level in Level::available() {
            let lanes = crate::by_level!(level.token(), S => S::LANES);
            let ran = crate::dispatch!(level, simd => lanes_of(simd));
            assert_eq!(lanes, ran, "{level} has a table of its own");
            let of_two = crate::dispatch_two!(level, simd => lanes_of(simd));
            let requested = if level > Level::Sse42 { lanes.min(8) } else { 1 };
            assert_eq!(of_two, requested, "{level} runs as the wide one of two, or without");
        }
        fn lanes_of<S: Simd>(_: S) -> usize {
            S::LANES
        }
    }

    #[test]
    #[should_panic(expected = "a kernel for")]
    fn another_level_s_token_is_refused() {
        use crate::Simd;
        let best = Level::best();
        if best == Level::Scalar {
            panic!("a kernel for nothing else");
        }
        crate::by_level!(Level::Scalar.token(), S => {
            let _ = S::from_token(best.token());
        });
    }
}
