// SPDX-License-Identifier: GPL-3.0-or-later
//! Embree 4 through its C interface, loaded at run time: the declarations that are needed, and safe functions on them.
//! Source: the public headers of Embree 4.4 (rtcore_device.h, rtcore_scene.h, rtcore_ray.h), from which names, numbers and
//! layouts are restated. Scenes of instances are in `ffi_instances.rs`.
//!
//! Invariants: a [`Library`] outlives its devices, a [`Device`] its scenes, arrays the scene that shares
//! them; layouts are used only after the library has reported version 4. Many threads may query a committed
//! scene.
//! Tests: `embree::tests` (where `EMBREE4_LIB` names a library).

use std::ffi::{CStr, CString, c_char, c_int, c_uint, c_void};
use std::marker::PhantomData;
use std::path::Path;
use std::ptr::null_mut;
use std::sync::atomic::{AtomicI64, Ordering};

use gnurt::accel::Ray;

pub(crate) type Handle = *mut c_void;

/// `RTCRayHit` (N = 1), `RTCRayHit4`, `RTCRayHit8`, `RTCRayHit16`: rows of N values, the ray first.
///
/// The last row exists where the library was built with arrays of instances; one without leaves it unchanged.
#[repr(C, align(64))]
pub(crate) struct Packet<const N: usize> {
    pub(crate) org: [[f32; N]; 3],
    pub(crate) t_near: [f32; N],
    pub(crate) dir: [[f32; N]; 3],
    pub(crate) time: [f32; N],
    pub(crate) t_far: [f32; N],
    pub(crate) mask: [u32; N],
    pub(crate) id: [u32; N],
    pub(crate) flags: [u32; N],
    pub(crate) normal: [[f32; N]; 3],
    pub(crate) u: [f32; N],
    pub(crate) v: [f32; N],
    pub(crate) prim_id: [u32; N],
    pub(crate) geom_id: [u32; N],
    pub(crate) inst_id: [u32; N],
    pub(crate) inst_prim_id: [u32; N],
}

impl<const N: usize> Packet<N> {
    /// Rays without length, seen by every mask.
    pub(crate) fn new() -> Self {
        Self {
            org: [[0.0; N]; 3],
            t_near: [0.0; N],
            dir: [[0.0; N]; 3],
            time: [0.0; N],
            t_far: [0.0; N],
            mask: [u32::MAX; N],
            id: [0; N],
            flags: [0; N],
            normal: [[0.0; N]; 3],
            u: [0.0; N],
            v: [0.0; N],
            prim_id: [u32::MAX; N],
            geom_id: [u32::MAX; N],
            inst_id: [u32::MAX; N],
            inst_prim_id: [u32::MAX; N],
        }
    }
}

/// `RTCRayHit`, without gaps in lists of them.
#[derive(Debug)]
#[repr(C, align(16))]
pub(crate) struct OneRay(One);

/// Its fields: those of a packet of one.
#[derive(Debug)]
#[repr(C)]
struct One {
    org: [f32; 3],
    t_near: f32,
    dir: [f32; 3],
    time: f32,
    t_far: f32,
    mask: u32,
    id_and_flags: [u32; 2],
    normal: [f32; 3],
    uv: [f32; 2],
    prim_id: u32,
    geom_id: u32,
    inst_id: u32,
    inst_prim_id: u32,
}

impl OneRay {
    pub(crate) fn new(ray: &Ray) -> Self {
        let none = u32::MAX;
        Self(One {
            org: ray.org,
            t_near: ray.t_near,
            dir: ray.dir,
            time: ray.time,
            t_far: ray.t_far,
            mask: ray.mask,
            id_and_flags: [0; 2],
            normal: [0.0; 3],
            uv: [0.0; 2],
            prim_id: none,
            geom_id: none,
            inst_id: none,
            inst_prim_id: none,
        })
    }

    /// Distance and primitive of the closest hit.
    pub(crate) fn hit(&self) -> Option<(f32, u32)> {
        (self.0.geom_id != u32::MAX).then_some((self.0.t_far, self.0.prim_id))
    }

    /// Whether any was found.
    pub(crate) fn is_occluded(&self) -> bool {
        self.0.t_far == f32::NEG_INFINITY
    }
}

/// Which rays of a packet are to be traced: -1, others 0.
#[repr(C, align(64))]
pub(crate) struct Active<const N: usize>(pub(crate) [i32; N]);

/// `RTCIntersectArguments` and `RTCOccludedArguments`, with space for fields that some builds add at the end.
#[repr(C)]
#[derive(Clone, Copy)]
pub(crate) struct Arguments {
    flags: c_uint,
    features: c_uint,
    context: Handle,
    filter: Handle,
    callback: Handle,
    spare: [u64; 2],
}

impl Arguments {
    pub(crate) fn new(coherent: bool) -> Self {
        let flags = if coherent { COHERENT } else { 0 };
        Self {
            flags,
            features: c_uint::MAX,
            context: null_mut(),
            filter: null_mut(),
            callback: null_mut(),
            spare: [0; 2],
        }
    }
}

const COHERENT: c_uint = 1 << 16;
/// RTC_BUILD_QUALITY_LOW.
const LOW: c_int = 0;
pub(crate) const GEOMETRY_TRIANGLE: c_int = 0;
pub(crate) const BUFFER_INDEX: c_int = 0;
pub(crate) const BUFFER_VERTEX: c_int = 1;
pub(crate) const FORMAT_UINT3: c_int = 0x5003;
pub(crate) const FORMAT_FLOAT3: c_int = 0x9003;
const PROPERTY_VERSION: c_int = 0;
const PROPERTY_NATIVE_RAY4: c_int = 32;
const PROPERTY_NATIVE_RAY8: c_int = 33;
const PROPERTY_NATIVE_RAY16: c_int = 34;

type Intersect1 = unsafe extern "C" fn(Handle, *mut c_void, *const Arguments);
type IntersectN = unsafe extern "C" fn(*const c_int, Handle, *mut c_void, *const Arguments);
type Monitor = unsafe extern "C" fn(*mut c_void, isize, bool) -> bool;

/// The functions of the library. It stays loaded until the program ends.
pub(crate) struct Library {
    new_device: unsafe extern "C" fn(*const c_char) -> Handle,
    release_device: unsafe extern "C" fn(Handle),
    device_error: unsafe extern "C" fn(Handle) -> c_int,
    device_property: unsafe extern "C" fn(Handle, c_int) -> isize,
    set_monitor: unsafe extern "C" fn(Handle, Option<Monitor>, *mut c_void),
    pub(crate) new_scene: unsafe extern "C" fn(Handle) -> Handle,
    release_scene: unsafe extern "C" fn(Handle),
    pub(crate) set_quality: unsafe extern "C" fn(Handle, c_int),
    pub(crate) set_flags: unsafe extern "C" fn(Handle, c_int),
    pub(crate) commit_scene: unsafe extern "C" fn(Handle),
    pub(crate) new_geometry: unsafe extern "C" fn(Handle, c_int) -> Handle,
    pub(crate) release_geometry: unsafe extern "C" fn(Handle),
    pub(crate) set_time_steps: unsafe extern "C" fn(Handle, c_uint),
    pub(crate) share_buffer:
        unsafe extern "C" fn(Handle, c_int, c_uint, c_int, *const c_void, usize, usize, usize),
    set_geometry_quality: unsafe extern "C" fn(Handle, c_int),
    update_buffer: unsafe extern "C" fn(Handle, c_int, c_uint),
    pub(crate) set_instanced: unsafe extern "C" fn(Handle, Handle),
    pub(crate) set_transform: unsafe extern "C" fn(Handle, c_uint, c_int, *const c_void),
    pub(crate) set_turned: unsafe extern "C" fn(Handle, c_uint, *const c_void),
    pub(crate) commit_geometry: unsafe extern "C" fn(Handle),
    pub(crate) attach: unsafe extern "C" fn(Handle, Handle) -> c_uint,
    intersect1: Intersect1,
    intersect4: IntersectN,
    intersect8: IntersectN,
    intersect16: IntersectN,
    occluded1: Intersect1,
    occluded4: IntersectN,
    occluded8: IntersectN,
    occluded16: IntersectN,
}

impl Library {
    /// Loads the file, which must have all functions that are called here.
    #[cfg(any(unix, windows))]
    pub(crate) fn open(file: &Path) -> Result<Self, String> {
        // SAFETY: loading runs the library's own start code, as the caller requested.
        let library = unsafe { libloading::Library::new(file) };
        let library = library.map_err(|error| error.to_string().replace('\n', " "))?;
        let library = std::mem::ManuallyDrop::new(library);
        let missing = |name: &CStr| format!("this is not Embree 4: it lacks {}", name.to_string_lossy());
        macro_rules! function {
            ($name:literal) => {
                // SAFETY: the symbol has the type of the field that it goes to according to Embree's headers.
                // `Device::open` then checks that this is Embree; a library with all these names is trusted
                // that far.
                *unsafe { library.get($name.to_bytes_with_nul()) }.map_err(|_| missing($name))?
            };
        }
        Ok(Self {
            new_device: function!(c"rtcNewDevice"),
            release_device: function!(c"rtcReleaseDevice"),
            device_error: function!(c"rtcGetDeviceError"),
            device_property: function!(c"rtcGetDeviceProperty"),
            set_monitor: function!(c"rtcSetDeviceMemoryMonitorFunction"),
            new_scene: function!(c"rtcNewScene"),
            release_scene: function!(c"rtcReleaseScene"),
            set_quality: function!(c"rtcSetSceneBuildQuality"),
            set_flags: function!(c"rtcSetSceneFlags"),
            commit_scene: function!(c"rtcCommitScene"),
            new_geometry: function!(c"rtcNewGeometry"),
            release_geometry: function!(c"rtcReleaseGeometry"),
            set_time_steps: function!(c"rtcSetGeometryTimeStepCount"),
            share_buffer: function!(c"rtcSetSharedGeometryBuffer"),
            set_instanced: function!(c"rtcSetGeometryInstancedScene"),
            set_transform: function!(c"rtcSetGeometryTransform"),
            set_turned: function!(c"rtcSetGeometryTransformQuaternion"),
            set_geometry_quality: function!(c"rtcSetGeometryBuildQuality"),
            update_buffer: function!(c"rtcUpdateGeometryBuffer"),
            commit_geometry: function!(c"rtcCommitGeometry"),
            attach: function!(c"rtcAttachGeometry"),
            intersect1: function!(c"rtcIntersect1"),
            intersect4: function!(c"rtcIntersect4"),
            intersect8: function!(c"rtcIntersect8"),
            intersect16: function!(c"rtcIntersect16"),
            occluded1: function!(c"rtcOccluded1"),
            occluded4: function!(c"rtcOccluded4"),
            occluded8: function!(c"rtcOccluded8"),
            occluded16: function!(c"rtcOccluded16"),
        })
    }

    /// Loads the file.
    #[cfg(not(any(unix, windows)))]
    pub(crate) fn open(_: &Path) -> Result<Self, String> {
        Err("this system has no shared libraries".into())
    }
}

/// Bytes that the library holds, and the most that it held.
#[derive(Default)]
struct Memory {
    now: AtomicI64,
    peak: AtomicI64,
}

/// Embree's side: called from its threads for every block that it takes or gives back.
unsafe extern "C" fn count_memory(memory: *mut c_void, bytes: isize, _after: bool) -> bool {
    // SAFETY: the pointer is that of the device's own `Memory`, which lives until the device is released.
    let memory = unsafe { &*memory.cast::<Memory>() };
    let now = memory.now.fetch_add(bytes as i64, Ordering::Relaxed) + bytes as i64;
    memory.peak.fetch_max(now, Ordering::Relaxed);
    true
}

/// An Embree device.
pub(crate) struct Device<'a> {
    pub(crate) library: &'a Library,
    pub(crate) raw: Handle,
    memory: Box<Memory>,
}

// SAFETY: Embree's functions on devices may be called from any thread.
unsafe impl Send for Device<'_> {}
// SAFETY: as above; the counters are atomic.
unsafe impl Sync for Device<'_> {}

impl<'a> Device<'a> {
    /// Opens a device with these settings (`isa=avx2,threads=1`), and checks that it is of version 4.
    pub(crate) fn open(library: &'a Library, settings: &str) -> Result<Self, String> {
        let settings_c = CString::new(settings).map_err(|_| "settings with a zero byte")?;
        // SAFETY: the text ends with a zero.
        let raw = unsafe { (library.new_device)(settings_c.as_ptr()) };
        if raw.is_null() {
            return Err(format!("Embree opens no device with '{settings}'"));
        }
        let device = Self { library, raw, memory: Box::default() };
        let version = device.version();
        if !(40_000..50_000).contains(&version) {
            return Err(format!("this is Embree {version}, and version 4 (40000 to 49999) is needed"));
        }
        let memory = std::ptr::from_ref(&*device.memory).cast_mut().cast();
        // SAFETY: the counters are in a box of the device, and the monitor is taken away before they are dropped.
        unsafe { (library.set_monitor)(raw, Some(count_memory), memory) };
        Ok(device)
    }

    fn property(&self, property: c_int) -> isize {
        // SAFETY: the device is open.
        unsafe { (self.library.device_property)(self.raw, property) }
    }

    /// 40400 for 4.4.0.
    pub(crate) fn version(&self) -> isize {
        self.property(PROPERTY_VERSION)
    }

    /// Whether packets of this size have code of their own on this CPU.
    pub(crate) fn has_packets(&self, size: usize) -> bool {
        match size {
            1 => true,
            4 => self.property(PROPERTY_NATIVE_RAY4) != 0,
            8 => self.property(PROPERTY_NATIVE_RAY8) != 0,
            16 => self.property(PROPERTY_NATIVE_RAY16) != 0,
            _ => false,
        }
    }

    /// Bytes that the library holds for this device, and the most that it held since the last query.
    pub(crate) fn memory(&self) -> (i64, i64) {
        let now = self.memory.now.load(Ordering::Relaxed);
        (now, self.memory.peak.swap(now, Ordering::Relaxed))
    }

    pub(crate) fn check(&self) -> Result<(), String> {
        // SAFETY: the device is open.
        match unsafe { (self.library.device_error)(self.raw) } {
            0 => Ok(()),
            code => Err(format!("Embree reports error {code}")),
        }
    }
}

impl Drop for Device<'_> {
    fn drop(&mut self) {
        // SAFETY: the device is open, its scenes are gone, and the counter has no more users.
        unsafe {
            (self.library.set_monitor)(self.raw, None, null_mut());
            (self.library.release_device)(self.raw);
        }
    }
}

/// A committed scene over one mesh, or over instances of one.
pub(crate) struct Scene<'a> {
    pub(crate) library: &'a Library,
    pub(crate) raw: Handle,
    pub(crate) arrays: PhantomData<&'a [u32]>,
}

// SAFETY: a committed scene is only read; Embree allows queries from any number of threads.
unsafe impl Send for Scene<'_> {}
// SAFETY: as above.
unsafe impl Sync for Scene<'_> {}

impl<'a> Scene<'a> {
    /// Builds over the triangles. `padded` holds one vertex more than there are; indices must be below its length.
    pub(crate) fn build(
        device: &'a Device<'a>,
        padded: &'a [[f32; 3]],
        indices: &'a [[u32; 3]],
        quality: i32,
        flags: i32,
    ) -> Result<Self, String> {
        let highest = indices.iter().flatten().max().map_or(0, |&i| i as usize + 1);
        assert!(highest < padded.len(), "index {highest} needs a vertex and one behind it: {}", padded.len());
        let library = device.library;
        // SAFETY: handles are used as Embree's manual shows. The arrays outlive the scene, every index is in range, and
        // one vertex behind the last that is used makes 16 bytes readable from each.
        let scene = unsafe {
            let geometry = (library.new_geometry)(device.raw, GEOMETRY_TRIANGLE);
            if quality == LOW {
                // Only the scene's quality builds the mesh as always.
                (library.set_geometry_quality)(geometry, LOW);
            }
            let (vertices, triangles) = (padded.as_ptr().cast(), indices.as_ptr().cast());
            let share = library.share_buffer;
            share(geometry, BUFFER_VERTEX, 0, FORMAT_FLOAT3, vertices, 0, 12, padded.len() - 1);
            share(geometry, BUFFER_INDEX, 0, FORMAT_UINT3, triangles, 0, 12, indices.len());
            Self::of(device, geometry, quality, flags)
        };
        device.check()?;
        Ok(scene)
    }

    /// Builds over curves of `order` vertices from each index on; `geometry_type` is one of the header's.
    #[allow(dead_code, reason = "bench/hair includes this file")]
    pub(crate) fn build_curves(
        device: &'a Device<'a>,
        geometry_type: c_int,
        vertices: &'a [[f32; 4]],
        indices: &'a [u32],
        order: usize,
        quality: i32,
    ) -> Result<Self, String> {
        const FORMAT_UINT: c_int = 0x5001;
        const FORMAT_FLOAT4: c_int = 0x9004;
        let highest = indices.iter().max().map_or(0, |&i| i as usize + order);
        assert!(highest <= vertices.len(), "a curve ends at {highest} of {} vertices", vertices.len());
        let library = device.library;
        // SAFETY: handles are used as Embree's manual shows. The arrays outlive the scene, and all indices are in range.
        let scene = unsafe {
            let geometry = (library.new_geometry)(device.raw, geometry_type);
            let (corners, curves) = (vertices.as_ptr().cast(), indices.as_ptr().cast());
            let share = library.share_buffer;
            share(geometry, BUFFER_VERTEX, 0, FORMAT_FLOAT4, corners, 0, 16, vertices.len());
            share(geometry, BUFFER_INDEX, 0, FORMAT_UINT, curves, 0, 4, indices.len());
            Self::of(device, geometry, quality, 0)
        };
        device.check()?;
        Ok(scene)
    }

    /// Commits a geometry, and a scene of only this geometry, which then owns it.
    ///
    /// # Safety
    /// The geometry belongs to the device, and its shared arrays outlive the scene.
    pub(crate) unsafe fn of(device: &'a Device<'a>, geometry: Handle, quality: i32, flags: i32) -> Self {
        let library = device.library;
        // SAFETY: handles are used as Embree's manual shows; the caller answers for the arrays.
        let raw = unsafe {
            (library.commit_geometry)(geometry);
            let raw = (library.new_scene)(device.raw);
            (library.set_quality)(raw, quality);
            (library.set_flags)(raw, flags);
            (library.attach)(raw, geometry);
            (library.release_geometry)(geometry);
            (library.commit_scene)(raw);
            raw
        };
        Self { library, raw, arrays: PhantomData }
    }

    /// The closest hit of one ray.
    #[inline(always)]
    pub(crate) fn intersect_one(&self, ray: &mut OneRay, arguments: &Arguments) {
        // SAFETY: layout and alignment are those of RTCRayHit.
        unsafe { (self.library.intersect1)(self.raw, std::ptr::from_mut(ray).cast(), arguments) }
    }

    /// Any hit of one ray.
    #[inline(always)]
    pub(crate) fn occluded_one(&self, ray: &mut OneRay, arguments: &Arguments) {
        // SAFETY: it begins with an RTCRay, and only that is used here.
        unsafe { (self.library.occluded1)(self.raw, std::ptr::from_mut(ray).cast(), arguments) }
    }

    /// Closest hits; `N` is 1, 4, 8 or 16.
    #[inline(always)]
    pub(crate) fn intersect<const N: usize>(
        &self,
        active: &Active<N>,
        packet: &mut Packet<N>,
        arguments: &Arguments,
    ) {
        let (rays, active) = (std::ptr::from_mut(packet).cast(), active.0.as_ptr());
        // SAFETY: layout and alignment of the packet and of `active` are those of this N.
        unsafe {
            match N {
                1 => (self.library.intersect1)(self.raw, rays, arguments),
                4 => (self.library.intersect4)(active, self.raw, rays, arguments),
                8 => (self.library.intersect8)(active, self.raw, rays, arguments),
                16 => (self.library.intersect16)(active, self.raw, rays, arguments),
                _ => unreachable!("packets hold 1, 4, 8 or 16 rays, not {N}"),
            }
        }
    }

    /// Any hits: `t_far` becomes -inf where there is one. `N` is 1, 4, 8 or 16.
    #[inline(always)]
    pub(crate) fn occluded<const N: usize>(
        &self,
        active: &Active<N>,
        packet: &mut Packet<N>,
        arguments: &Arguments,
    ) {
        let (rays, active) = (std::ptr::from_mut(packet).cast(), active.0.as_ptr());
        // SAFETY: a packet begins with the rays, RTCRay, RTCRay4, RTCRay8 or RTCRay16, and only those are
        // used here.
        unsafe {
            match N {
                1 => (self.library.occluded1)(self.raw, rays, arguments),
                4 => (self.library.occluded4)(active, self.raw, rays, arguments),
                8 => (self.library.occluded8)(active, self.raw, rays, arguments),
                16 => (self.library.occluded16)(active, self.raw, rays, arguments),
                _ => unreachable!("packets hold 1, 4, 8 or 16 rays, not {N}"),
            }
        }
    }
}

impl Drop for Scene<'_> {
    fn drop(&mut self) {
        // SAFETY: the scene is released once, before its device.
        unsafe { (self.library.release_scene)(self.raw) };
    }
}

/// A scene over one mesh whose vertices move: Embree refits its structure, with the settings of its manual.
pub(crate) struct MovingScene<'a> {
    scene: Scene<'a>,
    geometry: Handle,
    /// Embree's view of the vertices, with one more at the end.
    padded: Vec<[f32; 3]>,
}

impl<'a> MovingScene<'a> {
    /// Builds over the triangles; [`Scene::build`] defines `padded` and `indices`.
    pub(crate) fn build(
        device: &'a Device<'a>,
        padded: Vec<[f32; 3]>,
        indices: &'a [[u32; 3]],
    ) -> Result<Self, String> {
        const REFIT: c_int = 3;
        const DYNAMIC: c_int = 1;
        let highest = indices.iter().flatten().max().map_or(0, |&i| i as usize + 1);
        assert!(highest < padded.len(), "index {highest} needs a vertex and one behind it: {}", padded.len());
        let library = device.library;
        // SAFETY: handles are used as Embree's manual shows. The indices outlive the scene and are in range.
        // The vertices are in a vector of the scene, which never grows, so that their address is fixed; one
        // vertex behind the last used one makes 16 bytes readable from each. The geometry is stored for later
        // calls.
        let (scene, geometry) = unsafe {
            let geometry = (library.new_geometry)(device.raw, GEOMETRY_TRIANGLE);
            (library.set_geometry_quality)(geometry, REFIT);
            let (vertices, triangles) = (padded.as_ptr().cast(), indices.as_ptr().cast());
            let share = library.share_buffer;
            share(geometry, BUFFER_VERTEX, 0, FORMAT_FLOAT3, vertices, 0, 12, padded.len() - 1);
            share(geometry, BUFFER_INDEX, 0, FORMAT_UINT3, triangles, 0, 12, indices.len());
            (library.commit_geometry)(geometry);
            let raw = (library.new_scene)(device.raw);
            (library.set_quality)(raw, LOW);
            (library.set_flags)(raw, DYNAMIC);
            (library.attach)(raw, geometry);
            (library.commit_scene)(raw);
            (Scene { library, raw, arrays: PhantomData }, geometry)
        };
        device.check()?;
        Ok(Self { scene, geometry, padded })
    }

    /// Moves the vertices; the scene is not notified yet.
    pub(crate) fn move_to(&mut self, positions: &[[f32; 3]]) {
        let count = self.padded.len() - 1;
        self.padded[..count].copy_from_slice(&positions[..count]);
    }

    /// Fits the scene to its vertices.
    pub(crate) fn refit(&mut self) {
        let library = self.scene.library;
        // SAFETY: geometry and scene exist, and there is no concurrent query: the borrow is exclusive.
        unsafe {
            (library.update_buffer)(self.geometry, BUFFER_VERTEX, 0);
            (library.commit_geometry)(self.geometry);
            (library.commit_scene)(self.scene.raw);
        }
    }

    pub(crate) fn scene(&self) -> &Scene<'a> {
        &self.scene
    }
}

impl Drop for MovingScene<'_> {
    fn drop(&mut self) {
        // SAFETY: our hold on the geometry is released once; the scene, which is dropped after this, has its own.
        unsafe { (self.scene.library.release_geometry)(self.geometry) };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::mem::{offset_of, size_of};

    #[test]
    fn layouts_are_those_of_the_headers() {
        assert_eq!(offset_of!(Packet<1>, t_far), 32, "RTCRay: tfar");
        assert_eq!(offset_of!(Packet<1>, normal), 48, "RTCRayHit: the hit follows the ray");
        assert_eq!(offset_of!(Packet<1>, geom_id), 48 + 24, "RTCHit: geomID");
        assert_eq!(offset_of!(Packet<8>, t_far), 8 * 32, "RTCRay8: tfar");
        assert_eq!(offset_of!(Packet<16>, normal), 16 * 48, "RTCRayHit16: the hit follows the ray");
        assert_eq!(size_of::<Packet<16>>(), 21 * 64, "RTCRayHit16: 21 rows");
        assert!(size_of::<Packet<1>>() >= 96, "RTCRayHit: with its padding");
        assert_eq!((size_of::<OneRay>(), offset_of!(One, t_far)), (96, 32), "RTCRayHit, and its tfar");
        assert_eq!((offset_of!(One, normal), offset_of!(One, geom_id)), (48, 48 + 24), "RTCHit: geomID");
        assert_eq!(offset_of!(Arguments, context), 8, "two numbers before the pointers");
    }
}
