// SPDX-License-Identifier: GPL-3.0-or-later
//! Options that several commands share: the frame, the camera, the machine, the conversion from light to
//! screen.
//! Source: names after pbrt, Mitsuba and appleseed.

use std::path::{Path, PathBuf};

use clap::Args;
use gnurt::accel::Memory;
use gnurt::display_rules::TONE;
use gnurt::image::{ExrCompression, ExrPixels, Picture, ToneCurve, WorkingSpace, WriteOptions, exposure_for};
use gnurt::render::{Caustics, Guiding, Integrator, PixelNoise, ReconstructionFilter};
use gnurt::scene::Projection;
use gnurt::simd::Level;
use gnurt::{Fog, Surroundings, VolumeFile};

use super::value::{self, CameraChoice, ExposureChoice, Resolution, ShaderChoice};

/// The pixels to render, and their sampling.
#[derive(Args, Clone, Debug)]
pub(crate) struct FrameArguments {
    /// Space in which light is computed: rec709 or acescg; textures, colours and lights are converted, and pictures back
    #[arg(
        help_heading = "Picture",
        hide_short_help = true,
        long,
        value_name = "SPACE",
        value_parser = value::working_space,
        allow_hyphen_values = true,
        default_value = "rec709"
    )]
    pub(crate) working_space: WorkingSpace,
    /// Size of the picture in pixels
    #[arg(
        help_heading = "Picture",
        short,
        long,
        value_name = "WxH",
        value_parser = value::resolution,
        allow_hyphen_values = true,
        default_value = "1280x720"
    )]
    pub(crate) resolution: Resolution,
    /// Samples per pixel
    #[arg(
        help_heading = "Quality",
        long,
        visible_alias = "samples",
        value_name = "N",
        value_parser = value::samples,
        allow_hyphen_values = true,
        default_value = "16"
    )]
    pub(crate) spp: u32,
    /// Seed of the random numbers: the same seed gives the same picture
    #[arg(help_heading = "Quality", hide_short_help = true, long, value_name = "N", value_parser = value::seed, allow_hyphen_values = true, default_value = "0")]
    pub(crate) seed: u64,
    /// Integrator: path (all light), whitted (direct light, mirrors, glass), ir, bir, mir (all light by virtual lights), eyelight
    /// or normals (shapes). auto: a pilot rendering chooses path with --guide auto or bir with 32 to 1024 virtual lights, by noise and time
    /// (view: path)
    #[arg(
        help_heading = "Light", hide_short_help = true,
        long,
        value_name = "NAME",
        value_parser = value::integrator,
        allow_hyphen_values = true,
        default_value = "path"
    )]
    pub(crate) integrator: Integrator,
    /// Reconstruction filter: box, triangle, gaussian or blackman-harris
    #[arg(
        help_heading = "Quality", hide_short_help = true,
        long,
        value_name = "NAME",
        value_parser = value::filter,
        allow_hyphen_values = true,
        default_value = "box"
    )]
    pub(crate) filter: ReconstructionFilter,
    /// Maximum depth. path: edges of a path, 1 = lights seen directly, 2 = direct light; whitted: reflections and refractions
    #[arg(help_heading = "Light", hide_short_help = true, long, value_name = "N", value_parser = value::depth, allow_hyphen_values = true, default_value = "16")]
    pub(crate) max_depth: u32,
    /// Virtual lights per sample of a pixel, approximately (ir, bir, mir)
    #[arg(help_heading = "Light", hide_short_help = true, long, value_name = "N", value_parser = value::virtual_lights, allow_hyphen_values = true, default_value = "1024")]
    pub(crate) vpls: u32,
    /// path: limit each indirect contribution to X (biased, darker). ir, bir, mir: limit the geometry term of virtual lights,
    /// 1/area; rays add the remainder (unbiased) [default: from the scene's size]
    #[arg(help_heading = "Light", hide_short_help = true, long, value_name = "X", value_parser = value::clamp, allow_hyphen_values = true)]
    pub(crate) clamp: Option<f32>,
    /// path: guide paths to where a pilot rendering found light: on, off, or auto = samples from the 17th on (of small pictures later), if the pilot
    /// finds that it pays
    #[arg(help_heading = "Light", hide_short_help = true, long, value_name = "WHEN", value_parser = value::guide, allow_hyphen_values = true, default_value = "off")]
    pub(crate) guide: Guiding,
    /// path, ir, bir, mir: search for lamps that mirrors and smooth glass show to rough surfaces: on, off, or auto = lamps without extent and small ones
    #[arg(help_heading = "Light", hide_short_help = true, long, value_name = "WHICH", value_parser = value::caustics, allow_hyphen_values = true, default_value = "off")]
    pub(crate) caustics: Caustics,
    /// ir, bir, mir: interleaved sampling in patterns of NxN pixels: N^2 times fewer rays, slightly blurred; 1, 3, 5 or 7;
    /// 1 = each pixel uses all virtual lights
    #[arg(help_heading = "Light", hide_short_help = true, long, value_name = "N", value_parser = value::interleave, allow_hyphen_values = true, default_value = "1")]
    pub(crate) interleave: u32,
    /// Errors of neighbouring pixels: white = independent, or blue = they cancel out in means over neighbours, so that a picture looks less
    /// noisy (path, whitted; best with 1, 4, 16, 64 samples and without a denoiser)
    #[arg(help_heading = "Quality", hide_short_help = true, long, value_name = "NAME", value_parser = value::pixel_noise, allow_hyphen_values = true, default_value = "white")]
    pub(crate) pixel_noise: PixelNoise,
    /// Adaptive sampling: stop a tile when its relative noise is below X, like 0.02; at least 16 samples, at most --spp
    #[arg(help_heading = "Quality", hide_short_help = true, long, value_name = "X", value_parser = value::noise, allow_hyphen_values = true)]
    pub(crate) noise: Option<f32>,
    /// Make every material a Lambertian reflector of its base colour
    #[arg(help_heading = "Look", hide_short_help = true, long)]
    pub(crate) force_diffuse: bool,
    /// Shade a material (* = all) by a shader: a file (.osl, .oso, .oslgroup, or FILE.mtlx[:NODE] of MaterialX), or a class of
    /// libOpenRT, built-in or from a plugin's FILE. Values: numbers between commas, textures as @FILE. A light's FILE.osl needs
    /// no material; repeatable
    #[arg(
        help_heading = "Look", hide_short_help = true,
        long = "shader",
        value_name = "MATERIAL=CLASS[@FILE][:NAME=VALUE...]",
        value_parser = value::shader,
        allow_hyphen_values = true,
        action = clap::ArgAction::Append,
        conflicts_with = "force_diffuse"
    )]
    pub(crate) shaders: Vec<ShaderChoice>,
    /// Search a folder for files that shaders include, after their own folders; repeatable
    #[arg(help_heading = "Look", hide_short_help = true, long, value_name = "DIR", action = clap::ArgAction::Append)]
    pub(crate) include: Vec<PathBuf>,
    /// Pixel shader (.osl, .oso, .oslgroup): computes a pixel from the light along its camera rays, and can trace more rays
    #[arg(help_heading = "Look", hide_short_help = true, long = "pixel-shader", value_name = "FILE.osl[:NAME=VALUE...]", value_parser = value::pixel_shader, allow_hyphen_values = true)]
    pub(crate) pixel_shader: Option<ShaderChoice>,
}

/// Where it is seen from: each option replaces one part of the scene's camera.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Camera")]
pub(crate) struct ViewArguments {
    /// Camera of the scene, by name or number from 0; or a camera shader, [NAME=]FILE.osl[:NAME=VALUE...], at the position of
    /// the camera NAME, or of the first one
    #[arg(long, value_name = "NAME|INDEX|FILE.osl", value_parser = value::camera, allow_hyphen_values = true)]
    pub(crate) camera: Option<CameraChoice>,
    /// Position of the camera, in world units
    #[arg(long, value_name = "X,Y,Z", value_parser = value::point, allow_hyphen_values = true)]
    pub(crate) eye: Option<[f32; 3]>,
    /// Point that the camera looks at, in the middle of the picture
    #[arg(long, value_name = "X,Y,Z", value_parser = value::point, allow_hyphen_values = true)]
    pub(crate) target: Option<[f32; 3]>,
    /// Direction of up in the picture
    #[arg(hide_short_help = true, long, value_name = "X,Y,Z", value_parser = value::direction, allow_hyphen_values = true)]
    pub(crate) up: Option<[f32; 3]>,
    /// Vertical field of view in degrees: above 0 and below 180, at most 360 for a fisheye
    #[arg(hide_short_help = true, long, value_name = "DEGREES", value_parser = value::angle_of_view, allow_hyphen_values = true)]
    pub(crate) fov: Option<f32>,
    /// Projection: perspective, orthographic, fisheye or panorama
    #[arg(hide_short_help = true, long, value_name = "NAME", value_parser = value::projection)]
    pub(crate) projection: Option<Projection>,
    /// Height of an orthographic camera's view [default: the perspective's height at the target]
    #[arg(hide_short_help = true, long, value_name = "UNITS", value_parser = value::length, allow_hyphen_values = true)]
    pub(crate) view_height: Option<f32>,
    /// From the view to the middle of the picture, right and up, in heights of the picture
    #[arg(hide_short_help = true, long, value_name = "X,Y", value_parser = value::shift, allow_hyphen_values = true)]
    pub(crate) shift: Option<[f32; 2]>,
    /// Diameter of the lens, for depth of field; 0 = pinhole
    #[arg(hide_short_help = true, long, value_name = "UNITS", value_parser = value::aperture, allow_hyphen_values = true)]
    pub(crate) aperture: Option<f32>,
    /// Distance in focus [default: the target's distance]
    #[arg(hide_short_help = true, long, value_name = "UNITS", value_parser = value::length, allow_hyphen_values = true)]
    pub(crate) focus: Option<f32>,
    #[command(flatten)]
    pub(crate) surroundings: SurroundingsArguments,
}

/// The surroundings of the scene.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "Light")]
pub(crate) struct SurroundingsArguments {
    /// Environment light and background: a latitude-longitude picture (.hdr, .exr, .pfm, .png, .jpg), a radiance R,G,B,
    /// builtin:day, builtin:evening, builtin:overcast, or a shader, FILE.osl[:NAME=VALUE...]. Its up is --up, else +y. Without
    /// this option a scene that has no light gets a default one
    #[arg(long, value_name = "FILE|R,G,B|SKY", value_parser = value::surroundings, allow_hyphen_values = true)]
    pub(crate) environment: Option<Surroundings>,
    /// Rotation of the environment around up, in degrees
    #[arg(hide_short_help = true, long, value_name = "DEGREES", value_parser = value::turn, allow_hyphen_values = true, default_value = "0", requires = "environment")]
    pub(crate) environment_turn: f64,
    /// Fog around scene and camera: the mean distance that light goes through it, in world units, one or R,G,B. Values: albedo,
    /// anisotropy, emission
    #[arg(hide_short_help = true, long, value_name = "DISTANCE[:NAME=VALUE...]", value_parser = Fog::parse, allow_hyphen_values = true)]
    pub(crate) fog: Option<Fog>,
    /// Smoke or a cloud from a file of OpenVDB or NanoVDB, at its place; repeatable. Values: density (multiplied to the grid's
    /// numbers: extinction per world unit), albedo, anisotropy, emission, grid=NAME, glow=NAME (grid multiplied to the emission).
    /// For fire: temperature=NAME (grid of kelvins; the emission is multiplied by that of black bodies, 1 at 2000 K), kelvin (of
    /// the grid's unit)
    #[arg(hide_short_help = true, long = "volume", value_name = "FILE[:NAME=VALUE...]", value_parser = VolumeFile::parse, allow_hyphen_values = true, action = clap::ArgAction::Append)]
    pub(crate) volumes: Vec<VolumeFile>,
}

impl ViewArguments {
    /// The name of the scene's camera, if one was given.
    pub(crate) fn camera_name(&self) -> Option<&str> {
        match self.camera.as_ref()? {
            CameraChoice::Named(name) => Some(name),
            CameraChoice::Script(choice) => Some(&choice.material[..]).filter(|name| !name.is_empty()),
        }
    }

    /// The shader that replaces a camera, if one was given.
    pub(crate) fn camera_shader(&self) -> Option<&ShaderChoice> {
        match self.camera.as_ref()? {
            CameraChoice::Named(_) => None,
            CameraChoice::Script(choice) => Some(choice),
        }
    }
}

impl SurroundingsArguments {
    /// The file that the environment is read from.
    pub(crate) fn file(&self) -> Option<&Path> {
        self.environment.as_ref().and_then(Surroundings::file)
    }

    /// All files.
    pub(crate) fn files(&self) -> impl Iterator<Item = PathBuf> {
        let volumes = self.volumes.iter().map(VolumeFile::path);
        self.file().into_iter().chain(volumes).map(PathBuf::from)
    }
}

/// Threads and instruction set.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Time and machine")]
pub(crate) struct MachineArguments {
    /// Threads; 0 = all cores
    #[arg(hide_short_help = true, short, long, value_name = "N", value_parser = value::threads, allow_hyphen_values = true)]
    pub(crate) threads: Option<usize>,
    /// Instruction set: auto, scalar, sse4.2, avx2, avx512 or neon
    #[arg(hide_short_help = true, long, value_name = "NAME", value_parser = value::isa, allow_hyphen_values = true)]
    pub(crate) isa: Option<Level>,
    /// Keep large arrays in a file in this folder: for scenes larger than memory
    #[arg(hide_short_help = true, long, value_name = "DIR")]
    pub(crate) out_of_core: Option<PathBuf>,
}

/// The trees for rays.
#[derive(Args, Clone, Copy, Debug)]
#[command(next_help_heading = "Time and machine")]
pub(crate) struct TreeArguments {
    /// Trees: fast, or compact (half the memory, slower rays); the picture is the same
    #[arg(hide_short_help = true, long, value_name = "NAME", value_parser = value::memory, allow_hyphen_values = true, default_value = "fast")]
    pub(crate) memory: Memory,
}

/// From linear light to the bytes of a screen; files of floats keep the light.
#[derive(Args, Clone, Copy, Debug)]
#[command(next_help_heading = "Look")]
pub(crate) struct LightArguments {
    /// Tone curve of PNG, JPEG and WebP files: filmic (a fit of ACES), agx, neutral (Khronos PBR Neutral), clamp or reinhard
    #[arg(
        long,
        value_name = "NAME",
        value_parser = value::tone,
        allow_hyphen_values = true,
        default_value = TONE.name(),
        hide_short_help = true
    )]
    pub(crate) tone: ToneCurve,
    /// Exposure of PNG, JPEG and WebP files in stops, each doubles the light: 0 = unchanged, auto = from the picture
    #[arg(
        long,
        value_name = "EV",
        value_parser = value::exposure,
        allow_hyphen_values = true,
        default_value = "auto"
    )]
    pub(crate) exposure: ExposureChoice,
    #[command(flatten)]
    pub(crate) file: PictureFileArguments,
}

/// How a picture is stored where its format leaves a choice.
#[derive(Args, Clone, Copy, Debug, Default, PartialEq)]
#[command(next_help_heading = "Look")]
pub(crate) struct PictureFileArguments {
    /// Bits of a channel: 8 or 16 in a PNG [default: 8], 16 or 32 in an EXR [default: 32 if a value needs it]
    #[arg(long, value_name = "N", value_parser = value::bits, allow_hyphen_values = true, hide_short_help = true)]
    bits: Option<u8>,
    /// Compression of an EXR: none, rle, zips, zip, piz or pxr24 [default: zip]
    #[arg(
        long,
        value_name = "NAME",
        value_parser = value::compression,
        allow_hyphen_values = true,
        hide_short_help = true
    )]
    compression: Option<ExrCompression>,
    /// Primaries of an EXR's colours: rec709 or acescg [default: those of --working-space]
    #[arg(
        long,
        value_name = "SPACE",
        value_parser = value::working_space,
        allow_hyphen_values = true,
        hide_short_help = true
    )]
    primaries: Option<WorkingSpace>,
    /// Width and height of an EXR's tiles, 16 to 16384 pixels, such as 64 [default: rows without tiles]
    #[arg(
        long,
        value_name = "PIXELS",
        value_parser = value::tile_size,
        allow_hyphen_values = true,
        hide_short_help = true
    )]
    tile_size: Option<u32>,
    /// Quality of a JPEG, 1 = the smallest file, to 100 [default: 92]
    #[arg(long, value_name = "N", value_parser = value::quality, allow_hyphen_values = true, hide_short_help = true)]
    quality: Option<u8>,
}

impl PictureFileArguments {
    /// Stores an EXR's colours with 32 bits, unless other ones were requested.
    pub(crate) fn exact(&mut self) {
        self.bits.get_or_insert(32);
    }

    /// Stores an EXR's colours in this space, unless another one was requested.
    pub(crate) fn within(&mut self, space: WorkingSpace) {
        self.primaries.get_or_insert(space);
    }

    /// These choices, and the defaults of the rest.
    pub(crate) fn options(self) -> WriteOptions {
        let default = WriteOptions::default();
        WriteOptions {
            png_16_bits: self.bits == Some(16),
            exr_pixels: match self.bits {
                Some(16) => ExrPixels::Half,
                Some(32) => ExrPixels::Float,
                _ => default.exr_pixels,
            },
            exr_compression: self.compression.unwrap_or_default(),
            exr_tile: self.tile_size,
            exr_space: self.primaries.unwrap_or_default(),
            jpeg_quality: self.quality.unwrap_or(default.jpeg_quality),
            ..default
        }
    }
}

impl LightArguments {
    /// The same with the known exposure of the scene's light, unless another one is requested.
    pub(crate) fn suited(self, exposure: Option<f32>) -> Self {
        match (self.exposure, exposure) {
            (ExposureChoice::Auto, Some(stops)) => Self { exposure: ExposureChoice::Stops(stops), ..self },
            _ => self,
        }
    }

    /// Curve and exposure of this picture; the note reports a chosen exposure.
    pub(crate) fn display_options(self, picture: &Picture) -> (DisplayOptions, Option<String>) {
        match self.exposure {
            ExposureChoice::Stops(exposure) => (self.stops(exposure), None),
            ExposureChoice::Auto => self.chosen(exposure_for(picture)),
        }
    }

    /// The same for an exposure that was chosen elsewhere.
    pub(crate) fn chosen(self, exposure: f32) -> (DisplayOptions, Option<String>) {
        let note = format!("exposure {exposure:+.2} chosen from the picture; --exposure {exposure} keeps it");
        (self.stops(exposure), Some(note))
    }

    /// The curve with this exposure.
    pub(crate) fn stops(self, exposure: f32) -> DisplayOptions {
        DisplayOptions { tone: self.tone, exposure, file: self.file }
    }
}

/// How light becomes bytes of a screen.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct DisplayOptions {
    pub(crate) tone: ToneCurve,
    /// Stops.
    pub(crate) exposure: f32,
    /// How it is stored.
    pub(crate) file: PictureFileArguments,
}
