// SPDX-License-Identifier: GPL-3.0-or-later
//! Defaults of display: curve and exposure, and the choice of pictures to denoise. The curve is
//! [`ToneCurve::Filmic`] (Nar15), the exposure that of [`exposure_for`] (Rei03). Of these, only a requested
//! filter applies to files of floats.
//! Tests: `tests`, and the command line's `tests/program/display.rs`.

use crate::image::{ToneCurve, exposure_for};
use crate::render::{Integrator, Mattes, RenderError, RenderOptions, Silent, World, render};
use crate::shading::CameraShader;

/// The curve that pictures for screens get.
pub const TONE: ToneCurve = ToneCurve::Filmic;

/// Pictures of fewer samples per pixel than this are noisy enough for a filter to make them better rather than softer.
pub const FEW_SAMPLES: u32 = 256;

/// Whether to denoise a picture for a screen: integrators with random light samples, with few samples.
#[must_use]
pub fn is_noisy(integrator: Integrator, samples: u32) -> bool {
    (integrator.without_pilot() == Integrator::Path || integrator.has_virtual_lights())
        && samples < FEW_SAMPLES
}

/// Columns or rows, the larger of the two, of a picture that is only measured.
const METERED: u32 = 96;
/// Its samples per pixel.
const METERED_SAMPLES: u32 = 4;

/// The exposure in stops for a camera's view, for callers that show more than one picture, or need it before
/// the first: a small picture is rendered and measured. A sequence of frames calls it once, so that its light
/// stays constant.
///
/// # Errors
/// [`RenderError`] if the options leave nothing to render.
pub fn meter(
    world: &World,
    camera: &dyn CameraShader,
    options: &RenderOptions,
    pool: &rayon::ThreadPool,
) -> Result<f32, RenderError> {
    let longest = options.width.max(options.height).max(1);
    let side = |pixels: u32| {
        if longest <= METERED {
            pixels
        } else {
            (u64::from(pixels) * u64::from(METERED)).div_ceil(u64::from(longest)) as u32
        }
    };
    let small = RenderOptions {
        width: side(options.width),
        height: side(options.height),
        spp: METERED_SAMPLES,
        // Frames under seeds of their own have one exposure.
        seed: 0,
        crop: None,
        noise: None,
        interleave: 1,
        aovs: false,
        light_layers: Vec::new(),
        mattes: Mattes::default(),
        heatmap: false,
        piece: None,
        time_limit: None,
        vpls: options.vpls.min(256),
        ..options.clone()
    };
    let mut picture = render(world, camera, &small, pool, &Silent)?.picture;
    picture.convert_from(world.space());
    Ok(exposure_for(&picture))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::{CommitOptions, SceneCamera, ShaderTable};

    #[test]
    fn few_samples_of_random_light_are_noisy() {
        assert!(is_noisy(Integrator::Path, 16) && is_noisy(Integrator::InstantRadiosity, 1), "few");
        assert!(!is_noisy(Integrator::Path, FEW_SAMPLES), "enough");
        assert!(
            !is_noisy(Integrator::Eyelight, 1) && !is_noisy(Integrator::Whitted, 1),
            "no light at random"
        );
    }

    #[test]
    fn a_small_picture_tells_the_exposure() {
        let mut scene = crate::load_scene("builtin:cornell").expect("built in").scene;
        crate::defaults::complete(&mut scene, 1.0);
        let pool = crate::thread_pool(2).expect("threads");
        let mut world = World::new();
        let how = CommitOptions::default();
        world.commit(&scene, &ShaderTable::default(), &how, &pool).expect("nothing is missing");
        let camera = SceneCamera::new(&scene.cameras()[0]).expect("a view");
        let options = RenderOptions {
            width: 128,
            height: 96,
            spp: 16,
            integrator: Integrator::Path,
            ..RenderOptions::default()
        };
        let metered = meter(&world, &camera, &options, &pool).expect("sound options");
        let picture = render(&world, &camera, &options, &pool, &Silent).expect("sound options").picture;
        assert!((metered - exposure_for(&picture)).abs() < 0.25, "{metered} and {}", exposure_for(&picture));
        let nothing = RenderOptions { width: 0, ..options };
        assert!(meter(&world, &camera, &nothing, &pool).is_err(), "no pixels");
    }
}
