// SPDX-License-Identifier: GPL-3.0-or-later
//! Queries of a running shader to the program that runs it. Source: OSL's renderer services.

use super::cells::{DualRow, LANES};
use super::components::ClosureDecl;
use crate::hir::Data;
use crate::types::Type;
use gnurt_sl_lib::Dual;
use gnurt_sl_lib::color::ColorSystem;
use gnurt_sl_lib::points::{Column, PointCloud};
use std::sync::{Arc, LazyLock};

/// The point that is shaded. Space: common. The default is 0 or false in all fields, derivatives included.
///
/// Shaders get all fields as they are: nothing is normalised, turned or checked.
///
/// Derivatives (`dx`, `dy` of a [`Dual`]) are differences between this point and the hits of the rays through the next pixel in
/// x and in y. A renderer without ray differentials may leave them 0: then `Dx`, `Dy` and `filterwidth` are 0,
/// textures are looked up unfiltered, and patterns alias.
#[derive(Clone, Debug, Default)]
pub struct Point {
    /// Position: the global `P`.
    pub p: Dual<[f32; 3]>,
    /// Direction of the ray that arrives, of length 1, towards the surface: the global `I`.
    pub i: Dual<[f32; 3]>,
    /// Shading normal, of length 1: the global `N`. By OSL's convention it faces the viewer, `dot (N, I) <= 0`, also
    /// where the ray hits the back.
    pub n: [f32; 3],
    /// Geometric normal, of length 1, which faces the viewer, too: the global `Ng`.
    pub ng: [f32; 3],
    /// First surface parameter.
    pub u: Dual<f32>,
    /// Second surface parameter.
    pub v: Dual<f32>,
    /// Derivative of the position by `u`: a tangent. Shaders hand it on to closures of brushed surfaces and of hair, which have no
    /// direction if it is 0.
    pub dpdu: [f32; 3],
    /// Derivative of the position by `v`.
    pub dpdv: [f32; 3],
    /// The lit position, in light shaders.
    pub ps: Dual<[f32; 3]>,
    /// Time of the ray, in any unit.
    pub time: f32,
    /// How long the shutter is open, in the same unit.
    pub dtime: f32,
    /// Motion of the point, per unit of time.
    pub dpdtime: [f32; 3],
    /// Area of the whole object's surface, for `surfacearea ()`. Shaders of lamps divide by it.
    pub surface_area: f32,
    /// Whether the ray hits the back, for `backfacing ()`: the surface's own normal faces away from the viewer, and `n` and `ng`
    /// have been turned.
    pub backfacing: bool,
    /// Whether the object's space is mirrored; `calculatenormal (p)` then points to the other side. Nothing else reads it.
    pub flipped: bool,
    /// Bits of the kinds of the ray, for `raytype`: those of [`Host::ray_kind`].
    pub ray_kinds: u32,
    /// Any number of yours. Methods of [`Host`] find it in their `point`: put the number of the object or primitive here. Many
    /// points may have the same. Shaders do not see it, except that `random ()` depends on it.
    pub index: i32,
    /// Two random numbers in [0, 1), in lights and cameras.
    pub xi: [f32; 2],
    /// Raster position in pixels from the upper left corner, in cameras and pixels.
    pub raster: [f32; 2],
}

/// Options of a call of `trace`.
#[derive(Clone, Debug, PartialEq)]
pub struct TraceOptions {
    /// Distance along the ray of its start.
    pub mindist: f32,
    /// Distance along the ray of its end.
    pub maxdist: f32,
    /// The objects that it may hit; empty for all.
    pub traceset: Arc<str>,
}

impl Default for TraceOptions {
    /// The whole ray, all objects.
    fn default() -> Self {
        Self { mindist: 0.0, maxdist: 1e30, traceset: "".into() }
    }
}

/// Light that reaches a point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Arriving {
    /// Unit direction towards the light.
    pub dir: [f32; 3],
    /// Irradiance of a surface that faces the light, divided by the density of the direction.
    pub light: [f32; 3],
    /// Distance of the light.
    pub distance: f32,
    /// Density of the direction per solid angle; 0 for lights without extent.
    pub pdf: f32,
}

/// Options of a texture lookup.
#[derive(Clone, Debug, PartialEq)]
pub struct TextureOptions {
    /// Number of requested channels, at most four.
    pub channels: usize,
    /// The first channel to read.
    pub first_channel: i32,
    /// The value of missing channels.
    pub fill: f32,
    /// The replacement of a missing file, if any.
    pub missing: Option<[f32; 3]>,
    /// Wrapping of coordinates beyond the picture, in s, t and r: `black`, `clamp`, `periodic`, `mirror` or
    /// `default`.
    pub wrap: [Arc<str>; 3],
    /// Factor of the filter's width.
    pub width: [f32; 2],
    /// Addition to the filter's width.
    pub blur: [f32; 2],
    /// `closest`, `linear`, `cubic` or `smartcubic`; empty for the default.
    pub interpolation: Arc<str>,
    /// The colour space of the file, as the shader states it; empty if not given.
    pub color_space: Arc<str>,
    /// The grid of a volume.
    pub subimage: Subimage,
    /// Whether derivatives of the result are needed: otherwise they may be 0.
    pub derivs: bool,
}

/// One of the pictures or grids of a file.
#[derive(Clone, Debug, PartialEq)]
pub enum Subimage {
    /// By number, from 0.
    Number(i32),
    /// By name.
    Name(Arc<str>),
}

/// The default wrapping and interpolation: shared, because options are made for each point.
static USUAL: LazyLock<[Arc<str>; 2]> = LazyLock::new(|| ["default".into(), "".into()]);

impl Default for TextureOptions {
    fn default() -> Self {
        let [wrap, interpolation] = &*USUAL;
        Self {
            channels: 4,
            first_channel: 0,
            fill: 0.0,
            missing: None,
            wrap: std::array::from_fn(|_| wrap.clone()),
            width: [1.0; 2],
            blur: [0.0; 2],
            interpolation: interpolation.clone(),
            color_space: interpolation.clone(),
            subimage: Subimage::Number(0),
            derivs: true,
        }
    }
}

/// A value from outside, with its derivatives if it has some.
#[derive(Clone, Debug)]
pub struct Given {
    /// The value.
    pub value: Data,
    /// Derivatives by x and y; empty for none.
    pub derivs: [Vec<f32>; 2],
}

impl From<Data> for Given {
    /// A value that does not change from pixel to pixel.
    fn from(value: Data) -> Self {
        Self { value, derivs: [Vec::new(), Vec::new()] }
    }
}

/// Coordinates of a direction in a picture over longitude and latitude with y up, with derivatives from pixel
/// to pixel.
#[must_use]
pub fn longitude_latitude([x, y, z]: [Dual<f32>; 3]) -> [Dual<f32>; 2] {
    use std::f32::consts::PI;
    let uv_of = |x: f32, y: f32, z: f32| [(-x).atan2(z) / (2.0 * PI) + 0.5, 0.5 - y.atan2(x.hypot(z)) / PI];
    let here = uv_of(x.value, y.value, z.value);
    let step = |dx: f32, dy: f32, dz: f32| {
        let there = uv_of(x.value + dx, y.value + dy, z.value + dz);
        // The shorter direction around.
        let change = there[0] - here[0];
        [change - change.round(), there[1] - here[1]]
    };
    let (right, down) = (step(x.dx, y.dx, z.dx), step(x.dy, y.dy, z.dy));
    [0, 1].map(|k: usize| Dual::new(here[k], right[k], down[k]))
}

/// The answers to a shader's queries. The defaults are those of an empty world.
///
/// Queries come from the thread that runs the shader; `point` is the one that was given to it.
///
/// Matrices are arrays of rows. Points are rows, too, and are multiplied from the left, `p M`: `m[3]` is the translation.
pub trait Host {
    /// The matrix from a named space to common space; `None`, the default, if there is no such space. `common` itself is not
    /// asked for. OSL's usual names are `object`, `shader`, `world`, `camera`, `screen`, `raster` and `NDC`.
    ///
    /// An object at (1, 2, 3), twice as large as in its own space, has for `object`
    /// `[[2., 0., 0., 0.], [0., 2., 0., 0.], [0., 0., 2., 0.], [1., 2., 3., 1.]]`.
    ///
    /// An unknown space is reported as an error, and is taken for the common one.
    fn common_from(&self, space: &str, point: &Point) -> Option<[[f32; 4]; 4]> {
        let _ = (space, point);
        None
    }

    /// The matrix from common space to a named one. The default inverts the other.
    fn to_common_inverse(&self, space: &str, point: &Point) -> Option<[[f32; 4]; 4]> {
        self.common_from(space, point).map(|m| gnurt_sl_lib::matrix::inverse(&m))
    }

    /// Whether a named space has one matrix for some points of a batch, those whose bits are set in `lanes`: point `k` has bit
    /// `1 << k`, and its [`Point::index`] is `index[k]`.
    ///
    /// It is only for speed. If false, the default, the matrix is requested for each point; if true, for the first of them, and
    /// used for all. A wrong true places the other points wrongly, without a message.
    fn is_same_space(&self, space: &str, lanes: u32, index: &[i32; LANES]) -> bool {
        let _ = (space, lanes, index);
        false
    }

    /// A value that the geometry carries for an interpolated parameter (`[[ int interpolated = 1 ]]`); `None`, the default, leaves
    /// the parameter as it is. The value has the numbers or texts of `ty`.
    fn userdata(&self, name: &str, ty: Type, point: &Point) -> Option<Given> {
        let _ = (name, ty, point);
        None
    }

    /// A query of `getattribute`. `object` is empty for the shaded object, which [`Point::index`] identifies. With `index` an
    /// element of an array is meant. `ty` is the type of the shader's variable, and the value has its numbers or
    /// texts. By default there is none.
    fn attribute(
        &self,
        object: &str,
        name: &str,
        index: Option<i32>,
        ty: Type,
        point: &Point,
    ) -> Option<Given> {
        let _ = (object, name, index, ty, point);
        None
    }

    /// Whether a ray hits something.
    fn trace(&self, p: Dual<[f32; 3]>, r: Dual<[f32; 3]>, options: &TraceOptions, point: &Point) -> bool {
        let _ = (p, r, options, point);
        false
    }

    /// Radiance along a ray.
    fn radiance(
        &self,
        p: Dual<[f32; 3]>,
        r: Dual<[f32; 3]>,
        options: &TraceOptions,
        point: &Point,
    ) -> [f32; 3] {
        let _ = (p, r, options, point);
        [0.0; 3]
    }

    /// The number of lights for `illuminance`.
    fn light_count(&self) -> i32 {
        0
    }

    /// A sample of a light that reaches `p`, if any; occlusion counts if `shadowed`.
    fn illuminate(
        &self,
        light: i32,
        p: [f32; 3],
        category: &str,
        shadowed: bool,
        point: &Point,
    ) -> Option<Arriving> {
        let _ = (light, p, category, shadowed, point);
        None
    }

    /// Four channels of a picture at `s` and `t`, t downwards, with derivatives from pixel to pixel.
    ///
    /// # Errors
    /// A message for users; an empty one if it has been reported before.
    fn texture(
        &self,
        file: &str,
        at: [Dual<f32>; 2],
        options: &TextureOptions,
        point: &Point,
    ) -> Result<[Dual<f32>; 4], String> {
        let _ = (at, options, point);
        Err(format!("no texture \"{file}\": there are none here"))
    }

    /// The same for the points of a batch in `lanes`, as bits: writes the result of
    /// [`texture`](Self::texture) for each to its column of `out`. Returns false without a message if the
    /// points must be queried one by one.
    fn textures(
        &self,
        file: &str,
        lanes: u32,
        at: &[DualRow; 2],
        options: &TextureOptions,
        out: &mut [DualRow; 4],
    ) -> bool {
        let _ = (file, lanes, at, options, out);
        false
    }

    /// The same of an environment map, in a direction of any length.
    ///
    /// # Errors
    /// A message for users.
    fn environment(
        &self,
        file: &str,
        direction: [Dual<f32>; 3],
        options: &TextureOptions,
        point: &Point,
    ) -> Result<[Dual<f32>; 4], String> {
        self.texture(file, longitude_latitude(direction), options, point)
    }

    /// Four channels of a volume at a position, with derivatives from pixel to pixel.
    ///
    /// # Errors
    /// A message for users; an empty one if it has been reported before.
    fn texture3d(
        &self,
        file: &str,
        at: [Dual<f32>; 3],
        options: &TextureOptions,
        point: &Point,
    ) -> Result<[Dual<f32>; 4], String> {
        let _ = (at, options, point);
        Err(format!("no volume \"{file}\": there are none here"))
    }

    /// Properties of a picture: `exists`, `resolution`, `channels` and others; of the tile at `at` if a name
    /// represents many files.
    ///
    /// # Errors
    /// A message: there is no such picture.
    fn texture_info(
        &self,
        file: &str,
        at: Option<[f32; 2]>,
        name: &str,
        ty: Type,
    ) -> Result<Option<Data>, String> {
        let _ = (file, at, ty);
        Ok((name == "exists").then(|| Data::Int(vec![0])))
    }

    /// A cloud of points by its file's name.
    ///
    /// # Errors
    /// A message for users; an empty one if it has been reported before.
    fn point_cloud(&self, file: &str) -> Result<Arc<PointCloud>, String> {
        Err(format!("no point cloud \"{file}\": there are none here"))
    }

    /// Adds a point to a cloud that is written at the end; `row` has one value a column. Returns whether the
    /// row fits the cloud's columns.
    ///
    /// # Errors
    /// A message: no clouds are written here.
    fn write_point(&self, file: &str, uv_of: [f32; 3], row: &[Column]) -> Result<bool, String> {
        let _ = (uv_of, row);
        Err(format!("point cloud \"{file}\" is not written: only testshade writes point clouds"))
    }

    /// The message about a missing texture; `requested` is the name, `uv_of` a position in a shader's text.
    fn texture_fault(&self, requested: &str, why: &str, uv_of: &str) -> String {
        let _ = requested;
        format!("{why} ({uv_of})")
    }

    /// The message about a mistake, and the place in the text where it is.
    fn with_place(&self, message: String, place: &str) -> String {
        format!("{message} {place}")
    }

    /// The text of a dictionary's file.
    fn dictionary(&self, file: &str) -> Option<String> {
        let _ = file;
        None
    }

    /// A query of `getmessage("trace", ...)`: a value, and whether the last ray hit.
    fn trace_message(&self, name: &str, ty: Type, point: &Point) -> (bool, Option<Given>) {
        let _ = (name, ty, point);
        (false, None)
    }

    /// The closures that the program supports, always in the same order. By default none, which
    /// [`standard_closures`](super::standard_closures) may fill.
    fn closures(&self) -> &[ClosureDecl] {
        &[]
    }

    /// The bit of a kind of ray, such as `camera`, `shadow`, `diffuse`, `glossy`, `reflection` or `refraction`; 0, the default, if it
    /// is not known. `raytype` is true if [`Point::ray_kinds`] has the bit.
    fn ray_kind(&self, name: &str) -> u32 {
        let _ = name;
        0
    }

    /// The colour system of the shaders; by default Rec. 709.
    fn color_system(&self) -> &ColorSystem {
        static REC_709: LazyLock<ColorSystem> = LazyLock::new(ColorSystem::default);
        &REC_709
    }
}
