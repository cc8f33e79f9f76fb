// SPDX-License-Identifier: GPL-3.0-or-later
//! The artificial world: a square on which u and v vary, some spaces, attributes and closures.
//! The world is that of OSL's `testshade`.

use super::clouds::Clouds;
use super::options::Options;
use gnurt_sl::exec::{ClosureDecl, ClosureParam, Given, Host, Point, TextureOptions, TraceOptions};
use gnurt_sl::group::Value;
use gnurt_sl::hir::Data;
use gnurt_sl::stored::Textures;
use gnurt_sl::types::{Base, Type};
use gnurt_sl_lib::color::ColorSystem;
use gnurt_sl_lib::points::{Column, PointCloud};
use gnurt_sl_lib::{Dual, matrix as mx};
use std::f32::consts::{FRAC_PI_2, FRAC_PI_4};
use std::sync::Arc;

type Matrix = [[f32; 4]; 4];

const IDENTITY: Matrix =
    [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];

/// Kinds of rays; each is a bit.
const RAYS: [&str; 8] =
    ["camera", "shadow", "reflection", "refraction", "diffuse", "glossy", "subsurface", "displacement"];

/// The world.
pub(super) struct World<'a> {
    size: [usize; 2],
    userdata: Vec<(String, Value)>,
    closures: Vec<ClosureDecl>,
    colors: ColorSystem,
    textures: Option<&'a dyn Textures>,
    clouds: Clouds,
}

/// First rotated about z, then moved: rows are points.
fn turned(by: [f32; 3], angle: f32) -> Matrix {
    let (s, c) = angle.sin_cos();
    [[c, s, 0.0, 0.0], [-s, c, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [by[0], by[1], by[2], 1.0]]
}

const HITHER: f32 = 0.1;
const YON: f32 = 1000.0;
const FOV: f32 = 90.0;

impl<'a> World<'a> {
    pub(super) fn new(options: &Options, textures: Option<&'a dyn Textures>) -> Self {
        let name = if options.colorspace.is_empty() { "Rec709" } else { &options.colorspace };
        let colors = ColorSystem::named(name).or_else(|| ColorSystem::named("Rec709"));
        Self {
            size: options.size,
            userdata: options.userdata.clone(),
            closures: closures(),
            colors: match colors {
                Some(colors) => colors,
                None => unreachable!("Rec709 is known"),
            },
            textures,
            clouds: Clouds::default(),
        }
    }

    /// Writes the shaders' files at the end; returns the reasons of failures.
    pub(super) fn save(&self) -> Vec<String> {
        self.clouds.save()
    }

    /// The point of a pixel.
    pub(super) fn point(&self, o: &Options, x: usize, y: usize) -> Point {
        let [w, h] = self.size;
        let cell_index = |i: usize, n: usize, k: usize| {
            let at = match (o.centers, n) {
                (true, _) => (i as f32 + 0.5) / n as f32,
                (false, 1) => 0.5,
                _ => i as f32 / (n - 1) as f32,
            };
            o.scale[k] * at + o.offset[k]
        };
        let (u, v) = (cell_index(x, w, 0), cell_index(y, h, 1));
        let steps = |n: usize| if o.centers { n as f32 } else { (n.max(2) - 1) as f32 };
        let grid = |n: usize| (n.max(2) - 1) as f32;
        let du = if o.vary[1] { [1.0 - u, u] } else { [o.scale[0] / steps(w), 0.0] };
        let dv = if o.vary[2] { [1.0 - v, v] } else { [0.0, o.scale[1] / steps(h)] };
        let (dx, dy) = if o.vary[0] {
            ([1.0 - u, 1.0 - v, u * 0.5], [1.0 - v, 1.0 - u, v * 0.5])
        } else {
            ([o.scale[0] / grid(w), 0.0, 0.0], [0.0, o.scale[1] / grid(h), 0.0])
        };
        Point {
            p: Dual::new([u, v, 1.0], dx, dy),
            n: [0.0, 0.0, 1.0],
            ng: [0.0, 0.0, 1.0],
            u: Dual::new(u, du[0], du[1]),
            v: Dual::new(v, dv[0], dv[1]),
            dpdu: [1.0, 0.0, 0.0],
            dpdv: [0.0, 1.0, 0.0],
            surface_area: 1.0,
            ray_kinds: self.ray_kind(&o.raytype),
            index: (y * w + x) as i32,
            ..Point::default()
        }
    }

    /// From camera space on, to screen, NDC or raster space.
    fn projection(&self, space: &str) -> Option<Matrix> {
        let depth = (f64::from(YON) - f64::from(HITHER)) as f32;
        let t = (0.5 * FOV * std::f32::consts::PI / 180.0).tan();
        let screen = [
            [1.0 / t, 0.0, 0.0, 0.0],
            [0.0, 1.0 / t, 0.0, 0.0],
            [0.0, 0.0, YON / depth, 1.0],
            [0.0, 0.0, -YON * HITHER / depth, 0.0],
        ];
        let ndc = [[0.5, 0.0, 0.0, 0.0], [0.0, 0.5, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.5, 0.5, 0.0, 1.0]];
        let [w, h] = self.size.map(|n| n as f32);
        let raster = [[w, 0.0, 0.0, 0.0], [0.0, h, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];
        match space {
            "camera" => Some(IDENTITY),
            "screen" => Some(screen),
            "NDC" => Some(mx::multiply(&screen, &ndc)),
            "raster" => Some(mx::multiply(&mx::multiply(&screen, &ndc), &raster)),
            _ => None,
        }
    }
}

fn number(value: Dual<f32>) -> Given {
    Given { value: Data::Float(vec![value.value]), derivs: [vec![value.dx], vec![value.dy]] }
}

fn some(value: Data) -> Option<Given> {
    Some(Given::from(value))
}

impl Host for World<'_> {
    fn common_from(&self, space: &str, _: &Point) -> Option<Matrix> {
        match space {
            "shader" => Some(turned([1.0, 0.0, 0.0], FRAC_PI_4)),
            "object" => Some(turned([0.0, 1.0, 0.0], FRAC_PI_2)),
            "myspace" => {
                Some([[1.0, 0.0, 0.0, 0.0], [0.0, 2.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
            }
            "world" => Some(IDENTITY),
            _ => self.projection(space).map(|m| mx::inverse(&m)),
        }
    }

    fn to_common_inverse(&self, space: &str, point: &Point) -> Option<Matrix> {
        self.projection(space).or_else(|| self.common_from(space, point).map(|m| mx::inverse(&m)))
    }

    fn userdata(&self, name: &str, ty: Type, point: &Point) -> Option<Given> {
        let cell_index = point.p.value;
        match (name, ty) {
            ("face_idx", Type::INT) => return some(Data::Int(vec![(4.0 * point.u.value) as i32])),
            ("s", Type::FLOAT) => return Some(number(point.u)),
            ("t", Type::FLOAT) => return Some(number(point.v)),
            ("red", Type::FLOAT) if cell_index[0] > 0.5 => return Some(number(point.u)),
            ("green", Type::FLOAT) if cell_index[0] < 0.5 => return Some(number(point.v)),
            ("blue", Type::FLOAT) if (cell_index[1] * 12.0) as i32 % 2 == 0 => {
                return Some(number(Dual::new(1.0 - point.u.value, -point.u.dx, -point.u.dy)));
            }
            _ => {}
        }
        let (_, value) = self.userdata.iter().find(|(n, v)| n == name && v.ty == ty)?;
        some(value.data.clone())
    }

    fn attribute(
        &self,
        object: &str,
        name: &str,
        index: Option<i32>,
        ty: Type,
        point: &Point,
    ) -> Option<Given> {
        let float = |v: f32| if ty == Type::FLOAT { some(Data::Float(vec![v])) } else { None };
        let floats = |list: &[f32]| {
            let expected = Type::FLOAT.array_of(list.len() as i32);
            if ty == expected { some(Data::Float(list.to_vec())) } else { None }
        };
        match name {
            "osl:version" => {
                return if ty == Type::INT {
                    some(Data::Int(vec![gnurt_sl::VERSION_CODE as i32]))
                } else {
                    None
                };
            }
            "camera:resolution" => {
                let list = self.size.map(|n| n as i32).to_vec();
                return if ty == Type::INT.array_of(2) { some(Data::Int(list)) } else { None };
            }
            "camera:projection" => {
                return if ty == Type::STRING { some(Data::Str(vec!["perspective".into()])) } else { None };
            }
            "camera:pixelaspect" => return float(1.0),
            "camera:screen_window" => return floats(&[-1.0, -1.0, 1.0, 1.0]),
            "camera:fov" => return float(FOV),
            "camera:clip" => return floats(&[HITHER, YON]),
            "camera:clip_near" => return float(HITHER),
            "camera:clip_far" => return float(YON),
            "camera:shutter" => return floats(&[0.0, 1.0]),
            "camera:shutter_open" => return float(0.0),
            "camera:shutter_close" => return float(1.0),
            _ => {}
        }
        if object == "options" && name == "blahblah" && ty == Type::FLOAT {
            return some(Data::Float(vec![314_159.0 / 100_000.0]));
        }
        if object.is_empty() && name == "shading:index" && ty == Type::INT {
            return some(Data::Int(vec![point.index]));
        }
        if object.is_empty() && index.is_none() {
            return self.userdata(name, ty, point);
        }
        None
    }

    fn trace(&self, p: Dual<[f32; 3]>, r: Dual<[f32; 3]>, _: &TraceOptions, point: &Point) -> bool {
        let (p, r) = (p.value, r.value);
        point.u.value / (p[0] * r[0] + p[1] * r[1] + p[2] * r[2]) > 0.5
    }

    fn trace_message(&self, name: &str, ty: Type, point: &Point) -> (bool, Option<Given>) {
        let (u, v) = (point.u.value, point.v.value);
        let hit = u > 0.5;
        let given = match (name, ty) {
            ("hit", Type::INT) => some(Data::Int(vec![i32::from(hit)])),
            ("hitdist", Type::FLOAT) if hit => some(Data::Float(vec![0.5])),
            ("geom:name", Type::STRING) if hit => some(Data::Str(vec!["teapot".into()])),
            ("N", Type::NORMAL) if hit => some(Data::Float(vec![1.0 - v, 0.25, 1.0 - u])),
            _ => None,
        };
        (hit, given)
    }

    fn texture(
        &self,
        file: &str,
        at: [Dual<f32>; 2],
        options: &TextureOptions,
        _: &Point,
    ) -> Result<[Dual<f32>; 4], String> {
        self.textures.ok_or_else(no_pictures)?.texture(file, at, options)
    }

    fn environment(
        &self,
        file: &str,
        direction: [Dual<f32>; 3],
        options: &TextureOptions,
        _: &Point,
    ) -> Result<[Dual<f32>; 4], String> {
        self.textures.ok_or_else(no_pictures)?.environment(file, direction, options)
    }

    fn texture3d(
        &self,
        file: &str,
        at: [Dual<f32>; 3],
        options: &TextureOptions,
        _: &Point,
    ) -> Result<[Dual<f32>; 4], String> {
        self.textures.ok_or_else(no_pictures)?.texture3d(file, at, options)
    }

    fn texture_info(
        &self,
        file: &str,
        at: Option<[f32; 2]>,
        name: &str,
        ty: Type,
    ) -> Result<Option<Data>, String> {
        self.textures.ok_or_else(no_pictures)?.info(file, at, name, ty)
    }

    fn texture_fault(&self, requested: &str, why: &str, _: &str) -> String {
        format!("[RendererServices::{requested}] {why}")
    }

    /// OSL's messages have no places.
    fn with_place(&self, message: String, _: &str) -> String {
        message
    }

    fn point_cloud(&self, file: &str) -> Result<Arc<PointCloud>, String> {
        self.clouds.find(file)
    }

    fn write_point(&self, file: &str, cell_index: [f32; 3], row: &[Column]) -> Result<bool, String> {
        Ok(self.clouds.push(file, cell_index, row))
    }

    fn dictionary(&self, file: &str) -> Option<String> {
        std::fs::read_to_string(file).ok()
    }

    fn closures(&self) -> &[ClosureDecl] {
        &self.closures
    }

    fn ray_kind(&self, name: &str) -> u32 {
        RAYS.iter().position(|r| *r == name).map_or(0, |i| 1 << i)
    }

    fn color_system(&self) -> &ColorSystem {
        &self.colors
    }
}

fn no_pictures() -> String {
    "this program reads no pictures".to_owned()
}

/// The closures that are registered. Capitals are types: `V` vector, `F` float, `I` int, `C` colour, `S` text; `5` an array.
fn closures() -> Vec<ClosureDecl> {
    let table: [(&str, &str); 14] = [
        ("emission", ""),
        ("background", ""),
        ("diffuse", "V S:label"),
        ("oren_nayar", "V F"),
        ("translucent", "V"),
        ("phong", "V F S:label"),
        ("ward", "V V F F"),
        ("microfacet", "S V V F F F I"),
        ("reflection", "V F"),
        ("refraction", "V F"),
        ("transparent", ""),
        ("debug", "S"),
        ("holdout", ""),
        (
            "parameter_test",
            "I F C V S I5 V5 C5 F5 S5 I:int_key F:float_key C:color_key V:vector_key S:string_key",
        ),
    ];
    let param = |text: &str| {
        let (code, key) = match text.split_once(':') {
            Some((code, key)) => (code, Some(key)),
            None => (text, None),
        };
        let base = match code.as_bytes().first() {
            Some(b'V') => Base::Vector,
            Some(b'F') => Base::Float,
            Some(b'I') => Base::Int,
            Some(b'C') => Base::Color,
            _ => Base::String,
        };
        let ty = Type::of(base).array_of(if code.len() > 1 { 5 } else { 0 });
        key.map_or_else(|| ClosureParam::new("", ty), |key| ClosureParam::keyword(key, ty))
    };
    table
        .into_iter()
        .map(|(name, params)| ClosureDecl {
            name: name.into(),
            params: params.split_whitespace().map(param).collect(),
        })
        .collect()
}
