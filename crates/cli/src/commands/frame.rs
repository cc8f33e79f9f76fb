// SPDX-License-Identifier: GPL-3.0-or-later
//! The steps from a scene to a picture, which stills and frames of animations share.
//! See docs/reference/cli.md. Tests: `tests/`.

use std::cell::Cell;
use std::fmt::Debug;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use gnurt::denoise::{self, denoise};
use gnurt::display_rules::{FEW_SAMPLES, is_noisy};
use gnurt::image::Picture;
use gnurt::layers::{LayerList, drop_seen};
use gnurt::mattes;
use gnurt::memory::{check_memory, format_bytes};
use gnurt::render::{
    Accumulation, CommitOptions, CommitReport, Frame, Integrator, Mattes, Piece, RenderOptions, RenderStats,
    ShaderTable, World, fingerprint, render_on,
};
use gnurt::scene::Scene;
use gnurt::scene::animation::Exposure;
use gnurt::shading::CameraShader;
use gnurt::simd::Level;
use gnurt::{FramePose, ThreadPool};
use gnurt_view::TevImage;

use super::{band_rows, pieces};
use crate::arguments::{
    DisplayOptions, FrameArguments, LightArguments, RenderArguments, StatisticsForm, TreeArguments,
};
use crate::checkpoint::Checkpoint;
use crate::display::Displayed;
use crate::environment::Environment;
use crate::failure::{Failure, Outcome};
use crate::messages::{Messages, print};
use crate::output::{Output, is_same_file};
use crate::picture_header::{describe, describe_making};
use crate::progress::Watcher;
use crate::shaders::{self, Shaders};
use crate::signals;
use crate::source::Source;
use crate::statistics::Statistics;
use crate::view::{self, CameraMotion, Chosen};

/// Decisions made before any work.
pub(super) struct Plan {
    pub(super) source: Source,
    /// The files written at the end.
    pub(super) targets: Targets,
    /// The denoiser: requested, or chosen because there are few samples.
    pub(super) filter: Option<Filter>,
    /// Rows that are rendered and written at a time; `None` = all.
    pub(super) band_rows: Option<u32>,
}

#[derive(Clone)]
pub(super) struct Targets {
    pub(super) picture: Output,
    pub(super) heatmap: Option<Output>,
}

impl Targets {
    /// Rejects output over input: files of the scene, and those that arguments name.
    pub(super) fn spare(&self, mut read: Vec<PathBuf>, arguments: &RenderArguments) -> Outcome {
        read.extend(arguments.view.surroundings.files());
        read.extend(shaders::other_files(&arguments.frame, &arguments.view));
        let mut all = std::iter::once(&self.picture).chain(&self.heatmap);
        all.try_for_each(|output| output.spare(&read))
    }
}

pub(super) struct Filter {
    pub(super) options: denoise::Options,
    /// Whether it was chosen by default: many samples need none then.
    is_default: bool,
    /// Whether it was reported: once is enough for all frames of a film.
    is_reported: Cell<bool>,
}

/// A scene that is ready for rays.
pub(super) struct Ready {
    pub(super) world: World,
    pub(super) report: CommitReport,
    pub(super) chosen: Chosen,
    /// The camera's motion while the shutter is open, if it moves.
    pub(super) motion: Option<CameraMotion>,
    /// The frame of a film, and its neighbours, for the layer of motion.
    pub(super) poses: Option<Poses>,
    pub(super) shaders: Shaders,
    pub(super) checkpoint: Option<Checkpoint>,
    /// The fingerprint of the picture, if it is needed.
    pub(super) print: u64,
    pub(super) load_time: Duration,
    /// The layers that are kept; `None` = all.
    pub(super) list: Option<LayerList>,
    /// The scene, for the names of its mattes.
    pub(super) named: Option<Scene>,
    /// Curve and exposure of all frames; `None` = as given, or else chosen from the picture.
    pub(super) light: Option<LightArguments>,
}

/// A frame of a film, the one before and the one after, if there are any.
pub(super) struct Poses {
    pub(super) now: FramePose,
    pub(super) before: Option<FramePose>,
    pub(super) after: Option<FramePose>,
}

/// Renders a scene that is ready, and writes the picture.
pub(super) fn make(
    arguments: &RenderArguments,
    begin: Instant,
    plan: &Plan,
    ready: &Ready,
    options: &RenderOptions,
    pool: &ThreadPool,
    messages: Messages,
) -> Outcome {
    let mut frame = render_frame(arguments, plan, ready, options, pool, messages)?;
    report_faults(&frame.stats, arguments, ready, messages);
    if signals::is_stopped() && arguments.times.frames.is_some() {
        // A file that is there counts as a frame that is done.
        return Ok(());
    }
    if options.piece.is_none() {
        take_noise_out(&mut frame, plan, pool, messages)?;
    }
    appear(&mut frame.picture, (arguments, plan), ready, options);
    label(&mut frame.picture, Some(&frame.stats), plan, ready, options);
    save(&frame, &plan.targets, ready, arguments, options, messages)?;
    report(arguments, begin, plan, ready, options, &frame.stats, messages)
}

/// What went wrong in a frame.
pub(super) fn report_faults(
    stats: &RenderStats,
    arguments: &RenderArguments,
    ready: &Ready,
    messages: Messages,
) {
    tell(stats, arguments, messages);
    ready.shaders.report_faults(messages);
    let camera = ready.chosen.shader.iter();
    camera.flat_map(|shader| shader.script.faults()).for_each(|fault| messages.warning(fault));
}

/// Renders, shows and saves intermediate results.
pub(super) fn render_frame(
    arguments: &RenderArguments,
    plan: &Plan,
    ready: &Ready,
    options: &RenderOptions,
    pool: &ThreadPool,
    messages: Messages,
) -> Result<Frame, Failure> {
    let begun = match &ready.checkpoint {
        Some(checkpoint) => checkpoint.begin(options, messages)?,
        None => Accumulation::new(options.clone()).map_err(Failure::usage)?,
    };
    let (size, name) = ([options.width, options.height], plan.source.name());
    let tev = arguments.display.as_ref().map(|address| TevImage::create(address, &name, size));
    let tev = tev.transpose().map_err(Failure::data)?;
    let watcher = Watcher::begin(messages.shows_progress());
    let displayed = Displayed::new(&watcher, tev, ready.world.space());
    let every = ready.checkpoint.as_ref().map(|checkpoint| checkpoint.every);
    let mut saved = Ok(());
    let rays: &dyn CameraShader = ready.motion.as_ref().map_or(&*ready.chosen.rays, |motion| &*motion.rays);
    let mut frame = render_on(begun, &ready.world, rays, pool, &displayed, every, &mut |picture| {
        if let Some(checkpoint) = &ready.checkpoint {
            saved = checkpoint.save(picture);
        }
    });
    let lost = displayed.end();
    watcher.end();
    if let Some(why) = lost {
        messages.warning(format_args!("the picture is no longer shown: {why}"));
    }
    saved?;
    if let Some(Poses { now, before, after }) = ready.poses.as_ref().filter(|_| options.aovs) {
        now.add_motion(&mut frame.picture, before.as_ref(), after.as_ref());
    }
    Ok(frame)
}

/// As planned; a default filter is skipped if there are many samples.
fn take_noise_out(frame: &mut Frame, plan: &Plan, pool: &ThreadPool, messages: Messages) -> Outcome {
    // After a stop the user should not wait for a default filter.
    let is_welcome = frame.stats.spp_max < FEW_SAMPLES && !signals::is_stopped();
    let is_needed = |filter: &&Filter| !filter.is_default || is_welcome;
    let Some(filter) = plan.filter.as_ref().filter(is_needed) else { return Ok(()) };
    let used = denoise(&mut frame.picture, &filter.options, pool).map_err(Failure::data)?;
    filter.report(&used, &mut frame.picture, messages);
    Ok(())
}

impl Filter {
    /// Says what has taken the noise out, once, and notes it in the picture.
    pub(super) fn report(&self, used: &denoise::Used, picture: &mut Picture, messages: Messages) {
        if self.is_reported.replace(true) {
            messages.detail(used);
        } else if self.is_default {
            messages.note(format_args!(
                "{used}, for there are fewer than {FEW_SAMPLES} samples; --denoise=none leaves it"
            ));
        } else {
            messages.note(used);
        }
        picture.set_metadata("denoiser", used.name());
    }
}

/// Metadata of its file.
pub(super) fn label(
    picture: &mut Picture,
    stats: Option<&RenderStats>,
    plan: &Plan,
    ready: &Ready,
    options: &RenderOptions,
) {
    describe(picture, options);
    if let Some(scene) = &ready.named {
        mattes::describe(picture, scene);
    }
    if plan.targets.picture.has_layers() {
        let aspect = options.width as f32 / options.height as f32;
        describe_making(picture, &ready.chosen.camera, aspect, stats);
    }
}

/// Appearance of its file.
pub(super) fn appear(
    picture: &mut Picture,
    (arguments, plan): (&RenderArguments, &Plan),
    ready: &Ready,
    options: &RenderOptions,
) {
    // Pieces keep the numbers of their space, for the filter.
    if options.piece.is_none() {
        picture.convert_from(ready.world.space());
    }
    // Pieces have all layers; the list is applied to their picture.
    let chooses = plan.targets.picture.has_layers() && options.piece.is_none();
    if let Some(layers) = ready.list.as_ref().filter(|_| chooses) {
        layers.apply(picture, &options.light_layers);
    }
    if options.piece.is_none() && !ready.list.as_ref().is_some_and(LayerList::has_seen) {
        drop_seen(picture);
    }
    if arguments.transparent && !plan.targets.picture.has_layers() {
        picture.drop_background();
    } else if !plan.targets.picture.has_layers() {
        // On a screen the background is part of the picture: only pixels outside the crop stay transparent.
        picture.make_opaque(options.crop);
    }
}

/// Prints statistics, if requested.
pub(super) fn report(
    arguments: &RenderArguments,
    begin: Instant,
    plan: &Plan,
    ready: &Ready,
    options: &RenderOptions,
    stats: &RenderStats,
    messages: Messages,
) -> Outcome {
    let statistics = Statistics {
        scene: plan.source.name(),
        picture: plan.targets.picture.path(),
        options,
        world: ready.world.stats(),
        report: ready.report.clone(),
        render: stats,
        load_seconds: ready.load_time.as_secs_f64(),
        total_seconds: begin.elapsed().as_secs_f64(),
    };
    match arguments.stats {
        Some(StatisticsForm::Json) => print(statistics.to_json()),
        Some(StatisticsForm::Table) => {
            messages.table(statistics);
            Ok(())
        }
        None => Ok(()),
    }
}

/// Everything that can be rejected before any work.
pub(super) fn check(arguments: &RenderArguments, environment: &Environment) -> Result<Plan, Failure> {
    view::check(&arguments.view)?;
    shaders::check(&arguments.frame, &arguments.view)?;
    pieces::check(arguments)?;
    band_rows::check(arguments)?;
    let resolution = arguments.frame.resolution;
    if let Some(crop) = arguments.crop.filter(|crop| crop.within(resolution).is_none()) {
        return Err(Failure::usage(format_args!(
            "--crop '{crop}': no pixel of the {resolution} picture is in it; give x0,y0,x1,y1 with x0 < x1 and y0 < y1"
        )));
    }
    let given = arguments.output.as_deref().map(Output::named).transpose()?;
    let heatmap = arguments.heatmap.as_deref().map(Output::named).transpose()?;
    let source = Source::find(&arguments.scene, &arguments.files, environment)?;
    arguments.times.check(source.numbered().is_some(), arguments.checkpoint.is_some())?;
    let is_sequence = arguments.times.frames.is_some();
    let picture = given.map_or_else(|| Output::named(&source.picture_name(is_sequence)), Ok)?;
    let picture = picture.through(&arguments.ocio)?;
    if is_sequence {
        for (option, output) in [("--output", Some(&picture)), ("--heatmap", heatmap.as_ref())] {
            if let Some(output) = output.filter(|output| output.numbered().is_none()) {
                return Err(Failure::usage(format_args!(
                    "{option} {}: --frames makes more than one; mark the number by #, as in frame.####.png",
                    output.path().display()
                )));
            }
        }
    }
    if arguments.transparent && !picture.has_opacity() {
        return Err(Failure::usage(format_args!(
            "--transparent: {} has no opacity; give a .png or .exr",
            picture.path().display()
        )));
    }
    let needs_layers = [("--layers", arguments.layers.is_some()), ("--light-groups", arguments.light_groups)];
    if let Some((option, _)) = needs_layers.into_iter().find(|&(_, given)| given && !picture.has_layers()) {
        return Err(Failure::usage(format_args!(
            "{option}: {} has no layers; give an .exr",
            picture.path().display()
        )));
    }
    let integrator = arguments.frame.integrator;
    if arguments.light_groups && integrator.without_pilot() != Integrator::Path {
        return Err(Failure::usage(format_args!(
            "--light-groups: unsupported with --integrator {integrator}; give --integrator path"
        )));
    }
    let mut of_light = arguments.layers.iter().flat_map(|layers| &layers.light);
    if let Some(layer) = of_light.find(|layer| !integrator.has_light_layer(layer)) {
        let known = if integrator.has_virtual_lights() {
            "; it has emission, environment, direct, indirect, colours and outputs of shaders"
        } else {
            ""
        };
        return Err(Failure::usage(format_args!(
            "--layers: the layer of light '{}' is unsupported with --integrator {integrator}; give --integrator path{known}",
            layer.name
        )));
    }
    if heatmap.as_ref().is_some_and(|heatmap| is_same_file(heatmap.path(), picture.path())) {
        return Err(Failure::usage("--heatmap and --output are the same file; give two"));
    }
    if let Some(checkpoint) = &arguments.checkpoint {
        if [Some(&picture), heatmap.as_ref()]
            .into_iter()
            .flatten()
            .any(|o| is_same_file(o.path(), checkpoint))
        {
            return Err(Failure::usage("--checkpoint is the file of a picture; give another"));
        }
        gnurt::image::check_writable(checkpoint).map_err(Failure::data)?;
    }
    if arguments.frame.noise.is_some() && arguments.frame.integrator.has_virtual_lights() {
        return Err(Failure::usage(format_args!(
            "--noise is unsupported with --integrator {}: its pixels share their noise; give --spp or --time",
            arguments.frame.integrator
        )));
    }
    if let Some(how) = arguments.denoiser.options(None) {
        denoise::check(&how).map_err(Failure::data)?;
    }
    picture.check()?;
    heatmap.iter().try_for_each(Output::check)?;
    let targets = Targets { picture, heatmap };
    let filter = filter(arguments, &targets);
    let band_rows = band_rows::rows(arguments, &targets.picture)?;
    let mut plan = Plan { source, targets, filter, band_rows };
    let fits = |plan: &Plan| check_memory(&options(arguments, plan, Level::default()), plan.filter.is_some());
    if plan.filter.as_ref().is_some_and(|filter| filter.is_default) && fits(&plan).is_err() {
        // A default must not cause a failure for lack of memory.
        plan.filter = None;
    }
    fits(&plan).map_err(|why| {
        let remedy = if plan.band_rows.is_some() {
            "fewer rows"
        } else {
            "--band-rows, which takes memory for some rows"
        };
        Failure::data(format_args!("--resolution {resolution}: {why}, or give {remedy}"))
    })?;
    Ok(plan)
}

/// The denoiser, if requested, or if the picture is for screens and may have few samples.
fn filter(arguments: &RenderArguments, targets: &Targets) -> Option<Filter> {
    let crop = arguments.crop.and_then(|crop| crop.within(arguments.frame.resolution));
    if let Some(options) = arguments.denoiser.options(crop) {
        return Some(Filter { options, is_default: false, is_reported: Cell::default() });
    }
    let FrameArguments { integrator, spp, .. } = arguments.frame;
    // A rendering that ends early has fewer samples; one that is continued must look the same all the time.
    let may_be_few = spp < FEW_SAMPLES || arguments.time.is_some() || arguments.checkpoint.is_some();
    let is_default = arguments.denoiser.is_left_open()
        && arguments.band_rows.is_none()
        && targets.picture.is_for_screens()
        && is_noisy(integrator, 1)
        && may_be_few;
    let options = arguments.denoiser.options_or_built_in(crop);
    options.filter(|_| is_default).map(|options| Filter { options, is_default, is_reported: Cell::default() })
}

/// How the scene is to be made ready for rays.
pub(super) fn commit_options(frame: &FrameArguments, trees: &TreeArguments, level: Level) -> CommitOptions {
    CommitOptions {
        force_diffuse: frame.force_diffuse,
        level,
        memory: trees.memory,
        space: frame.working_space,
        ..CommitOptions::default()
    }
}

/// Computes the fingerprint of the scene's picture with this shutter, if it is needed; and opens the
/// checkpoint, if requested.
pub(super) fn identify(
    arguments: &RenderArguments,
    scene: &Scene,
    chosen: &Chosen,
    open: &dyn Debug,
    options: &RenderOptions,
) -> (u64, Option<Checkpoint>) {
    if arguments.checkpoint.is_none() && arguments.piece.is_none() {
        return (0, None);
    }
    let space = arguments.frame.working_space;
    let shown = (&chosen.camera, shaders::print(&arguments.frame, &arguments.view), open, space);
    let print = fingerprint(scene, arguments.frame.force_diffuse, &shown, options);
    let checkpoint = arguments.checkpoint.as_deref().map(|path| {
        // Each piece continues its own.
        let of_piece =
            options.piece.map_or(0, |Piece { index, count }| u64::from(index) << 32 | u64::from(count));
        Checkpoint::new(path, print ^ of_piece, arguments.checkpoint_every)
    });
    (print, checkpoint)
}

/// Builds the trees, and reports dropped elements.
pub(super) fn commit(
    scene: &Scene,
    shaders: &ShaderTable,
    options: CommitOptions,
    pool: &ThreadPool,
    messages: Messages,
) -> Result<(World, CommitReport), Failure> {
    let mut world = World::new();
    let report = commit_into(&mut world, (scene, &Exposure::default()), shaders, options, pool, messages)?;
    Ok((world, report))
}

/// The same for a world that may have a commit of the scene, and for motion during an open shutter.
pub(super) fn commit_into(
    world: &mut World,
    (scene, exposure): (&Scene, &Exposure),
    shaders: &ShaderTable,
    options: CommitOptions,
    pool: &ThreadPool,
    messages: Messages,
) -> Result<CommitReport, Failure> {
    let report = world.commit_exposed(scene, exposure, shaders, &options, pool).map_err(Failure::data)?;
    report.warnings.iter().for_each(|line| messages.warning(line));
    if report.dropped_triangles > 0 {
        messages
            .warning(format_args!("{} triangles without a finite area left out", report.dropped_triangles));
    }
    if report.dropped_instances > 0 {
        messages.warning(format_args!(
            "{} instances whose transform has no inverse left out",
            report.dropped_instances
        ));
    }
    // A scene without any triangle was warned about when it was read.
    let has_triangles = scene.meshes().iter().any(|mesh| mesh.primitive_count() > 0);
    if world.bounds().is_none() && has_triangles {
        messages.warning("no visible triangle is left: the picture shows only the background");
    }
    let stats = world.stats();
    messages.detail(format_args!(
        "{} triangles in {} objects, {} instances: trees of {} nodes, {}, in {:.2} s",
        stats.triangles,
        stats.objects,
        stats.instances,
        stats.tree_nodes,
        format_bytes(stats.tree_bytes as u64),
        report.build_seconds
    ));
    Ok(report)
}

pub(super) fn options(arguments: &RenderArguments, plan: &Plan, level: Level) -> RenderOptions {
    RenderOptions {
        crop: arguments.crop.and_then(|crop| crop.within(arguments.frame.resolution)),
        time_limit: arguments.time,
        aovs: plan.targets.picture.has_layers() || plan.filter.is_some() || arguments.transparent,
        // A filter is chosen when pieces are joined.
        seen: plan.filter.is_some()
            || arguments.piece.is_some()
            || arguments.layers.as_ref().is_some_and(LayerList::has_seen),
        heatmap: plan.targets.heatmap.is_some(),
        piece: arguments.piece,
        // The first band stands for all until each gets its own.
        rows: plan.band_rows.map(|rows| [0, rows.min(arguments.frame.resolution.height)]),
        light_layers: arguments.layers.iter().flat_map(|layers| layers.light.clone()).collect(),
        mattes: Mattes {
            kinds: arguments.layers.iter().flat_map(|layers| layers.mattes.clone()).collect(),
            depth: arguments.crypto_depth,
        },
        ..frame_options(&arguments.frame, level)
    }
}

/// The part of the options that `trace` shares.
pub(super) fn frame_options(frame: &FrameArguments, level: Level) -> RenderOptions {
    RenderOptions {
        width: frame.resolution.width,
        height: frame.resolution.height,
        spp: frame.spp,
        seed: frame.seed,
        integrator: frame.integrator,
        filter: frame.filter,
        pixel_noise: frame.pixel_noise,
        max_depth: frame.max_depth,
        vpls: frame.vpls,
        clamp: frame.clamp,
        guiding: frame.guide,
        caustics: frame.caustics,
        noise: frame.noise,
        interleave: frame.interleave,
        level,
        ..RenderOptions::default()
    }
}

/// Warnings and notes about the picture.
fn tell(stats: &RenderStats, arguments: &RenderArguments, messages: Messages) {
    if stats.bad_samples > 0 {
        messages
            .warning(format_args!("{} samples that were NaN or infinite became black", stats.bad_samples));
    }
    if !stats.complete {
        let reason = if signals::is_stopped() { "stopped by a signal" } else { "the time is up" };
        messages.note(format_args!(
            "{reason}: {} to {} of {} samples per pixel were taken",
            stats.spp_min, stats.spp_max, arguments.frame.spp
        ));
    }
    let million_rays = stats.rays() as f64 * 1e-6;
    messages.detail(format_args!(
        "{million_rays:.2} million rays in {:.2} s on {} threads: {:.2} million per second",
        stats.seconds,
        stats.threads,
        million_rays / stats.seconds.max(1e-9)
    ));
    if let Some(choice) = &stats.choice {
        messages.detail(format_args!("integrator: {choice}"));
    }
    if let Some(guide) = &stats.guide {
        messages.detail(format_args!("guide: {guide}"));
    }
    messages.trace(format_args!(
        "{} nodes visited, {} triangles tested",
        stats.nodes_visited, stats.triangles_tested
    ));
}

/// Curve, exposure and precision of the picture's file, as far as they are known without the picture.
pub(super) fn suited_light(
    arguments: &RenderArguments,
    ready: &Ready,
    options: &RenderOptions,
) -> LightArguments {
    let known = ready.chosen.exposure_of(arguments.frame.integrator);
    let mut light = ready.light.unwrap_or(arguments.light).suited(known);
    if !options.light_layers.is_empty() {
        // Parts have 32 bits, and so has their sum.
        light.file.exact();
    }
    light
}

pub(super) fn save(
    frame: &Frame,
    targets: &Targets,
    ready: &Ready,
    arguments: &RenderArguments,
    options: &RenderOptions,
    messages: Messages,
) -> Outcome {
    let light = suited_light(arguments, ready, options);
    match options.piece {
        Some(piece) => {
            let layers = ready.list.as_ref().map(|layers| &layers.text[..]);
            pieces::save(
                frame,
                piece,
                (ready.print, layers, ready.world.space()),
                light,
                options,
                &targets.picture,
            )?;
        }
        None => targets.picture.write_with(&frame.picture, light, messages)?,
    }
    let wrote = format!("wrote {}", targets.picture.path().display());
    match &arguments.output {
        Some(_) => messages.detail(wrote),
        // The name is a default.
        None => messages.note(wrote),
    }
    if let (Some(target), Some(heatmap)) = (&targets.heatmap, &frame.heatmap) {
        // Its colours are no light.
        target.write(heatmap, DisplayOptions::default())?;
        messages.detail(format_args!("wrote {}", target.path().display()));
    }
    Ok(())
}
