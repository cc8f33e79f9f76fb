// SPDX-License-Identifier: GPL-3.0-or-later
//! The renderer as a running group sees it: live parameters first, then the renderer's answers.

use std::sync::Arc;

use gnurt_sl::exec::{
    Arriving, ClosureDecl, DualRow, Given, Host, LANES, Point, TextureOptions, TraceOptions,
    standard_closures,
};
use gnurt_sl::hir::Data;
use gnurt_sl::types::Type;
use gnurt_sl_lib::Dual;
use gnurt_sl_lib::color::ColorSystem;
use gnurt_sl_lib::points::{Column, PointCloud};

use crate::live::Live;

pub(crate) struct World<'a> {
    pub(crate) host: &'a dyn Host,
    pub(crate) live: &'a [Live],
}

type Direction = Dual<[f32; 3]>;

impl Host for World<'_> {
    fn userdata(&self, name: &str, ty: Type, point: &Point) -> Option<Given> {
        let live = self.live.iter().find_map(|live| live.given(name, ty));
        live.or_else(|| self.host.userdata(name, ty, point))
    }

    fn closures(&self) -> &[ClosureDecl] {
        let own = self.host.closures();
        if own.is_empty() { standard_closures() } else { own }
    }

    fn common_from(&self, space: &str, point: &Point) -> Option<[[f32; 4]; 4]> {
        self.host.common_from(space, point)
    }

    fn to_common_inverse(&self, space: &str, point: &Point) -> Option<[[f32; 4]; 4]> {
        self.host.to_common_inverse(space, point)
    }

    fn is_same_space(&self, space: &str, lanes: u32, index: &[i32; LANES]) -> bool {
        self.host.is_same_space(space, lanes, index)
    }

    fn attribute(
        &self,
        object: &str,
        name: &str,
        index: Option<i32>,
        ty: Type,
        point: &Point,
    ) -> Option<Given> {
        self.host.attribute(object, name, index, ty, point)
    }

    fn trace(&self, p: Direction, r: Direction, options: &TraceOptions, point: &Point) -> bool {
        self.host.trace(p, r, options, point)
    }

    fn radiance(&self, p: Direction, r: Direction, options: &TraceOptions, point: &Point) -> [f32; 3] {
        self.host.radiance(p, r, options, point)
    }

    fn light_count(&self) -> i32 {
        self.host.light_count()
    }

    fn illuminate(
        &self,
        light: i32,
        p: [f32; 3],
        category: &str,
        shadowed: bool,
        point: &Point,
    ) -> Option<Arriving> {
        self.host.illuminate(light, p, category, shadowed, point)
    }

    fn texture(
        &self,
        file: &str,
        at: [Dual<f32>; 2],
        options: &TextureOptions,
        point: &Point,
    ) -> Result<[Dual<f32>; 4], String> {
        self.host.texture(file, at, options, point)
    }

    fn textures(
        &self,
        file: &str,
        lanes: u32,
        at: &[DualRow; 2],
        options: &TextureOptions,
        out: &mut [DualRow; 4],
    ) -> bool {
        self.host.textures(file, lanes, at, options, out)
    }

    fn environment(
        &self,
        file: &str,
        direction: [Dual<f32>; 3],
        options: &TextureOptions,
        point: &Point,
    ) -> Result<[Dual<f32>; 4], String> {
        self.host.environment(file, direction, options, point)
    }

    fn texture3d(
        &self,
        file: &str,
        at: [Dual<f32>; 3],
        options: &TextureOptions,
        point: &Point,
    ) -> Result<[Dual<f32>; 4], String> {
        self.host.texture3d(file, at, options, point)
    }

    fn texture_info(
        &self,
        file: &str,
        at: Option<[f32; 2]>,
        name: &str,
        ty: Type,
    ) -> Result<Option<Data>, String> {
        self.host.texture_info(file, at, name, ty)
    }

    fn point_cloud(&self, file: &str) -> Result<Arc<PointCloud>, String> {
        self.host.point_cloud(file)
    }

    fn write_point(&self, file: &str, at: [f32; 3], row: &[Column]) -> Result<bool, String> {
        self.host.write_point(file, at, row)
    }

    fn texture_fault(&self, requested: &str, why: &str, at: &str) -> String {
        self.host.texture_fault(requested, why, at)
    }

    fn with_place(&self, message: String, place: &str) -> String {
        self.host.with_place(message, place)
    }

    fn dictionary(&self, file: &str) -> Option<String> {
        self.host.dictionary(file)
    }

    fn trace_message(&self, name: &str, ty: Type, point: &Point) -> (bool, Option<Given>) {
        self.host.trace_message(name, ty, point)
    }

    fn ray_kind(&self, name: &str) -> u32 {
        self.host.ray_kind(name)
    }

    fn color_system(&self) -> &ColorSystem {
        self.host.color_system()
    }
}
