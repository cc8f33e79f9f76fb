// SPDX-License-Identifier: GPL-3.0-or-later
//! The table of operations.
//! Source: the OSL specification, chapter 7; original. The library does the mathematics.

use super::machine::Action::{self, Map1, Map2, Map3, Whole};
use super::machine::D;
use super::slot::Slot;
use super::{
    arithmetic, assign, closure, dictionary, element, light, math, message, noise, points, print, space,
    state, texts, texture,
};
use crate::ir::{Op, Shader, ops};
use crate::types::{Base, Type};
use gnurt_sl_lib::math as lib;
use std::sync::Arc;

/// The action of an operation with these arguments; `None` if it is unknown.
pub(super) fn action(name: &str, args: &[Slot]) -> Option<Action> {
    let out = args.first().map_or(Type::VOID, |a| a.ty);
    let ints = args.iter().all(|a| a.ty == Type::INT);
    let matrix = args.iter().any(|a| a.ty == Type::MATRIX);
    if out == Type::CLOSURE && !matches!(name, "assign" | "aref") {
        return match name {
            "add" | "mul" | "closure" => Some(Whole(closure::closure)),
            _ => None,
        };
    }
    if matrix && matches!(name, "add" | "sub" | "mul" | "div" | "neg") {
        return Some(Whole(arithmetic::matrix));
    }
    if ints
        && args.len() > 1
        && let Some(action) = arithmetic::ints(name)
    {
        return Some(action);
    }
    plain(name).or_else(|| whole(name, out))
}

fn flat(f: fn(f32) -> f32, x: D) -> D {
    f(x.value).into()
}

/// Component by component.
fn plain(name: &str) -> Option<Action> {
    Some(match name {
        "add" => Map2(|a, b| a + b),
        "sub" => Map2(|a, b| a - b),
        "mul" => Map2(|a, b| a * b),
        "div" => Map2(lib::div),
        "neg" => Map1(|a| -a),
        "sin" => Map1(lib::sin),
        "cos" => Map1(lib::cos),
        "tan" => Map1(lib::tan),
        "asin" => Map1(lib::asin),
        "acos" => Map1(lib::acos),
        "atan" => Map1(lib::atan),
        "atan2" => Map2(lib::atan2),
        "sinh" => Map1(lib::sinh),
        "cosh" => Map1(lib::cosh),
        "tanh" => Map1(lib::tanh),
        "exp" => Map1(lib::exp),
        "exp2" => Map1(lib::exp2),
        "expm1" => Map1(lib::expm1),
        "log" => Map1(lib::log),
        "log2" => Map1(lib::log2),
        "log10" => Map1(lib::log10),
        "logb" => Map1(|x| flat(lib::logb, x)),
        "pow" => Map2(lib::pow),
        "sqrt" => Map1(lib::sqrt),
        "inversesqrt" => Map1(lib::inversesqrt),
        "cbrt" => Map1(lib::cbrt),
        "erf" => Map1(lib::erf),
        "erfc" => Map1(lib::erfc),
        "abs" | "fabs" => Map1(lib::abs),
        "sign" => Map1(|x| flat(lib::sign, x)),
        "floor" => Map1(|x| flat(lib::floor, x)),
        "ceil" => Map1(|x| flat(lib::ceil, x)),
        "round" => Map1(|x| flat(lib::round, x)),
        "trunc" => Map1(|x| flat(lib::trunc, x)),
        "fmod" | "mod" => Map2(lib::fmod),
        "min" => Map2(lib::min),
        "max" => Map2(lib::max),
        "step" => Map2(|edge, x| lib::step(edge.value, x.value).into()),
        "mix" => Map3(lib::mix),
        "select" => Map3(|x, y, c| lib::select(x, y, c.value)),
        "smoothstep" => Map3(lib::smoothstep),
        "clamp" => Map3(lib::clamp),
        _ => return None,
    })
}

fn whole(name: &str, out: Type) -> Option<Action> {
    Some(Whole(match name {
        "eq" | "neq" => arithmetic::equal,
        "lt" | "gt" | "le" | "ge" => arithmetic::ordered,
        "isnan" | "isinf" | "isfinite" => arithmetic::finite,
        "assign" => assign::assign,
        "arraycopy" => assign::array,
        "aref" => element::read_element,
        "aassign" => element::write_element,
        "compref" => element::read_component,
        "compassign" => element::write_component,
        "mxcompref" => element::read_matrix,
        "mxcompassign" => element::write_matrix,
        "arraylength" => element::length,
        "int" | "float" => assign::assign,
        "color" if out.base == Base::Color => space::color,
        "point" | "vector" | "normal" | "color" => space::triple,
        "matrix" => space::matrix,
        "getmatrix" => space::get_matrix,
        "transform" | "transformv" | "transformn" => space::transform,
        "transformu" => space::units,
        "transformc" => space::transform_color,
        "blackbody" => space::blackbody,
        "wavelength_color" => space::wavelength,
        "luminance" => space::luminance,
        "determinant" => math::determinant,
        "transpose" => math::transpose,
        "dot" => math::dot,
        "cross" => math::cross,
        "length" => math::length,
        "distance" => math::distance,
        "normalize" => math::normalize,
        "sincos" => math::sincos,
        "Dx" | "Dy" | "Dz" => math::derivative,
        "filterwidth" => math::filterwidth,
        "area" => math::area,
        "calculatenormal" => math::calculatenormal,
        "spline" => math::spline,
        "splineinverse" => math::splineinverse,
        "noise" | "snoise" | "pnoise" | "psnoise" | "cellnoise" | "hashnoise" => noise::noise,
        "hash" => noise::hash,
        "random" => noise::random,
        "printf" | "error" | "warning" | "fprintf" | "format" => print::print,
        "concat" => texts::concat,
        "strlen" => texts::strlen,
        "getchar" => texts::getchar,
        "startswith" => texts::startswith,
        "endswith" => texts::endswith,
        "substr" => texts::substr,
        "stoi" => texts::stoi,
        "stof" => texts::stof,
        "split" => texts::split,
        "regex_search" | "regex_match" => texts::regex,
        "setmessage" => message::set,
        "getmessage" => message::get,
        "getattribute" => state::get_attribute,
        "raytype" => state::raytype,
        "backfacing" => state::backfacing,
        "surfacearea" => state::surface_area,
        "isconnected" => state::is_connected,
        "isconstant" => state::is_constant,
        "trace" => light::trace,
        "lightcount" => light::count,
        "illuminate" => light::illuminate,
        "texture" => texture::texture,
        "environment" => texture::environment,
        "texture3d" => texture::texture3d,
        "gettextureinfo" => texture::info,
        "dict_find" => dictionary::find,
        "dict_next" => dictionary::next,
        "dict_value" => dictionary::value,
        "pointcloud_search" => points::search,
        "pointcloud_get" => points::get,
        "pointcloud_write" => points::write,
        "bump" | "displace" | "nop" | "end" | "useparam" => state::nothing,
        _ => return None,
    }))
}

/// The first operation of a shader that the interpreter does not support.
#[must_use]
pub fn unknown_operation(shader: &Shader) -> Option<Arc<str>> {
    let mut found = None;
    let mut visit = |op: &Op| {
        let control = matches!(&*op.name, "break" | "continue" | "return" | "exit");
        let args: Vec<Slot> = op.args.iter().map(|&id| Slot::new(0, shader.symbol(id).ty, false)).collect();
        if found.is_none() && !control && action(&op.name, &args).is_none() {
            found = Some(op.name.clone());
        }
    };
    for symbol in &shader.symbols {
        ops(&symbol.init, &mut visit);
    }
    ops(&shader.code, &mut visit);
    found
}
