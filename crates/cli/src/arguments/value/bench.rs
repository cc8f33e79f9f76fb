// SPDX-License-Identifier: GPL-3.0-or-later
//! Values of `bench`.
//! See docs/reference/cli.md. Tests: `tests` of `value/mod.rs`.

use gnurt_bench::Class;
use gnurt_bench::ENGINES;

use super::plain::{by_name, whole};

/// The name of a class of rays.
pub(crate) fn ray_class(name: &str) -> Result<Class, String> {
    by_name("class of rays", name, &Class::ALL)
}

/// The name of an engine.
pub(crate) fn engine(name: &str) -> Result<String, String> {
    by_name("engine", name, &ENGINES).map(str::to_owned)
}

/// A case of `bench dynamic`.
pub(crate) fn motion_case(name: &str) -> Result<String, String> {
    by_name("case", name, &MOTION_CASES).map(str::to_owned)
}

const MOTION_CASES: [&str; 7] = ["refit", "rebuild", "top", "stadium", "fuzzy", "crowd", "crowd64"];

/// Instances of the case `top`.
pub(crate) fn instances(text: &str) -> Result<usize, String> {
    whole(text, 1, 10_000_000)
}

/// Characters of a crowd.
pub(crate) fn characters(text: &str) -> Result<usize, String> {
    whole(text, 1, 100_000)
}

/// Columns of primary rays.
pub(crate) fn columns(text: &str) -> Result<u32, String> {
    whole(text, 8, 8192)
}

/// How often something is measured.
pub(crate) fn rounds(text: &str) -> Result<usize, String> {
    whole(text, 1, 1000)
}

/// Rays per batch.
pub(crate) fn batch(text: &str) -> Result<usize, String> {
    whole(text, 1, 1 << 24)
}
