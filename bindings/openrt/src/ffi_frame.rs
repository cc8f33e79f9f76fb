// SPDX-License-Identifier: GPL-3.0-or-later
//! Exported calls: frame buffer, frames, lights, camera and environment.
//! Tests: tests/c/scene.c.

use std::sync::Arc;

use crate::calls::camera::Volume;
use crate::ffi::{call, procedures};
use crate::state::framebuffer::{FrameMemory, RT_IN_FLIGHT_BIT, RT_NEXT_FRAME_BIT};

/// A program's frame buffer.
struct ProgramMemory(*mut u8);

// SAFETY: the pointer is only written through, by one frame at a time; the program must neither free nor use
// the memory until rtEndRendering (openrt/rt.h).
unsafe impl Send for ProgramMemory {}
// SAFETY: as above.
unsafe impl Sync for ProgramMemory {}

impl FrameMemory for ProgramMemory {
    fn write(&self, offset: usize, bytes: &[u8]) {
        // SAFETY: the program vouches for width * height pixels; `FrameBuffer::show` writes no further.
        unsafe { bytes.as_ptr().copy_to_nonoverlapping(self.0.add(offset), bytes.len()) }
    }

    fn address(&self) -> usize {
        self.0.addr()
    }
}

/// # Safety
/// As openrt/rt.h says: `pixels` is null or has room for them until the frames that use it have ended.
#[unsafe(no_mangle)]
unsafe extern "C-unwind" fn rtSetFrameBuffer(pixels: *mut u8, width: u32, height: u32, format: u32) {
    let memory = (!pixels.is_null()).then(|| Arc::new(ProgramMemory(pixels)) as Arc<dyn FrameMemory>);
    call!(rtSetFrameBuffer(pixels, width, height, format), (), |context| context.set_frame_buffer(
        memory,
        [width, height],
        format
    ));
}

#[unsafe(no_mangle)]
extern "C-unwind" fn rtFrameBufferUse(pixels: *const u8) -> u32 {
    let all = RT_NEXT_FRAME_BIT | RT_IN_FLIGHT_BIT;
    crate::ffi::look(all, |context| context.map_or(0, |context| context.frame_buffer_use(pixels.addr())))
}

#[unsafe(no_mangle)]
extern "C-unwind" fn rtGetRayEpsilon() -> f32 {
    call!(rtGetRayEpsilon(), 0.0, |context| context.ray_epsilon())
}

/// Waits for the frame in flight without holding the lock: other threads go on meanwhile. False if there is none.
fn wait_for_frame() -> bool {
    let flight = crate::ffi::perform(String::new, None, |context| Ok(context.flight()));
    flight.is_some_and(|flight| {
        flight.wait();
        true
    })
}

#[unsafe(no_mangle)]
extern "C-unwind" fn rtEndRendering() {
    wait_for_frame();
    call!(rtEndRendering(), (), |context| context.end_rendering());
}

#[unsafe(no_mangle)]
extern "C-unwind" fn rtRender() {
    call!(rtRender(), (), |context| context.begin_render());
    // A frame may have started although the call failed: without plugins that do not support it.
    if wait_for_frame() {
        call!(rtRender(), (), |context| context.end_rendering());
    }
}

#[unsafe(no_mangle)]
extern "C-unwind" fn rtRenderFrame() {
    rtRender();
}

#[unsafe(no_mangle)]
extern "C-unwind" fn rtSwapBuffers() {
    wait_for_frame();
    call!(rtSwapBuffers(), (), |context| context.swap_buffers());
}

procedures! {
    rtStartRendering() => |context| context.start_rendering();
    rtCancelRendering() => |context| context.cancel_rendering();
    rtSetSamplesPerPixel(samples: u32) => |context| context.set_samples_per_pixel(samples);
    rtProgressive(on: u8) => |context| context.set_progressive(on != 0);
    rtSceneMode(mode: u32) => |context| context.set_scene_mode(mode);
    rtSetMaxRayRecursionDepth(depth: u32) => |context| context.set_max_depth(depth);
    rtSetRayEpsilon(epsilon: f32) => |context| context.set_ray_epsilon(epsilon);

    rtUseLight(shader: u32) => |context| context.use_light(shader);
    rtUseLightFast(shader: u32) => |context| context.use_light_fast(shader);
    rtRemoveLight(shader: u32) => |context| context.remove_light(shader);
    rtUseCamera(shader: u32) => |context| context.use_camera(shader);
    rtUseEnvironmentShader(shader: u32) => |context| context.use_environment_shader(shader);
    rtUseRenderingObject(shader: u32) => |context| context.use_rendering_object(shader);

    rtLookAt(
        eye_x: f64, eye_y: f64, eye_z: f64,
        center_x: f64, center_y: f64, center_z: f64,
        up_x: f64, up_y: f64, up_z: f64
    ) => |context| {
        context.look_at([eye_x, eye_y, eye_z], [center_x, center_y, center_z], [up_x, up_y, up_z])
    };
    rtPerspective(fov_y: f64, near: f64, far: f64) => |context| context.perspective(fov_y, [near, far]);
    rtFrustum(left: f64, right: f64, bottom: f64, top: f64, near: f64, far: f64) => |context| {
        context.frustum(Volume { x: [left, right], y: [bottom, top], z: [near, far] })
    };
    rtOrtho(left: f64, right: f64, bottom: f64, top: f64, near: f64, far: f64) => |context| {
        context.ortho(Volume { x: [left, right], y: [bottom, top], z: [near, far] })
    };
}
