// SPDX-License-Identifier: GPL-3.0-or-later
//! Parameters of what moves: instances and cameras. Source: ANARI 1.1, KHR_INSTANCE_MOTION_*, KHR_CAMERA_MOTION_TRANSFORMATION.
//! Tests: tests/introspection.rs.

use super::entry::{Parameter, list, p};
use crate::types as t;

/// All kinds of motion, by the last word of their parameters.
pub(super) const MOTIONS: [&str; 4] =
    ["motion.transform", "motion.scale", "motion.rotation", "motion.translation"];

/// Parameters of these kinds of motion, and of their time.
pub(super) fn motion(extension: &'static str, kinds: &[&'static str]) -> Vec<Parameter> {
    let entries = |name: &&'static str| {
        let (element, about) = match *name {
            "motion.transform" => {
                (t::FLOAT32_MAT4, "Transforms, evenly spaced in time; they count before the others")
            }
            "motion.scale" => (t::FLOAT32_VEC3, "Scales, evenly spaced in time, applied first"),
            "motion.rotation" => {
                (t::FLOAT32_QUAT_IJKW, "Rotations, evenly spaced in time, applied after scales")
            }
            _ => (t::FLOAT32_VEC3, "Translations, evenly spaced in time, applied last"),
        };
        list(name, &[element], about).by(extension)
    };
    let time = p("time", &[t::FLOAT32_BOX1], "Time of the first and of the last entry").or(&[0.0, 1.0]);
    kinds.iter().map(entries).chain([time.by(extension)]).collect()
}
