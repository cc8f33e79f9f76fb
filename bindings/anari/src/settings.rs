// SPDX-License-Identifier: GPL-3.0-or-later
//! Parameters of a renderer object. Tests: tests/renderers.rs.

use crate::attribute::Color;
use crate::ffi_array::Array;
use crate::object::Object;
use crate::types;

/// The quantity computed along rays of the camera.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Method {
    /// All light.
    Path { max_depth: u32, denoise: bool },
    /// Albedo times the share of directions that nothing occludes.
    Occlusion { rays: u32, distance: f32 },
    /// Albedo, lit from the eye alone; the scene's lights do not count.
    Eyelight,
    /// A property of the first surface as a colour, by its name.
    Debug(String),
}

/// The background of the picture.
#[derive(Clone, Debug)]
pub(crate) enum Background {
    Color(Color),
    /// Columns, rows, and texels from the lowest row on.
    Picture([usize; 2], Vec<Color>),
}

/// The parameters of a renderer object.
#[derive(Clone, Debug)]
pub(crate) struct Settings {
    pub(crate) method: Method,
    /// Of a pixel in each frame, at least 1; `None` where the program left it open.
    samples: Option<u32>,
    /// Radiance from everywhere.
    pub(crate) ambient: [f32; 3],
    pub(crate) background: Background,
    /// Whether the background's colour is to be multiplied by its opacity.
    pub(crate) premultiplies: bool,
}

/// Samples of a pixel in a frame, at most.
const MOST_SAMPLES: u32 = 1 << 16;

impl Settings {
    /// Those of an object.
    pub(crate) fn new(object: &Object) -> Self {
        let now = object.committed();
        let whole = |name: &str, default: u32, most: u32| {
            now.u32(name).filter(|&n| n > 0).unwrap_or(default).min(most)
        };
        let method = match object.subtype.as_str() {
            "ao" => Method::Occlusion {
                rays: whole("aoSamples", 1, 1 << 12),
                distance: now.f32("aoDistance").filter(|&distance| distance > 0.0).unwrap_or(f32::INFINITY),
            },
            "eyelight" => Method::Eyelight,
            "debug" => Method::Debug(now.text("method").unwrap_or("normal").to_owned()),
            _ => Method::Path {
                max_depth: whole("maxDepth", 8, 1 << 10),
                denoise: now.bool("denoise").unwrap_or(false),
            },
        };
        let radiance = now.f32("ambientRadiance").unwrap_or(0.0);
        let ambient = now.vec3("ambientColor").unwrap_or([1.0; 3]).map(|x| {
            let light = x * radiance;
            if light.is_finite() { light.max(0.0) } else { 0.0 }
        });
        let picture = now.object("background", types::ARRAY2D).and_then(|array| {
            let array = Array::of(array)?;
            let texels = array.colors().filter(|texels| !texels.is_empty())?;
            Some(Background::Picture([array.dims[0] as usize, array.dims[1] as usize], texels))
        });
        let color = || Background::Color(now.color("background").unwrap_or([0.0, 0.0, 0.0, 1.0]));
        Self {
            method,
            samples: now.u32("pixelSamples").filter(|&n| n > 0).map(|n| n.min(MOST_SAMPLES)),
            ambient,
            background: picture.unwrap_or_else(color),
            premultiplies: now.bool("premultiplyBackground").unwrap_or(false),
        }
    }
}

impl Settings {
    /// Samples of a pixel in a frame: by default more where no further frames will add to them.
    pub(crate) fn samples(&self, accumulates: bool) -> u32 {
        self.samples.unwrap_or(if accumulates { 4 } else { 16 })
    }
}

impl Background {
    /// The value at a place of the frame, (0, 0) its lower left corner.
    pub(crate) fn at(&self, [x, y]: [f32; 2]) -> Color {
        match self {
            Self::Color(color) => *color,
            Self::Picture([width, height], texels) => {
                let coordinate = |x: f32, count: usize| {
                    let coordinate = (x * count as f32 - 0.5).clamp(0.0, (count - 1) as f32);
                    (coordinate as usize, (coordinate as usize + 1).min(count - 1), coordinate.fract())
                };
                let ((x0, x1, u), (y0, y1, v)) = (coordinate(x, *width), coordinate(y, *height));
                let row = |y: usize| crate::attribute::mix(texels[y * width + x0], texels[y * width + x1], u);
                crate::attribute::mix(row(y0), row(y1), v)
            }
        }
    }
}
