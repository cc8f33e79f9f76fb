// SPDX-License-Identifier: GPL-3.0-or-later
//! Layouts and numbers of Embree 4's C interface, as far as they are needed here.
//! Source: the public headers of Embree 4.4, whose facts are restated.
//! Rays and hits of 1, 4, 8 and 16 lanes are rows of N values, one behind the other: row R of lane I is
//! number `R * N + I`, and [`row`] names the rows. Tests: `tests::layouts_are_those_of_the_headers`, and
//! programs of `tests/c`.

use std::ffi::{c_int, c_uint, c_void};

/// The id of nothing.
pub(crate) const INVALID: u32 = u32::MAX;

/// Rows of rays and hits.
pub(crate) mod row {
    pub(crate) const ORG: usize = 0;
    pub(crate) const T_NEAR: usize = 3;
    pub(crate) const DIR: usize = 4;
    pub(crate) const TIME: usize = 7;
    pub(crate) const T_FAR: usize = 8;
    pub(crate) const MASK: usize = 9;
    pub(crate) const ID: usize = 10;
    pub(crate) const FLAGS: usize = 11;
    pub(crate) const NORMAL: usize = 12;
    pub(crate) const U: usize = 15;
    pub(crate) const V: usize = 16;
    pub(crate) const PRIM_ID: usize = 17;
    pub(crate) const GEOM_ID: usize = 18;
    pub(crate) const INST_ID: usize = 19;
    /// There only in programs that were compiled for arrays of instances.
    pub(crate) const INST_PRIM_ID: usize = 20;
}

/// `RTCHit`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Hit {
    pub(crate) normal: [f32; 3],
    pub(crate) u: f32,
    pub(crate) v: f32,
    pub(crate) prim_id: u32,
    pub(crate) geom_id: u32,
    pub(crate) inst_id: u32,
    pub(crate) inst_prim_id: u32,
}

impl Hit {
    pub(crate) const NONE: Self = Self {
        normal: [0.0; 3],
        u: 0.0,
        v: 0.0,
        prim_id: INVALID,
        geom_id: INVALID,
        inst_id: INVALID,
        inst_prim_id: INVALID,
    };
}

/// `RTCHit` as callbacks get it: as large and as aligned as the header says.
#[repr(C, align(16))]
#[derive(Clone, Copy, Debug)]
pub(crate) struct HitFrame(pub(crate) Hit);

/// `RTCHit4`, `RTCHit8` or `RTCHit16`: nine rows of as many values as the packet has lanes.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug)]
pub(crate) struct HitPacketFrame(pub(crate) [f32; 9 * 16]);

/// `RTCRayHit4`, `RTCRayHit8` or `RTCRayHit16`.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug)]
pub(crate) struct RayHitPacketFrame(pub(crate) [f32; 21 * 16]);

/// Which lanes of a packet are active: those that are not 0.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug)]
pub(crate) struct Valid(pub(crate) [c_int; 16]);

impl Valid {
    /// One lane.
    pub(crate) fn only(lane: usize) -> Self {
        Self(std::array::from_fn(|i| if i == lane { -1 } else { 0 }))
    }
}

/// `RTCRay`.
#[repr(C, align(16))]
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ray {
    pub(crate) org: [f32; 3],
    pub(crate) t_near: f32,
    pub(crate) dir: [f32; 3],
    pub(crate) time: f32,
    pub(crate) t_far: f32,
    pub(crate) mask: u32,
    pub(crate) id: u32,
    pub(crate) flags: u32,
}

/// `RTCRayHit`, with all fields.
#[repr(C, align(16))]
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RayHit {
    pub(crate) ray: Ray,
    pub(crate) hit: Hit,
}

/// `RTCRayQueryContext`, of which only the first number is sure to be there.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub(crate) struct Context {
    pub(crate) inst_id: u32,
    pub(crate) inst_prim_id: u32,
}

/// `RTCIntersectArguments` and `RTCOccludedArguments`, which differ in the callback's type only.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub(crate) struct Arguments {
    pub(crate) flags: c_uint,
    pub(crate) features: c_uint,
    pub(crate) context: *mut Context,
    pub(crate) filter: FilterFunction,
    pub(crate) callback: UserFunction,
}

/// Of [`Arguments::flags`]: the filter of the arguments is for all geometries.
pub(crate) const INVOKE_ARGUMENT_FILTER: c_uint = 1 << 1;

/// Of [`Arguments::flags`]: the rays of a packet are coherent.
pub(crate) const COHERENT: c_uint = 1 << 16;

/// `RTCFilterFunctionNArguments`.
#[repr(C)]
#[derive(Debug)]
pub(crate) struct FilterArguments {
    pub(crate) valid: *mut c_int,
    pub(crate) user_data: *mut c_void,
    pub(crate) context: *mut Context,
    pub(crate) ray: *mut f32,
    pub(crate) hit: *mut f32,
    pub(crate) n: c_uint,
}

/// `RTCIntersectFunctionNArguments` and `RTCOccludedFunctionNArguments`: the former with hits, the latter
/// without.
#[repr(C)]
#[derive(Debug)]
pub(crate) struct UserArguments {
    pub(crate) valid: *mut c_int,
    pub(crate) user_data: *mut c_void,
    pub(crate) prim_id: c_uint,
    pub(crate) context: *mut Context,
    pub(crate) rays: *mut f32,
    pub(crate) n: c_uint,
    pub(crate) geom_id: c_uint,
}

/// `RTCBounds`.
#[repr(C, align(16))]
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bounds {
    pub(crate) lower: [f32; 3],
    pub(crate) align0: f32,
    pub(crate) upper: [f32; 3],
    pub(crate) align1: f32,
}

/// `RTCBoundsFunctionArguments`.
#[repr(C)]
#[derive(Debug)]
pub(crate) struct BoundsArguments {
    pub(crate) user_data: *mut c_void,
    pub(crate) prim_id: c_uint,
    pub(crate) time_step: c_uint,
    pub(crate) bounds: *mut Bounds,
}

/// `RTCPointQuery`.
#[repr(C, align(16))]
#[derive(Clone, Copy, Debug)]
pub(crate) struct PointQuery {
    pub(crate) point: [f32; 3],
    pub(crate) time: f32,
    pub(crate) radius: f32,
}

/// `RTCPointQueryContext` of programs that were compiled for arrays of instances, as they are by default.
#[repr(C, align(16))]
#[derive(Clone, Copy, Debug)]
pub(crate) struct PointContext {
    pub(crate) instance_from_world: [f32; 16],
    pub(crate) world_from_instance: [f32; 16],
    pub(crate) inst_id: u32,
    pub(crate) inst_prim_id: u32,
    pub(crate) depth: u32,
}

/// `RTCPointQueryFunctionArguments`.
#[repr(C, align(16))]
#[derive(Debug)]
pub(crate) struct PointArguments {
    pub(crate) query: *mut PointQuery,
    pub(crate) user: *mut c_void,
    pub(crate) prim_id: c_uint,
    pub(crate) geom_id: c_uint,
    pub(crate) context: *mut PointContext,
    pub(crate) similarity_scale: f32,
}

/// `RTCInterpolateArguments`.
#[repr(C)]
#[derive(Debug)]
pub(crate) struct InterpolateArguments {
    pub(crate) geometry: *mut c_void,
    pub(crate) prim_id: c_uint,
    pub(crate) u: f32,
    pub(crate) v: f32,
    pub(crate) buffer_type: c_uint,
    pub(crate) slot: c_uint,
    pub(crate) values: *mut f32,
    pub(crate) first: [*mut f32; 2],
    pub(crate) second: [*mut f32; 3],
    pub(crate) count: c_uint,
}

/// `RTCInterpolateNArguments`.
#[repr(C)]
#[derive(Debug)]
pub(crate) struct InterpolateManyArguments {
    pub(crate) geometry: *mut c_void,
    pub(crate) valid: *const c_void,
    pub(crate) prim_ids: *const c_uint,
    pub(crate) u: *const f32,
    pub(crate) v: *const f32,
    pub(crate) n: c_uint,
    pub(crate) buffer_type: c_uint,
    pub(crate) slot: c_uint,
    pub(crate) values: *mut f32,
    pub(crate) first: [*mut f32; 2],
    pub(crate) second: [*mut f32; 3],
    pub(crate) count: c_uint,
}

/// `RTCDisplacementFunctionNArguments`.
#[repr(C)]
#[derive(Debug)]
pub(crate) struct DisplacementArguments {
    pub(crate) user_data: *mut c_void,
    pub(crate) geometry: *mut c_void,
    pub(crate) prim_id: c_uint,
    pub(crate) time_step: c_uint,
    pub(crate) u: *const f32,
    pub(crate) v: *const f32,
    pub(crate) normal: [*const f32; 3],
    pub(crate) position: [*mut f32; 3],
    pub(crate) n: c_uint,
}

/// `RTCFilterFunctionN`.
pub(crate) type FilterFunction = Option<unsafe extern "C-unwind" fn(*const FilterArguments)>;
/// `RTCIntersectFunctionN`, `RTCOccludedFunctionN`.
pub(crate) type UserTest = unsafe extern "C-unwind" fn(*const UserArguments);
/// The same, or null.
pub(crate) type UserFunction = Option<UserTest>;
/// `RTCBoundsFunction`.
pub(crate) type BoundsFunction = Option<unsafe extern "C-unwind" fn(*const BoundsArguments)>;
/// `RTCDisplacementFunctionN`.
pub(crate) type DisplacementFunction = Option<unsafe extern "C-unwind" fn(*const DisplacementArguments)>;
/// `RTCPointQueryFunction`.
pub(crate) type PointFunction = Option<unsafe extern "C-unwind" fn(*mut PointArguments) -> bool>;

/// `RTCError`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub(crate) enum Code {
    None = 0,
    Unknown = 1,
    InvalidArgument = 2,
    InvalidOperation = 3,
    OutOfMemory = 4,
    Cancelled = 6,
}

/// The supported values of `RTCGeometryType`.
pub(crate) mod kind {
    pub(crate) const TRIANGLE: u32 = 0;
    pub(crate) const QUAD: u32 = 1;
    pub(crate) const GRID: u32 = 2;
    pub(crate) const SUBDIVISION: u32 = 8;
    pub(crate) const CONE_LINEAR_CURVE: u32 = 15;
    pub(crate) const ROUND_LINEAR_CURVE: u32 = 16;
    pub(crate) const FLAT_LINEAR_CURVE: u32 = 17;
    pub(crate) const ROUND_BEZIER_CURVE: u32 = 24;
    pub(crate) const FLAT_BEZIER_CURVE: u32 = 25;
    pub(crate) const NORMAL_ORIENTED_BEZIER_CURVE: u32 = 26;
    pub(crate) const ROUND_BSPLINE_CURVE: u32 = 32;
    pub(crate) const FLAT_BSPLINE_CURVE: u32 = 33;
    pub(crate) const NORMAL_ORIENTED_BSPLINE_CURVE: u32 = 34;
    pub(crate) const ROUND_HERMITE_CURVE: u32 = 40;
    pub(crate) const FLAT_HERMITE_CURVE: u32 = 41;
    pub(crate) const NORMAL_ORIENTED_HERMITE_CURVE: u32 = 42;
    pub(crate) const SPHERE_POINT: u32 = 50;
    pub(crate) const DISC_POINT: u32 = 51;
    pub(crate) const ORIENTED_DISC_POINT: u32 = 52;
    pub(crate) const ROUND_CATMULL_ROM_CURVE: u32 = 58;
    pub(crate) const FLAT_CATMULL_ROM_CURVE: u32 = 59;
    pub(crate) const NORMAL_ORIENTED_CATMULL_ROM_CURVE: u32 = 60;
    pub(crate) const USER: u32 = 120;
    pub(crate) const INSTANCE: u32 = 121;
    pub(crate) const INSTANCE_ARRAY: u32 = 122;
}

/// The supported values of `RTCBufferType`.
pub(crate) mod buffer {
    pub(crate) const INDEX: u32 = 0;
    pub(crate) const VERTEX: u32 = 1;
    pub(crate) const VERTEX_ATTRIBUTE: u32 = 2;
    pub(crate) const NORMAL: u32 = 3;
    pub(crate) const TANGENT: u32 = 4;
    pub(crate) const NORMAL_DERIVATIVE: u32 = 5;
    pub(crate) const GRID: u32 = 8;
    pub(crate) const FACE: u32 = 16;
    pub(crate) const LEVEL: u32 = 17;
    pub(crate) const EDGE_CREASE_INDEX: u32 = 18;
    pub(crate) const EDGE_CREASE_WEIGHT: u32 = 19;
    pub(crate) const VERTEX_CREASE_INDEX: u32 = 20;
    pub(crate) const VERTEX_CREASE_WEIGHT: u32 = 21;
    pub(crate) const HOLE: u32 = 22;
    pub(crate) const TRANSFORM: u32 = 23;
    pub(crate) const FLAGS: u32 = 32;
}

/// The supported values of `RTCFormat`.
pub(crate) mod format {
    pub(crate) const UCHAR: u32 = 0x1001;
    pub(crate) const UINT: u32 = 0x5001;
    pub(crate) const UINT2: u32 = 0x5002;
    pub(crate) const UINT3: u32 = 0x5003;
    pub(crate) const UINT4: u32 = 0x5004;
    pub(crate) const FLOAT: u32 = 0x9001;
    pub(crate) const FLOAT3: u32 = 0x9003;
    pub(crate) const FLOAT4: u32 = 0x9004;
    pub(crate) const FLOAT16: u32 = 0x9010;
    pub(crate) const FLOAT3X4_ROWS: u32 = 0x9134;
    pub(crate) const FLOAT4X4_ROWS: u32 = 0x9144;
    pub(crate) const FLOAT3X4_COLUMNS: u32 = 0x9234;
    pub(crate) const FLOAT4X4_COLUMNS: u32 = 0x9244;
    pub(crate) const GRID: u32 = 0xA001;
    pub(crate) const QUATERNION: u32 = 0xB001;
}

/// `RTCBuildQuality`.
pub(crate) mod quality {
    pub(crate) const LOW: u32 = 0;
    pub(crate) const HIGH: u32 = 2;
    pub(crate) const REFIT: u32 = 3;
}

/// `RTCSceneFlags`.
pub(crate) mod scene_flag {
    pub(crate) const DYNAMIC: u32 = 1;
    pub(crate) const COMPACT: u32 = 2;
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::mem::{align_of, offset_of, size_of};

    /// As `layouts` of `tests/c/layouts.c` has them.
    #[test]
    fn sizes_and_alignments_are_those_of_the_headers() {
        macro_rules! same {
            ($($ty:ty, $size:literal, $align:literal;)*) => { $(
                assert_eq!((size_of::<$ty>(), align_of::<$ty>()), ($size, $align), stringify!($ty));
            )* };
        }
        same! {
            Ray, 48, 16;
            HitFrame, 48, 16;
            RayHit, 96, 16;
            HitPacketFrame, 576, 64;
            RayHitPacketFrame, 1344, 64;
            Context, 8, 4;
            Arguments, 32, 8;
            FilterArguments, 48, 8;
            UserArguments, 48, 8;
            Bounds, 32, 16;
            BoundsArguments, 24, 8;
            PointQuery, 32, 16;
            PointContext, 144, 16;
            PointArguments, 48, 16;
            InterpolateArguments, 88, 8;
            InterpolateManyArguments, 112, 8;
            DisplacementArguments, 96, 8;
        }
    }

    #[test]
    fn layouts_are_those_of_the_headers() {
        assert_eq!(offset_of!(Ray, t_far), 4 * row::T_FAR, "RTCRay: tfar");
        assert_eq!(offset_of!(Ray, flags), 4 * row::FLAGS, "RTCRay: flags");
        assert_eq!(size_of::<Ray>(), 48, "RTCRay");
        let fields = [
            (offset_of!(gnurt_accel::Ray, org), row::ORG),
            (offset_of!(gnurt_accel::Ray, t_near), row::T_NEAR),
            (offset_of!(gnurt_accel::Ray, dir), row::DIR),
            (offset_of!(gnurt_accel::Ray, time), row::TIME),
            (offset_of!(gnurt_accel::Ray, t_far), row::T_FAR),
            (offset_of!(gnurt_accel::Ray, mask), row::MASK),
        ];
        assert!(fields.iter().all(|&(at, row)| at == 4 * row), "RTCRay begins with our ray: {fields:?}");
        assert_eq!(offset_of!(RayHit, hit), 4 * row::NORMAL, "RTCRayHit: the hit follows the ray");
        assert_eq!(
            offset_of!(Hit, inst_prim_id),
            4 * (row::INST_PRIM_ID - row::NORMAL),
            "RTCHit: instPrimID"
        );
        assert_eq!(size_of::<RayHit>(), 96, "RTCRayHit, padded");
        assert_eq!(offset_of!(Arguments, context), 8, "RTCIntersectArguments: context");
        assert_eq!(offset_of!(FilterArguments, n), 40, "RTCFilterFunctionNArguments: N");
        assert_eq!(offset_of!(UserArguments, context), 24, "RTCIntersectFunctionNArguments: context");
        assert_eq!(offset_of!(UserArguments, geom_id), 44, "RTCIntersectFunctionNArguments: geomID");
        assert_eq!(size_of::<Bounds>(), 32, "RTCBounds");
        assert_eq!(offset_of!(PointContext, inst_id), 128, "RTCPointQueryContext: instID");
        assert_eq!(size_of::<PointContext>(), 144, "RTCPointQueryContext");
        assert_eq!(offset_of!(PointArguments, context), 24, "RTCPointQueryFunctionArguments: context");
        assert_eq!(offset_of!(InterpolateArguments, values), 32, "RTCInterpolateArguments: P");
    }
}
