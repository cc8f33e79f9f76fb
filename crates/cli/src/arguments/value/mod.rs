// SPDX-License-Identifier: GPL-3.0-or-later
//! Values of options: from text to numbers, vectors, names. Each error lists the valid values. See
//! docs/reference/cli.md.
//! Invariant: no value leaves here that is NaN, infinite or out of its range. Tests: `tests`, also in the files below.

#[cfg(feature = "bench")]
mod bench;
mod display_values;
mod eye;
mod frame;
mod gain;
mod layers;
mod moment;
mod plain;
mod sampling;
mod shader;
mod usd;

#[cfg(feature = "bench")]
pub(crate) use bench::{batch, characters, columns, engine, instances, motion_case, ray_class, rounds};
pub(crate) use display_values::{
    DenoiserChoice, ExposureChoice, bits, compression, denoiser, display, exposure, filter, quality,
    tile_size, tone, working_space,
};
pub(crate) use eye::{angle_of_view, aperture, direction, length, point, projection, shift, turn};
pub(crate) use frame::{Crop, Pixel, Resolution, crop, piece, pixel, resolution};
pub(crate) use gain::gain;
pub(crate) use layers::layers;
pub(crate) use moment::{FrameRange, frames, frames_per_second, seconds, shutter, time};
pub(crate) use sampling::{
    caustics, clamp, depth, guide, integrator, interleave, isa, mebibytes, memory, noise, pixel_noise,
    samples, seed, threads, tolerance, virtual_lights,
};
pub(crate) use shader::{CameraChoice, ShaderChoice, camera, pixel_shader, shader, surroundings};
pub(crate) use usd::{subdivision, up_axis, variant};

#[cfg(test)]
mod tests {
    use super::*;
    use gnurt::render::Integrator;

    #[test]
    fn numbers_are_finite_and_in_range() {
        assert_eq!(point("-0.5,1,3e0"), Ok([-0.5, 1.0, 3.0]), "a point");
        for bad in ["1,2", "1,2,3,4", "nan,0,0", "inf,0,0", "1e99,0,0", "1,,2", "1;2;3", ""] {
            assert!(point(bad).is_err(), "'{bad}' is no point");
        }
        assert!(direction("0,0,-0").is_err(), "no direction");
        for bad in ["0", "-5", "361", "nan", "1e-9"] {
            assert!(angle_of_view(bad).is_err(), "'{bad}' is no angle of view");
        }
        assert_eq!(samples("2147483647"), Ok(2_147_483_647), "the most samples");
        assert!(
            samples("2147483648").is_err() && samples("0").is_err() && samples("-1").is_err(),
            "out of range"
        );
        assert_eq!(seed("18446744073709551615"), Ok(u64::MAX), "the largest seed");
        assert!(seed("18446744073709551616").is_err(), "beyond it");
        assert!(mebibytes("-3").expect_err("no memory").contains("from 1 to 16777216"), "memory");
        assert_eq!(threads("1024"), Ok(1024), "the most threads");
        assert!(threads("1025").is_err(), "more than that");
        assert!(
            tolerance("nan").is_err() && tolerance("-1").is_err() && tolerance("0.5").is_ok(),
            "tolerances"
        );
        assert!(exposure("-3").is_ok() && exposure("65").is_err(), "stops");
    }

    #[test]
    fn names_are_suggested() {
        assert_eq!(integrator("whitted"), Ok(Integrator::Whitted), "a name");
        let message = integrator("wited").expect_err("a slip");
        assert!(message.contains("did you mean 'whitted'"), "{message}");
        let message = isa("avx3").expect_err("no such level");
        assert!(message.contains("scalar") && message.contains("did you mean"), "{message}");
        assert!(filter("tent").expect_err("a stranger").contains("blackman-harris"), "the list");
        assert!(tone("aces").is_err(), "no such curve");
    }
}
