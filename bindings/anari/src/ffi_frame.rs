// SPDX-License-Identifier: GPL-3.0-or-later
//! Renderings of frames: from objects to a job, and the program's function at the end.
//! Tests: tests/frames.rs.

use std::ffi::c_void;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::time::Instant;

use crate::camera::View;
use crate::device::Device;
use crate::ffi_status::{Code, Severity};
use crate::frame::Frame;
use crate::freshness;
use crate::object::{Object, Snapshot, lock};
use crate::output::{Formats, Output, formats};
use crate::picture::Job;
use crate::settings::Settings;
use crate::types;
use crate::world::Stage;

/// The program's function that is called when a rendering ends.
type Completion = unsafe extern "C-unwind" fn(user: *const c_void, device: *mut c_void, frame: *mut c_void);

/// Pixels of a frame, at most: 2^28.
const MOST_PIXELS: u64 = 1 << 28;

/// The job of a frame; an error in words where something is missing.
fn job(device: &Device, now: &Snapshot, size: [u32; 2], formats: Formats) -> Result<Job, String> {
    let object =
        |name: &str, kind| now.object(name, kind).ok_or_else(|| format!("parameter '{name}': missing"));
    let (world, camera) = (object("world", types::WORLD)?, object("camera", types::CAMERA)?);
    let renderer = object("renderer", types::RENDERER)?;
    let report = |about: &Object, text: &str| device.reporter.warn(about, text);
    let view = View::new(camera).map_err(|fault| format!("{}: {fault}", camera.label()))?;
    let of = |object: &Object| freshness::stamp(object).rotate_left(20) ^ object.handle as u64;
    Ok(Job {
        stage: Stage::of(world, view.shutter, &report),
        view: Arc::new(view),
        settings: Arc::new(Settings::new(renderer)),
        size,
        formats,
        key: [of(world), of(camera), of(renderer), u64::from(size[0]), u64::from(size[1])],
        accumulates: now.bool("accumulation").unwrap_or(false),
    })
}

/// Starts a rendering.
pub(crate) fn render(device: &Arc<Device>, object: &Arc<Object>) {
    let Some(frame) = Frame::of(object) else { return };
    frame.wait();
    let now = object.committed();
    let say = |text: &str| device.reporter.send(Some(object), Severity::Error, Code::Operation, text);
    let size = now.size("size").unwrap_or([0; 2]);
    let pixels = u64::from(size[0]) * u64::from(size[1]);
    if pixels == 0 || pixels > MOST_PIXELS {
        say(&format!("parameter 'size': {} x {}: out of range; not rendered", size[0], size[1]));
        frame.put(Some(Output::default()));
        return;
    }
    let mut fault = |channel: &str, format| {
        let text = format!("parameter '{channel}': format {}: invalid", types::name(format));
        device.reporter.warn(object, &text);
    };
    let formats = formats(&now, &mut fault);
    let job = match job(device, &now, size, formats) {
        Ok(job) => job,
        Err(fault) => {
            say(&format!("{fault}; not rendered"));
            frame.put(Some(Output::empty(size, &formats)));
            complete(device, object, &now);
            return;
        }
    };
    let (device_there, object_there) = (device.clone(), object.clone());
    let work = move || {
        let (device, object) = (device_there, object_there);
        let Some(frame) = Frame::of(&object) else { return };
        let done = catch_unwind(AssertUnwindSafe(|| rendered(&device, &object, frame, &job)));
        if done.is_err() {
            let text = "rendering failed: a fault of GNU RT";
            device.reporter.send(Some(&object), Severity::Fatal, Code::Unknown, text);
            frame.put(Some(Output::empty(job.size, &job.formats)));
        }
        complete(&device, &object, &now);
        frame.finish();
        device.end_work();
    };
    device.begin_work();
    if let Err(fault) = frame.start(work) {
        device.end_work();
        say(&fault);
    }
}

fn rendered(device: &Device, object: &Object, frame: &Frame, job: &Job) {
    let begin = Instant::now();
    let Some(pool) = device.pool() else { return frame.put(Some(Output::empty(job.size, &job.formats))) };
    // Taken out: no lock is held while trees are built.
    let mut kept = lock(&frame.growing).take();
    let done = job.run(&mut kept, pool, &frame.stop);
    *lock(&frame.growing) = kept;
    match done {
        Ok(Some(mut output)) => {
            output.duration = begin.elapsed().as_secs_f32();
            frame.put(Some(output));
        }
        // Discarded: the last picture stays.
        Ok(None) if frame.output().size == job.size => frame.put(None),
        Ok(None) => frame.put(Some(Output::empty(job.size, &job.formats))),
        Err(fault) => {
            device.reporter.send(Some(object), Severity::Error, Code::Operation, &fault);
            frame.put(Some(Output::empty(job.size, &job.formats)));
        }
    }
}

/// Calls the program's function.
fn complete(device: &Device, object: &Object, now: &Snapshot) {
    let Some(address) = now.pointer("frameCompletionCallback") else { return };
    // SAFETY: the program gave the address as an ANARIFrameCompletionCallback, and `Option` of a function may be any address or 0.
    let function = unsafe { (&raw const address).cast::<Option<Completion>>().read() };
    let Some(function) = function else { return };
    let user = now.pointer("frameCompletionCallbackUserData").unwrap_or(0);
    // SAFETY: the program promises that its function takes these.
    let call = || unsafe {
        function(user as *const c_void, device.handle as *mut c_void, object.handle as *mut c_void)
    };
    drop(catch_unwind(AssertUnwindSafe(call)));
}
