// SPDX-License-Identifier: GPL-3.0-or-later
//! The pictures that the window gets, and their order.

use std::sync::Arc;
use std::time::Instant;

use super::*;
use crate::exposure::Exposure;
use crate::eye::{Eye, ViewRequest};
use crate::scripts::{ScriptRole, StageScript};
use crate::shown::Shown;
use gnurt::osl::ParameterValue;
use gnurt::render::{Integrator, SceneCamera, Silent, render};
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

fn load(pool: &ThreadPool) -> Result<Stage, String> {
    let mut scene = gnurt::load_scene("builtin:cornell").map_err(|error| error.to_string())?.scene;
    gnurt::defaults::complete(&mut scene, 1.0);
    Ok(Stage::of(scene, pool))
}

fn options() -> RenderOptions {
    RenderOptions { spp: 6, seed: 5, ..RenderOptions::default() }
}

fn begin(loader: Loader) -> (RenderThread, Receiver<RenderEvent>, RenderRequest) {
    begin_with(loader, load)
}

fn begin_with(
    loader: Loader,
    first: fn(&ThreadPool) -> Result<Stage, String>,
) -> (RenderThread, Receiver<RenderEvent>, RenderRequest) {
    let pool = gnurt::thread_pool(2).expect("two threads");
    begin_on(loader, first(&pool).expect("the box is built in"))
}

fn begin_on(loader: Loader, stage: Stage) -> (RenderThread, Receiver<RenderEvent>, RenderRequest) {
    let pool = gnurt::thread_pool(2).expect("two threads");
    let request = RenderRequest {
        camera: stage.scene.cameras()[0].clone(),
        shown: Shown::Light(Integrator::Whitted),
        size: [61, 47],
        exposure: Exposure::default(),
        moving: false,
        paused: false,
        denoised: false,
        clip_time: None,
        clip: None,
    };
    let (sender, events) = channel();
    let notify = Box::new(move |what| drop(sender.send(what)));
    let denoiser = denoise::Options { method: denoise::Method::BuiltIn, ..denoise::Options::default() };
    let parts = RenderThreadParts { stage, options: options(), pool, loader, denoiser, notify };
    (RenderThread::begin(parts, request.clone()).expect("a thread"), events, request)
}

/// Waits until the front is as it should be.
#[track_caller]
fn wait_for(render_thread: &RenderThread, what: &str, is_there: impl Fn(&DisplayFrame) -> bool) {
    let begin = Instant::now();
    while !is_there(&render_thread.front()) {
        assert!(begin.elapsed() < Duration::from_secs(60), "no {what}: {:?}", render_thread.front().readings);
        std::thread::sleep(Duration::from_millis(2));
    }
}

fn is_finished(front: &DisplayFrame) -> bool {
    front.whole && front.readings.samples == [6, 6]
}

#[test]
fn what_is_seen_at_last_is_what_render_makes() {
    let (render_thread, _events, mut request) = begin(Box::new(|_, pool| load(pool)));
    // Restless: views come faster than pictures.
    for step in 0..30 {
        request.camera.eye[0] += 0.001;
        request.moving = step % 3 != 0;
        render_thread.send_request(&request);
        std::thread::sleep(Duration::from_millis(1));
    }
    request.moving = false;
    render_thread.send_request(&request);
    let view = lock(&render_thread.shared.request).view;
    wait_for(&render_thread, "finished picture", |front| is_finished(front) && front.view == view);
    let pool = gnurt::thread_pool(1).expect("a thread");
    let stage = load(&pool).expect("the box");
    let camera = SceneCamera::new(&request.camera).expect("a view");
    let options = RenderOptions { width: 61, height: 47, ..options() };
    let frame = render(&stage.world, &camera, &options, &pool, &Silent).expect("sound options");
    assert!(render_thread.front().colors == frame.picture.color, "the same bits");
    request.exposure.stops = 2.0;
    render_thread.send_request(&request);
    wait_for(&render_thread, "brighter picture", |front| front.exposure.stops == 2.0);
    assert!(is_finished(&render_thread.front()), "with the samples that were there");
}

/// Each picture that reaches the window while the camera moves is a preview of that view, in all of its
/// pixels.
#[test]
fn pictures_are_whole_when_they_are_shown() {
    let (render_thread, _events, mut request) = begin(Box::new(|_, pool| load(pool)));
    wait_for(&render_thread, "finished picture", is_finished);
    request.moving = true;
    let mut cameras = Vec::new();
    let mut frames: Vec<(u64, u64, [u32; 2], Vec<u32>)> = Vec::new();
    for step in 0..40 {
        request.camera.eye[0] += 0.01;
        render_thread.send_request(&request);
        cameras.push((lock(&render_thread.shared.request).view, request.camera.clone()));
        std::thread::sleep(Duration::from_millis(step % 5));
        let front = render_thread.front();
        if !front.whole && frames.last().is_none_or(|&(number, ..)| number != front.number) {
            frames.push((front.number, front.view, front.readings.rendered, front.screen.clone()));
        }
    }
    assert!(frames.len() > 3, "some are seen: {}", frames.len());
    let pool = gnurt::thread_pool(1).expect("a thread");
    let stage = load(&pool).expect("the box");
    for (_, view, size, screen) in frames {
        let (_, camera) = cameras.iter().find(|(of, _)| *of == view).expect("it was wished for");
        let view_request = ViewRequest {
            camera: camera.clone(),
            shown: request.shown,
            size,
            preview: true,
            denoised: false,
        };
        let mut eye = Eye::new(options());
        eye.begin(&view_request, None, &pool).expect("a view");
        assert!(eye.pass(&stage.world, 1, &pool, &Silent), "nobody stops it");
        let mut whole = Vec::new();
        eye.develop(request.exposure, request.size, &mut whole, false, &pool);
        assert!(screen == whole, "view {view}, {size:?}");
    }
}

/// Pictures of integrators with random light samples are whole at once, and at rest become the result of
/// `render`.
#[test]
fn remembered_pictures_are_full_size() {
    let (render_thread, _events, mut request) = begin(Box::new(|_, pool| load(pool)));
    request.shown = Shown::Light(Integrator::Path);
    for moving in [true, false] {
        for _ in 0..10 {
            request.camera.eye[0] += 0.002;
            request.moving = moving;
            render_thread.send_request(&request);
            std::thread::sleep(Duration::from_millis(3));
        }
        let view = lock(&render_thread.shared.request).view;
        wait_for(&render_thread, "whole picture", |front| {
            front.view == view && front.whole != moving && (!moving || front.readings.rendered == [61, 47])
        });
    }
    wait_for(&render_thread, "finished picture", is_finished);
    let pool = gnurt::thread_pool(1).expect("a thread");
    let stage = load(&pool).expect("the box");
    let camera = SceneCamera::new(&request.camera).expect("a view");
    let options = RenderOptions { width: 61, height: 47, integrator: Integrator::Path, ..options() };
    let frame = render(&stage.world, &camera, &options, &pool, &Silent).expect("sound options");
    assert!(render_thread.front().colors == frame.picture.color, "the same bits");
}

#[test]
fn moving_pictures_are_coarse_and_rest_makes_them_whole() {
    let (render_thread, _events, mut request) = begin(Box::new(|_, pool| load(pool)));
    wait_for(&render_thread, "finished picture", is_finished);
    request.moving = true;
    request.camera.eye[0] += 0.01;
    render_thread.send_request(&request);
    wait_for(&render_thread, "passing look", |front| !front.whole && front.view == 2);
    std::thread::sleep(Duration::from_millis(50));
    assert!(!render_thread.front().whole, "as long as it moves");
    (request.moving, request.shown) = (false, Shown::Depth);
    render_thread.send_request(&request);
    wait_for(&render_thread, "finished picture of depths", |front| is_finished(front) && front.view == 3);
    let [r, g, b, _] = render_thread.front().colors[30];
    assert!(r == g && g == b && r > 0.0, "grey: {r} {g} {b}");
    (request.paused, request.shown) = (true, Shown::Light(Integrator::Normals));
    render_thread.send_request(&request);
    wait_for(&render_thread, "first look", |front| front.view == 4);
    std::thread::sleep(Duration::from_millis(50));
    assert!(!is_finished(&render_thread.front()), "no samples are added");
}

#[test]
fn noise_goes_when_asked_for() {
    let (render_thread, _events, mut request) = begin(Box::new(|_, pool| load(pool)));
    wait_for(&render_thread, "finished picture", is_finished);
    let noisy = render_thread.front().colors.clone();
    request.denoised = true;
    render_thread.send_request(&request);
    wait_for(&render_thread, "clean picture", |front| is_finished(front) && front.readings.denoised);
    let pool = gnurt::thread_pool(1).expect("a thread");
    let stage = load(&pool).expect("the box");
    let camera = SceneCamera::new(&request.camera).expect("a view");
    let options = RenderOptions { width: 61, height: 47, aovs: true, seen: true, ..options() };
    let mut picture = render(&stage.world, &camera, &options, &pool, &Silent).expect("sound options").picture;
    let how = denoise::Options { method: denoise::Method::BuiltIn, ..denoise::Options::default() };
    denoise::denoise(&mut picture, &how, &pool).expect("it has all layers");
    assert!(render_thread.front().colors == picture.color, "as a picture that is denoised after rendering");
    assert!(noisy != picture.color, "another picture");
    request.exposure.stops = 1.0;
    render_thread.send_request(&request);
    wait_for(&render_thread, "brighter picture", |front| {
        front.exposure.stops == 1.0 && front.readings.denoised
    });
    assert!(render_thread.front().colors == picture.color, "the same light");
    request.denoised = false;
    render_thread.send_request(&request);
    wait_for(&render_thread, "noise again", |front| !front.readings.denoised);
    assert!(is_finished(&render_thread.front()) && render_thread.front().colors == noisy, "with all samples");
    // A camera that moves is not waited for.
    (request.denoised, request.moving) = (true, true);
    request.camera.eye[0] += 0.01;
    render_thread.send_request(&request);
    wait_for(&render_thread, "passing look", |front| !front.whole && !front.readings.denoised);
}

/// The box with a ball of a triangle that falls from 0 to 1 s.
fn falling(pool: &ThreadPool) -> Result<Stage, String> {
    use gnurt::scene::animation::{
        Attachment, Channel, Clip, Interpolation, Local, MovingInstance, Node, Sampler, Target, Trs,
    };
    let mut stage = load(pool)?;
    let instance = stage.scene.instantiate(gnurt::scene::ObjectId(0), gnurt::scene::Affine::IDENTITY);
    let keys = Sampler::new([0.0, 1.0].into(), vec![0.0, 0.5, 0.0, 0.0, 0.0, 0.0], 3, Interpolation::Linear);
    let ground = Attachment::Fixed { world_from_node: gnurt::scene::Affine::IDENTITY, visible: true };
    let node = Node { name: "n".into(), parent: ground, rest: Local::Parts(Trs::default()), visible: true };
    let channel = Channel { target: Target::Translation(0), sampler: Arc::new(keys.expect("keys")) };
    let animated = stage.scene.animate(gnurt::scene::Animation {
        clips: vec![Clip { name: "fall".into(), channels: vec![channel] }],
        nodes: vec![node],
        instances: vec![MovingInstance { instance, node: 0, has_transform: true }],
        ..gnurt::scene::Animation::default()
    });
    animated.map_err(|error| error.to_string())?;
    stage.clip = Some(0);
    stage.show(None, pool)?;
    Ok(stage)
}

#[test]
fn moments_are_those_of_the_scene() {
    let pool = gnurt::thread_pool(1).expect("a thread");
    let (render_thread, events, mut request) = begin_with(Box::new(|_, pool| falling(pool)), falling);
    wait_for(&render_thread, "finished picture", is_finished);
    // Played: moments come faster than pictures, and are seen all the same.
    request.moving = true;
    for step in 1..40 {
        request.clip_time = Some(f64::from(step) / 80.0);
        render_thread.send_request(&request);
        std::thread::sleep(Duration::from_millis(2));
    }
    wait_for(&render_thread, "passing look", |front| !front.whole && front.readings.update_seconds > 0.0);
    for clip_time in [Some(0.25), Some(0.75), None] {
        (request.moving, request.clip_time) = (false, clip_time);
        render_thread.send_request(&request);
        let view = lock(&render_thread.shared.request).view;
        wait_for(&render_thread, "moment", |front| is_finished(front) && front.view == view);
        let mut stage = falling(&pool).expect("a box");
        stage.show(clip_time, &pool).expect("it can be shown");
        let camera = SceneCamera::new(&request.camera).expect("a view");
        let options = RenderOptions { width: 61, height: 47, ..options() };
        let frame = render(&stage.world, &camera, &options, &pool, &Silent).expect("sound options");
        assert!(render_thread.front().colors == frame.picture.color, "{clip_time:?}: the same bits");
    }
    assert!(!events.try_iter().any(|events| matches!(events, RenderEvent::Trouble(_))), "no trouble");
}

#[test]
fn scenes_are_read_again_or_stay() {
    let count = AtomicU64::new(0);
    let (render_thread, events, _) =
        begin(Box::new(move |file, pool| match count.fetch_add(1, Ordering::Relaxed) {
            0 => Err("line 3 is broken".into()),
            2 => load(pool).map(|stage| Stage { files: file.map(Into::into).into_iter().collect(), ..stage }),
            _ => load(pool),
        }));
    wait_for(&render_thread, "finished picture", is_finished);
    let colors = render_thread.front().colors.clone();
    let reported = |render_thread: &RenderThread, file: Option<&str>| {
        render_thread.reload(file.map(Into::into));
        let mut events = events.iter().filter(|events| *events != RenderEvent::Picture);
        events.next().expect("it is told")
    };
    assert_eq!(
        reported(&render_thread, None),
        RenderEvent::Trouble("line 3 is broken".into()),
        "what is wrong"
    );
    assert!(
        is_finished(&render_thread.front()) && render_thread.front().colors == colors,
        "the picture stays"
    );
    let number = render_thread.front().number;
    assert_eq!(
        reported(&render_thread, None),
        RenderEvent::Reloaded { files: Vec::new(), is_other: false },
        "mended"
    );
    wait_for(&render_thread, "new picture", |front| is_finished(front) && front.number > number);
    let other = RenderEvent::Reloaded { files: vec!["b.obj".into()], is_other: true };
    assert_eq!(reported(&render_thread, Some("b.obj")), other, "another one");
}

/// The box in a script of this text.
fn painted(text: &str) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("paint.osl");
    std::fs::write(&file, text).expect("a file");
    (folder, file)
}

#[test]
fn shaders_are_read_again_by_themselves_or_stay() {
    use gnurt::osl::{Access, Script};
    let (_folder, file) = painted("surface paint (float gain = 1) { Ci = gain * emission (); }");
    let pool = gnurt::thread_pool(2).expect("two threads");
    let mut stage = load(&pool).expect("the box");
    let script = Script::open(&file, &Access::default()).expect("it compiles");
    for id in 0..stage.scene.materials().len() as u32 {
        stage.scene.edit_material(gnurt::scene::MaterialId(id)).surface = gnurt::scene::Surface::Shader(0);
    }
    let surface = script.surface().expect("a surface");
    stage.scripts.table.surfaces.push(surface);
    stage.scripts.list.push(StageScript::new(script, ScriptRole::Surface(0)));
    stage.world.commit(&stage.scene, &stage.scripts.table, &stage.how, &pool).expect("a sound scene");
    let stage_files = stage.scripts.files();
    let (render_thread, events, request) = begin_on(Box::new(|_, pool| load(pool)), stage);
    // Lights and the surroundings of the box show other values.
    let shows = |value: f32| {
        move |front: &DisplayFrame| {
            let count = front.colors.iter().filter(|pixel| pixel[1] == value).count();
            2 * count > front.colors.len()
        }
    };
    let is_all = |value: f32| move |front: &DisplayFrame| is_finished(front) && shows(value)(front);
    wait_for(&render_thread, "first picture", is_all(1.0));
    let world = render_thread.stage().world.stats();
    let mut watch = crate::watch::Watch::new(stage_files);
    let mut save = |text: &str| {
        std::fs::write(&file, text).expect("a file");
        let begin = Instant::now();
        // As the window looks at files.
        let changed = loop {
            std::thread::sleep(Duration::from_millis(20));
            let changed = watch.changed();
            if !changed.is_empty() {
                break changed;
            }
        };
        render_thread.read_again(changed);
        let reported =
            events.iter().find(|events| !matches!(events, RenderEvent::Picture | RenderEvent::Denoised(_)));
        (reported.expect("it is told"), begin)
    };
    let (reported, _) = save("surface paint (float gain = 1) { Ci = gainn * emission (); }");
    assert!(
        matches!(&reported, RenderEvent::BadShader(why) if why.contains("paint.osl:1") && why.contains("gainn")),
        "{reported:?}"
    );
    wait_for(&render_thread, "the last good one", is_all(1.0));
    let (reported, begin) = save("surface paint (float gain = 2) { Ci = gain * emission (); }");
    let took = begin.elapsed();
    assert_eq!(reported, RenderEvent::Shaders(vec!["paint.osl was read again".into()]));
    wait_for(&render_thread, "the new one", shows(2.0));
    let shown = begin.elapsed().as_millis();
    wait_for(&render_thread, "all of it", is_all(2.0));
    assert_eq!(render_thread.stage().world.stats(), world, "nothing else was made");
    eprintln!("a saved shader is read after {} ms and seen after {shown} ms", took.as_millis());
    assert!(took < Duration::from_millis(1000), "{took:?}");
    for value in [3.0, 0.25] {
        render_thread.tune((0, "gain".into(), ParameterValue::Floats(vec![value])));
        wait_for(&render_thread, "the knob's value", is_all(value));
    }
    let (reported, _) = save("surface paint (float gain = 2) { Ci = 4 * gain * emission (); }");
    assert!(matches!(reported, RenderEvent::Shaders(_)), "{reported:?}");
    wait_for(&render_thread, "the new one with the knob's value", is_all(1.0));
    render_thread.tune((0, "gain".into(), ParameterValue::Floats(vec![0.5])));
    wait_for(&render_thread, "which the knob still turns", is_all(2.0));
    render_thread.tune((0, "no".into(), ParameterValue::Floats(vec![0.5])));
    assert!(events.iter().any(|events| matches!(events, RenderEvent::Trouble(_))), "told");
    drop(request);
}
