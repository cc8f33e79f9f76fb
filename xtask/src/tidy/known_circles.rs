// SPDX-License-Identifier: GPL-3.0-or-later
//! Files that stand in a circle of imports and are still to be taken apart. Source: original.
//! This list only ever gets shorter: nothing is added to it, and `tidy` wants a file off it once it has left its circle.

/// Paths from the root.
#[rustfmt::skip]
pub(super) const KNOWN: &[&str] = &[
    "crates/accel/src/bvh/beam.rs",
    "crates/accel/src/bvh/build/binary.rs",
    "crates/accel/src/bvh/build/cluster.rs",
    "crates/accel/src/bvh/build/collapse.rs",
    "crates/accel/src/bvh/build/crew.rs",
    "crates/accel/src/bvh/build/mod.rs",
    "crates/accel/src/bvh/build/reinsert.rs",
    "crates/accel/src/bvh/build/spatial.rs",
    "crates/accel/src/bvh/build/stages.rs",
    "crates/accel/src/bvh/faces.rs",
    "crates/accel/src/bvh/index.rs",
    "crates/accel/src/bvh/sweep.rs",
    "crates/accel/src/kd/build.rs",
    "crates/accel/src/kd/mod.rs",
    "crates/accel/src/kd/packet.rs",
    "crates/accel/src/kd/sampled.rs",
    "crates/accel/src/kd/slab.rs",
    "crates/accel/src/packet.rs",
    "crates/accel/src/ray.rs",
    "crates/accel/src/scene/error.rs",
    "crates/accel/src/scene/instance.rs",
    "crates/accel/src/scene/mod.rs",
    "crates/accel/src/scene/walk.rs",
    "crates/accel/src/tile.rs",
];
