// SPDX-License-Identifier: GPL-3.0-or-later
//! The target of rays: an object or a scene. All code from here to the kernels is compiled once.

use gnurt_accel_core::bits::each;
use gnurt_accel_core::nearest::Nearest;
use gnurt_accel_core::point::{NearestPoint, Probe};
use gnurt_accel_core::tile::NearestTile;
use gnurt_accel_core::traversal::{RayTraversal, TileTraversal};

use crate::engine::Engine;
use crate::{Hit, HitBatch, ObjectTree, SceneTree};

/// An object or a scene.
#[derive(Clone, Copy)]
pub(crate) enum Target<'a> {
    Object(&'a ObjectTree),
    Scene(&'a SceneTree),
}

impl ObjectTree {
    pub(crate) fn target(&self) -> Target<'_> {
        Target::Object(self)
    }
}

impl SceneTree {
    pub(crate) fn target(&self) -> Target<'_> {
        Target::Scene(self)
    }
}

impl Target<'_> {
    /// Traces a ray, which is valid.
    #[inline(always)]
    pub(crate) fn ray(self, engine: &Engine, traversal: &mut RayTraversal) {
        match self {
            Self::Object(object) => object.ray(engine, traversal),
            Self::Scene(scene) => scene.ray(engine, traversal),
        }
    }

    /// Sends a tile's active rays. Where they are `incoherent`, they need not have anything in common.
    pub(crate) fn tile(self, engine: &Engine, traversal: &mut TileTraversal, incoherent: bool) {
        match self {
            Self::Object(object) => object.tile(engine, traversal, incoherent),
            Self::Scene(scene) => scene.tile(engine, traversal, incoherent),
        }
    }

    /// Improves the nearest point.
    pub(crate) fn point(self, engine: &Engine, probe: &Probe, nearest: &mut dyn NearestPoint) {
        match self {
            Self::Object(object) => object.nearest(engine, probe, 0, nearest),
            Self::Scene(scene) => scene.nearest(engine, probe, 0, nearest),
        }
    }

    /// Ids of a hit.
    #[inline]
    pub(crate) fn hit(self, nearest: &Nearest) -> Hit {
        match self {
            Self::Object(object) => object.resolve(nearest, 0, 0),
            Self::Scene(scene) => scene.resolve(nearest),
        }
    }

    /// Writes the hits of those rays of a tile that are in `bits`, the tile's first ray to lane `first`.
    pub(crate) fn write(self, nearest: &NearestTile, bits: u64, first: usize, hits: &mut HitBatch) {
        match self {
            Self::Object(object) => {
                each(bits, |i| hits.set(first + i, object.resolve(&nearest.get(i), 0, 0)));
            }
            Self::Scene(scene) => scene.write(nearest, bits, first, hits),
        }
    }

    /// The only object that rays meet, its instance and its number.
    pub(crate) fn only_object(&self) -> Option<([u32; 2], &ObjectTree)> {
        match self {
            Self::Object(object) => Some(([0; 2], object)),
            Self::Scene(scene) => scene.only_object(),
        }
    }
}
