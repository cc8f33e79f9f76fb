// SPDX-License-Identifier: GPL-3.0-or-later
//! `gnurt render --piece I/N`: compatible options, and the file of a piece. The file is an EXR with exact
//! colours and all layers of the piece's tiles; its header identifies the piece and the picture: the
//! fingerprint of scene, camera and options, the number of samples, the frame. `join` runs the steps that
//! read neighbouring pixels or set the appearance. Tests: `tests/program/pieces.rs`.

use gnurt::image::{Picture, WorkingSpace};
use gnurt::layers::LayerList;
use gnurt::render::{
    Frame, Integrator, LightLayer, Mattes, Piece, RenderOptions, pack_piece, rendered_rects,
};

use crate::arguments::{ExposureChoice, LightArguments, RenderArguments, value};
use crate::failure::{Failure, Outcome};
use crate::output::Output;

const PIECE: &str = "gnurtPiece";
const PICTURE: &str = "gnurtPicture";
const FRAME: &str = "gnurtFrame";
const CROP: &str = "gnurtCrop";
const SAMPLES: &str = "gnurtSamples";
const EXPOSURE: &str = "gnurtExposure";
const LAYERS: &str = "gnurtLayers";
const LIGHT_LAYERS: &str = "gnurtLightLayers";
const SPACE: &str = "gnurtSpace";
const DEPTH: &str = "gnurtCryptoDepth";

/// The header of a piece's file.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Header {
    pub(super) piece: Piece,
    /// The fingerprint of its picture.
    pub(super) picture: String,
    /// Columns and rows of the whole picture.
    pub(super) frame: [u32; 2],
    pub(super) crop: Option<[u32; 4]>,
    /// Requested samples per pixel.
    pub(super) spp: u32,
    /// The space of its colours, whatever chromaticities its file states.
    pub(super) space: WorkingSpace,
    pub(super) integrator: Integrator,
    /// Stops, where they do not depend on the picture.
    pub(super) exposure: Option<f32>,
    /// The requested list of layers.
    pub(super) layers: Option<LayerList>,
    /// Layers of light, those of groups as well.
    pub(super) light_layers: Vec<LightLayer>,
    pub(super) mattes: Mattes,
}

/// Rejects options that exclude a piece.
pub(super) fn check(arguments: &RenderArguments) -> Outcome {
    let Some(piece) = arguments.piece else { return Ok(()) };
    let refuse = |why: String| Err(Failure::usage(format_args!("--piece {piece}: {why}")));
    if arguments.heatmap.is_some() {
        return refuse("a piece has no heat map; leave out --heatmap".into());
    }
    if arguments.time.is_some() {
        return refuse("pieces that end early do not fit together; give --spp, not --time".into());
    }
    if arguments.denoiser.options(None).is_some() {
        return refuse("noise is taken out of the whole picture; give --denoise to `gnurt join`".into());
    }
    let frame = &arguments.frame;
    if frame.integrator.has_virtual_lights() && frame.interleave > 1 {
        return refuse(
            "interleaved pixels read their neighbours, which are in other pieces; leave out --interleave"
                .into(),
        );
    }
    let output = arguments.output.as_deref().map(Output::named).transpose()?;
    match output {
        Some(output) if output.has_layers() => Ok(()),
        Some(output) => refuse(format!("the file of a piece is an .exr, not {}", output.path().display())),
        None => refuse("it needs a file; give --output FILE.exr".into()),
    }
}

/// Writes a piece of the frame; `light` is the known curve and exposure, `print` the fingerprint of the
/// picture, `layers` the requested list of layers, `space` that of the light.
pub(super) fn save(
    frame: &Frame,
    piece: Piece,
    (print, layers, space): (u64, Option<&str>, WorkingSpace),
    light: LightArguments,
    options: &RenderOptions,
    output: &Output,
) -> Outcome {
    if !frame.stats.complete {
        return Err(Failure::data(format_args!(
            "piece {piece} was stopped before it was whole, and is not written"
        )));
    }
    let rects = rendered_rects(options).map_err(Failure::usage)?;
    let mut packed = pack_piece(&frame.picture, &rects);
    packed.set_metadata(PIECE, piece.to_string());
    packed.set_metadata(PICTURE, format!("{print:016x}"));
    packed.set_metadata(FRAME, format!("{}x{}", options.width, options.height));
    packed.set_metadata(SAMPLES, options.spp.to_string());
    if space != WorkingSpace::default() {
        packed.set_metadata(SPACE, space.name());
    }
    if let Some([x0, y0, x1, y1]) = options.crop {
        packed.set_metadata(CROP, format!("{x0},{y0},{x1},{y1}"));
    }
    if let Some(layers) = layers {
        packed.set_metadata(LAYERS, layers);
        packed.set_metadata(DEPTH, options.mattes.depth.to_string());
    }
    if !options.light_layers.is_empty() {
        let line = |layer: &LightLayer| format!("{}={}", layer.name, layer.expression);
        let lines: Vec<String> = options.light_layers.iter().map(line).collect();
        packed.set_metadata(LIGHT_LAYERS, lines.join("\n"));
    }
    if let ExposureChoice::Stops(stops) = light.exposure {
        packed.set_metadata(EXPOSURE, stops.to_string());
    }
    output.write_exactly(&packed)
}

impl Header {
    /// The header of a picture's file; `None` if it is no piece.
    pub(super) fn of(picture: &Picture) -> Option<Self> {
        let text = |name: &str| picture.metadata(name);
        let numbers = |text: &str, between: char| -> Option<Vec<u32>> {
            text.split(between).map(|argument| argument.parse().ok()).collect()
        };
        let optional = |name: &str, read: &dyn Fn(&str) -> Option<Vec<u32>>| match text(name) {
            None => Some(None),
            Some(text) => Some(Some(read(text)?)),
        };
        let crop = optional(CROP, &|text| numbers(text, ','))?;
        let layers = text(LAYERS).map(value::layers).transpose().ok()?;
        let kinds = layers.as_ref().map_or_else(Vec::new, |layers| layers.mattes.clone());
        let depth = text(DEPTH).map_or(Some(Mattes::DEPTH), |depth| {
            depth.parse().ok().filter(|&depth| depth <= Mattes::DEEPEST)
        });
        let light_layer = |line: &str| {
            let (name, expression) = line.split_once('=')?;
            LightLayer::new(name, expression).ok()
        };
        let light_layers = text(LIGHT_LAYERS).unwrap_or_default().lines().map(light_layer);
        let exposure =
            text(EXPOSURE).map(|stops| stops.parse::<f32>().ok().filter(|stops| stops.is_finite()));
        Some(Self {
            piece: value::piece(text(PIECE)?).ok()?,
            picture: text(PICTURE)?.to_owned(),
            frame: numbers(text(FRAME)?, 'x')?.try_into().ok()?,
            crop: crop.map(<[u32; 4]>::try_from).transpose().ok()?,
            spp: text(SAMPLES)?.parse().ok()?,
            space: text(SPACE).map_or(Some(WorkingSpace::default()), |name| name.parse().ok())?,
            integrator: text("integrator")?.parse().ok()?,
            layers,
            light_layers: light_layers.collect::<Option<_>>()?,
            mattes: Mattes { kinds, depth: depth? },
            exposure: match exposure {
                Some(None) => return None,
                Some(stops) => stops,
                None => None,
            },
        })
    }

    /// The options that place its pixels.
    pub(super) fn options(&self) -> RenderOptions {
        let [width, height] = self.frame;
        RenderOptions {
            width,
            height,
            crop: self.crop,
            spp: self.spp,
            integrator: self.integrator,
            piece: Some(self.piece),
            aovs: true,
            seen: true,
            light_layers: self.light_layers.clone(),
            mattes: self.mattes.clone(),
            ..RenderOptions::default()
        }
    }
}
