// SPDX-License-Identifier: GPL-3.0-or-later
//! `gnurt render SCENE`: from a scene to a picture.
//! Source: original; the order of checks is the contract of the command line: arguments, the scene's path, the output's
//! folder and the memory that the picture takes come before any work. Proof: `tests/`.

use std::time::Instant;

use gnurt::ThreadPool;
use gnurt::denoise::{self, denoise};
use gnurt::image::Picture;
use gnurt::render::{
    Accumulation, CommitOptions, CommitReport, Frame, RenderOptions, ShaderTable, World, fingerprint,
    render_on,
};
use gnurt::scene::Scene;
use gnurt::simd::Level;
use gnurt_view::TevImage;

use crate::arguments::{FrameArguments, RenderArguments, StatisticsForm, TreeArguments};
use crate::checkpoint::Checkpoint;
use crate::display::Displayed;
use crate::environment::Environment;
use crate::failure::{Failure, Outcome};
use crate::machine::{bytes, free_memory};
use crate::messages::{Messages, print};
use crate::output::{Output, is_same_file};
use crate::picture_header::{describe, describe_making};
use crate::progress::Watcher;
use crate::shaders::{self, Shaders};
use crate::signals::{self, FirstSignal};
use crate::source::Source;
use crate::statistics::Statistics;
use crate::view;
use crate::workers::machine;

/// What is written at the end.
struct Targets {
    picture: Output,
    heatmap: Option<Output>,
}

/// Renders.
pub(crate) fn run(arguments: &RenderArguments, environment: &Environment, messages: Messages) -> Outcome {
    let begin = Instant::now();
    let (source, targets) = check(arguments, environment)?;
    signals::listen(FirstSignal::Saves, messages)?;
    let (pool, level) = machine(&arguments.machine, environment)?;

    let mut scene = source.load(messages)?;
    let (camera, rays) = view::choose(&mut scene, &arguments.view, arguments.frame.resolution, messages)?;
    let loaded = begin.elapsed();
    let shaders = Shaders::put_into(&mut scene, &arguments.frame.shaders)?;
    let how = commit_options(&arguments.frame, &arguments.trees, level);
    let (world, report) = commit(&scene, &shaders.table, how, &pool, messages)?;

    let options = options(arguments, &targets, level);
    let checkpoint = arguments.checkpoint.as_deref().map(|path| {
        let shown = (&rays, shaders::print(&arguments.frame.shaders));
        let print = fingerprint(&scene, arguments.frame.force_diffuse, &shown, &options);
        Checkpoint::new(path, print, arguments.checkpoint_every)
    });
    drop(scene);
    let begun = match &checkpoint {
        Some(checkpoint) => checkpoint.begin(&options, messages)?,
        None => Accumulation::new(options.clone()).map_err(Failure::usage)?,
    };
    let size = [options.width, options.height];
    let tev = arguments.display.as_ref().map(|address| TevImage::create(address, &source.name(), size));
    let tev = tev.transpose().map_err(Failure::data)?;
    let watcher = Watcher::begin(messages.shows_progress());
    let displayed = Displayed::new(&watcher, tev);
    let every = checkpoint.as_ref().map(|checkpoint| checkpoint.every);
    let mut saved = Ok(());
    let mut frame = render_on(begun, &world, &rays, &pool, &displayed, every, &mut |picture| {
        if let Some(checkpoint) = &checkpoint {
            saved = checkpoint.save(picture);
        }
    });
    let lost = displayed.end();
    watcher.end();
    if let Some(why) = lost {
        messages.warning(format_args!("the picture is no longer shown: {why}"));
    }
    saved?;
    tell(&frame, arguments, messages);
    shaders.tell_faults(messages);
    if let Some(how) = arguments.denoiser.options(options.crop) {
        let used = denoise(&mut frame.picture, &how, &pool).map_err(Failure::data)?;
        messages.note(&used);
        frame.picture.set_metadata("denoiser", used.name());
    }

    if !targets.picture.has_layers() {
        make_opaque(&mut frame.picture, options.crop);
    }
    describe(&mut frame.picture, &arguments.frame);
    if targets.picture.has_layers() {
        let aspect = options.width as f32 / options.height as f32;
        describe_making(&mut frame.picture, &camera, aspect, &frame.stats);
    }
    save(&frame, &targets, arguments, messages)?;

    let statistics = Statistics {
        scene: source.name(),
        picture: targets.picture.path(),
        options: &options,
        world: world.stats(),
        report,
        render: &frame.stats,
        load_seconds: loaded.as_secs_f64(),
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

/// Everything that can be refused before any work.
fn check(arguments: &RenderArguments, environment: &Environment) -> Result<(Source, Targets), Failure> {
    view::check(&arguments.view)?;
    shaders::check(&arguments.frame.shaders)?;
    let resolution = arguments.frame.resolution;
    if let Some(crop) = arguments.crop.filter(|crop| crop.within(resolution).is_none()) {
        return Err(Failure::usage(format_args!(
            "--crop '{crop}': no pixel of the {resolution} picture is in it; give x0,y0,x1,y1 with x0 < x1 and y0 < y1"
        )));
    }
    let given = arguments.output.as_deref().map(Output::named).transpose()?;
    let heatmap = arguments.heatmap.as_deref().map(Output::named).transpose()?;
    let source = Source::find(&arguments.scene, &arguments.files, environment)?;
    let picture = given.map_or_else(|| Output::named(&source.picture_name()), Ok)?;
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
            "--noise does not go with --integrator {}: its pixels share their noise; give --spp or --time",
            arguments.frame.integrator
        )));
    }
    if let Some(how) = arguments.denoiser.options(None) {
        denoise::check(&how).map_err(Failure::data)?;
    }
    picture.check()?;
    heatmap.iter().try_for_each(Output::check)?;
    let targets = Targets { picture, heatmap };
    check_memory(arguments, &targets)?;
    Ok((source, targets))
}

/// Whether the picture can fit into what the machine has left.
fn check_memory(arguments: &RenderArguments, targets: &Targets) -> Outcome {
    /// Colours, the sums they are made from, and the file's bytes.
    const PER_PIXEL: u64 = 64;
    /// Albedo, normal, position, depth and ids, and their bytes in the file.
    const LAYERS_PER_PIXEL: u64 = 192;
    /// Costs and their colours.
    const HEAT_PER_PIXEL: u64 = 40;
    let resolution = arguments.frame.resolution;
    /// What a denoiser makes of them.
    const CLEAN_PER_PIXEL: u64 = 160;
    let layers = if needs_layers(arguments, targets) { LAYERS_PER_PIXEL } else { 0 };
    let clean = if arguments.denoiser.denoise.is_some() { CLEAN_PER_PIXEL } else { 0 };
    let heat = if targets.heatmap.is_some() { HEAT_PER_PIXEL } else { 0 };
    let needed =
        u64::from(resolution.width) * u64::from(resolution.height) * (PER_PIXEL + layers + clean + heat);
    match free_memory().filter(|&free| needed > free) {
        Some(free) => Err(Failure::data(format_args!(
            "--resolution {resolution}: the picture takes {} of memory and {} are free; ask for a smaller one",
            bytes(needed),
            bytes(free)
        ))),
        None => Ok(()),
    }
}

/// How the scene is to be made ready for rays.
pub(super) fn commit_options(frame: &FrameArguments, trees: &TreeArguments, level: Level) -> CommitOptions {
    CommitOptions { force_diffuse: frame.force_diffuse, level, memory: trees.memory }
}

/// Builds the trees, and tells what had to be left out.
pub(super) fn commit(
    scene: &Scene,
    shaders: &ShaderTable,
    options: CommitOptions,
    pool: &ThreadPool,
    messages: Messages,
) -> Result<(World, CommitReport), Failure> {
    let mut world = World::new();
    let report = world.commit(scene, shaders, &options, pool).map_err(Failure::data)?;
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
    let has_triangles = scene.meshes().iter().any(|mesh| !mesh.indices.is_empty());
    if world.bounds().is_none() && has_triangles {
        messages.warning("no triangle is left to be seen: only the background is");
    }
    let stats = world.stats();
    messages.detail(format_args!(
        "{} triangles in {} objects, {} instances: trees of {} nodes, {}, in {:.2} s",
        stats.triangles,
        stats.objects,
        stats.instances,
        stats.tree_nodes,
        bytes(stats.tree_bytes as u64),
        report.build_seconds
    ));
    Ok((world, report))
}

fn needs_layers(arguments: &RenderArguments, targets: &Targets) -> bool {
    targets.picture.has_layers() || arguments.denoiser.denoise.is_some()
}

fn options(arguments: &RenderArguments, targets: &Targets, level: Level) -> RenderOptions {
    RenderOptions {
        crop: arguments.crop.and_then(|crop| crop.within(arguments.frame.resolution)),
        time_limit: arguments.time,
        aovs: needs_layers(arguments, targets),
        heatmap: targets.heatmap.is_some(),
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
        max_depth: frame.max_depth,
        vpls: frame.vpls,
        clamp: frame.clamp,
        noise: frame.noise,
        interleave: frame.interleave,
        level,
        ..RenderOptions::default()
    }
}

/// What people should know about the picture.
fn tell(frame: &Frame, arguments: &RenderArguments, messages: Messages) {
    let stats = &frame.stats;
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
    messages.trace(format_args!(
        "{} nodes visited, {} triangles tested",
        stats.nodes_visited, stats.triangles_tested
    ));
}

/// On a screen the background is part of the picture: only what lies outside the crop stays transparent.
fn make_opaque(picture: &mut Picture, crop: Option<[u32; 4]>) {
    let [x0, y0, x1, y1] = crop.unwrap_or([0, 0, picture.width, picture.height]);
    let rows = picture.color.chunks_exact_mut(picture.width as usize);
    for row in rows.take(y1 as usize).skip(y0 as usize) {
        row[x0 as usize..x1 as usize].iter_mut().for_each(|pixel| pixel[3] = 1.0);
    }
}

fn save(frame: &Frame, targets: &Targets, arguments: &RenderArguments, messages: Messages) -> Outcome {
    targets.picture.write(&frame.picture, arguments.light)?;
    messages.detail(format_args!("wrote {}", targets.picture.path().display()));
    if let (Some(target), Some(heatmap)) = (&targets.heatmap, &frame.heatmap) {
        target.write(heatmap, crate::arguments::LightArguments::default())?;
        messages.detail(format_args!("wrote {}", target.path().display()));
    }
    Ok(())
}
