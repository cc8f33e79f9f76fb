// SPDX-License-Identifier: GPL-3.0-or-later
//! `gnurt bench light`: errors of integrators over samples and time. See `gnurt_bench::light`.
//! Tests: `tests/program/bench.rs`.

use std::path::Path;

use gnurt::image::{self, ExrPixels, WriteOptions};
use gnurt::render::{CommitOptions, RenderOptions, ShaderTable, World};
use gnurt::shading::CameraShader;
use gnurt_bench::light::{self, Truth};
use gnurt_bench::light_plot;

use super::bench_files::{check_outputs, write};
use super::frame::commit;
use crate::arguments::BenchLightArguments;
use crate::environment::Environment;
use crate::failure::{Failure, Outcome};
use crate::messages::{Messages, print};
use crate::source::Source;
use crate::view::{self, Stage};
use crate::workers::machine;

/// Measures.
pub(crate) fn run(arguments: &BenchLightArguments, environment: &Environment, messages: Messages) -> Outcome {
    view::check(&arguments.view)?;
    check_outputs(&[&arguments.csv, &arguments.svg, &arguments.truth])?;
    let source = Source::find(&arguments.scene, &arguments.files, environment)?;
    let (pool, level) = machine(&arguments.machine, environment)?;
    let mut scene = source.load(messages)?;
    let view::Chosen { rays: camera, .. } = view::choose(
        &mut scene,
        &ShaderTable::default(),
        &arguments.view,
        arguments.resolution,
        Stage::Plain,
        messages,
    )?;
    let how = CommitOptions { force_diffuse: arguments.force_diffuse, level, ..CommitOptions::default() };
    let (world, _) = commit(&scene, &ShaderTable::default(), how, &pool, messages)?;
    let picture = RenderOptions {
        width: arguments.resolution.width,
        height: arguments.resolution.height,
        max_depth: arguments.max_depth,
        vpls: arguments.vpls,
        clamp: arguments.clamp,
        guiding: arguments.guide,
        caustics: arguments.caustics,
        level,
        ..RenderOptions::default()
    };
    let truth = truth(arguments, &world, &*camera, &picture, &pool, messages)?;
    let seconds = arguments.time.as_secs_f64();
    let options = light::Options {
        integrators: arguments.integrators.clone(),
        picture,
        seconds,
        seeds: arguments.rounds as u64,
        separate_lights: arguments.separate_lights,
    };
    let mut retained = Ok(());
    let mut keep = |point: &light::Point, picture: &image::Picture| {
        messages.detail(format_args!(
            "{} {}: {} samples, {:.2} s, relMSE {:.6}, mean {:+.4}",
            point.integrator, point.seed, point.samples, point.seconds, point.rel_mse, point.mean_error
        ));
        if let Some(folder) = arguments.pictures.as_deref().filter(|_| point.seed == 0 && retained.is_ok()) {
            let file = folder.join(format!("{}.exr", point.integrator));
            retained = image::write(picture, &file, &WriteOptions::default()).map_err(Failure::data);
        }
    };
    let points = light::run(&world, &*camera, &options, &truth, &pool, &mut keep).map_err(Failure::usage)?;
    retained?;
    let name = source.stem();
    write(arguments.csv.as_deref(), || light::csv(&name, &points))?;
    write(arguments.svg.as_deref(), || light_plot::svg(&name, &points))?;
    messages.detail(format_args!(
        "the means of both reference pictures differ by {:.3} %",
        100.0 * truth.doubt()
    ));
    print(light::table(&light::summaries(&points, seconds)).trim_end())
}

/// The truth: from existing files, else rendered, and stored if a file is named.
fn truth(
    arguments: &BenchLightArguments,
    world: &World,
    camera: &dyn CameraShader,
    options: &RenderOptions,
    pool: &gnurt::ThreadPool,
    messages: Messages,
) -> Result<Truth, Failure> {
    let files = arguments.truth.as_deref().map(|first| [first.to_owned(), second(first)]);
    if let Some([first, second]) = files.as_ref().filter(|files| files.iter().all(|file| file.exists())) {
        let read = |file: &Path| image::read(file).map_err(Failure::data);
        let pictures = [read(first)?, read(second)?];
        let fits = pictures.iter().all(|p| (p.width, p.height) == (options.width, options.height));
        let no_truth = || {
            let (file, size) = (first.display(), arguments.resolution);
            Failure::data(format_args!(
                "{file}: both reference pictures must be {size}, the size of --resolution"
            ))
        };
        return Truth::new(pictures).filter(|_| fits).ok_or_else(no_truth);
    }
    messages.detail(format_args!("two pictures by paths, {} samples per pixel each", arguments.truth_spp));
    let truth = Truth::by_paths(world, camera, options, arguments.truth_spp, pool).map_err(Failure::usage)?;
    // The file is read back as it was rendered, bit for bit.
    let how = WriteOptions { exr_pixels: ExrPixels::Float, ..WriteOptions::default() };
    for (file, picture) in files.iter().flatten().zip(truth.pictures()) {
        image::write(picture, file, &how).map_err(Failure::data)?;
    }
    Ok(truth)
}

/// The name of the second picture.
fn second(first: &Path) -> std::path::PathBuf {
    let mut name = first.file_stem().unwrap_or_default().to_owned();
    name.push("2");
    first.with_file_name(name).with_extension(first.extension().unwrap_or_default())
}
