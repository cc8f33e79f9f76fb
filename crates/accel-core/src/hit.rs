// SPDX-License-Identifier: GPL-3.0-or-later
//! The result of a ray: ids and parameters, without appearance. The fields are those that Embree and the flow
//! of ARCHITECTURE.md use.
//! Invariant: a batch's arrays have one length; a lane that missed has `t == inf` and `prim_id == INVALID_ID`.

/// The id of an absent element.
pub const INVALID_ID: u32 = u32::MAX;

/// An intersection of a ray.
///
/// The meaning of `u` and `v` depends on the kind of the primitive:
///
/// | kind | `u` | `v` |
/// |---|---|---|
/// | triangle | weight of the second vertex, in `[0, 1]` | weight of the third; the first one's is `1 - u - v` |
/// | quad | from 0 on the edge of vertices 0 and 3 to 1 on that of 1 and 2 | from 0 on the edge of 0 and 1 to 1 on that of 3 and 2 |
/// | sphere | 0 | 0; the normal is the point minus the centre |
/// | disc | 0 | 0 |
/// | curve | along it, from 0 to 1 | across it: of flat ones from -1 on the left, seen along ray and curve, to 1; of oriented ones from 0 to 1; 0 on round ones |
/// | user geometry | as its test returns | as its test returns |
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Ray parameter, in multiples of the ray's `dir`.
    pub t: f32,
    /// First parameter on the primitive.
    pub u: f32,
    /// Second parameter on the primitive.
    pub v: f32,
    /// Primitive within its geometry, counted from 0.
    pub prim_id: u32,
    /// Geometry within its object, counted from 0.
    pub geom_id: u32,
    /// Instance within the queried scene, counted from 0; 0 for a direct query of an object's tree.
    pub inst_id: u32,
    /// The object's index among all objects of the scene, those of nested scenes too;
    /// [`SceneTree::instance_path`](crate::SceneTree::instance_path) returns the instances on the path to it.
    /// 0 for a direct query of an object's tree.
    pub leaf_id: u32,
}

/// Which primitive a hit is on: two hits are on the same one where these are equal.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PrimitiveId {
    /// As [`Hit::leaf_id`].
    pub leaf_id: u32,
    /// As [`Hit::geom_id`].
    pub geom_id: u32,
    /// As [`Hit::prim_id`].
    pub prim_id: u32,
}

impl Hit {
    /// The primitive that was hit.
    #[must_use]
    #[inline]
    pub fn primitive(&self) -> PrimitiveId {
        PrimitiveId { leaf_id: self.leaf_id, geom_id: self.geom_id, prim_id: self.prim_id }
    }
}

/// The hits of a [`RayBatch`](crate::RayBatch), lane by lane.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HitBatch {
    /// Ray parameters; infinite where a ray missed.
    pub t: Vec<f32>,
    /// First parameters on the primitives.
    pub u: Vec<f32>,
    /// Second parameters.
    pub v: Vec<f32>,
    /// Primitives; [`INVALID_ID`] where a ray missed.
    pub prim_id: Vec<u32>,
    /// Geometries.
    pub geom_id: Vec<u32>,
    /// Instances.
    pub inst_id: Vec<u32>,
    /// Indices among all objects.
    pub leaf_id: Vec<u32>,
}

impl HitBatch {
    /// Makes it `n` lanes long, all of them misses, and keeps the memory.
    pub fn reset(&mut self, n: usize) {
        fn fill<T: Copy>(array: &mut Vec<T>, n: usize, value: T) {
            array.clear();
            array.resize(n, value);
        }
        fill(&mut self.t, n, f32::INFINITY);
        fill(&mut self.u, n, 0.0);
        fill(&mut self.v, n, 0.0);
        fill(&mut self.prim_id, n, INVALID_ID);
        fill(&mut self.geom_id, n, INVALID_ID);
        fill(&mut self.inst_id, n, INVALID_ID);
        fill(&mut self.leaf_id, n, INVALID_ID);
    }

    /// Number of lanes.
    #[must_use]
    #[inline]
    pub fn len(&self) -> usize {
        self.t.len()
    }

    /// Whether there are no lanes.
    #[must_use]
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.t.is_empty()
    }

    /// Lane `i`, or `None` where the ray missed.
    #[must_use]
    #[inline]
    pub fn get(&self, i: usize) -> Option<Hit> {
        (self.prim_id[i] != INVALID_ID).then(|| Hit {
            t: self.t[i],
            u: self.u[i],
            v: self.v[i],
            prim_id: self.prim_id[i],
            geom_id: self.geom_id[i],
            inst_id: self.inst_id[i],
            leaf_id: self.leaf_id[i],
        })
    }

    /// Writes lane `i`.
    #[inline]
    pub fn set(&mut self, i: usize, hit: Hit) {
        self.t[i] = hit.t;
        self.u[i] = hit.u;
        self.v[i] = hit.v;
        self.prim_id[i] = hit.prim_id;
        self.geom_id[i] = hit.geom_id;
        self.inst_id[i] = hit.inst_id;
        self.leaf_id[i] = hit.leaf_id;
    }
}
