// SPDX-License-Identifier: GPL-3.0-or-later
//! Functions of the operations that are more than numbers.
//! Source: the OSL specification, chapter 7. Tests: `tests/meaning.rs`.

use super::compute::is_computed;
use super::machine::Action;
use super::slot::Slot;
use super::{
    closure, dictionary, direct, light, math, message, noise, points, print, space, state, texts, texture,
};
use crate::ir::Shader;
use crate::opcode::Opcode;
use crate::types::Type;
use std::sync::Arc;

/// The function of an operation with these arguments; `None` if there is none.
pub(super) fn action(code: Opcode, args: &[Slot]) -> Option<Action> {
    use Opcode as O;
    let out = args.first().map_or(Type::VOID, |a| a.ty);
    if out == Type::CLOSURE && !matches!(code, O::Assign | O::Aref) {
        return matches!(code, O::Add | O::Mul | O::Closure).then_some(closure::closure as Action);
    }
    if is_computed(code, args) {
        return Some(direct::action(code, args));
    }
    Some(match code {
        O::Color if out == Type::COLOR => space::color,
        O::Point | O::Vector | O::Normal | O::Color => space::triple,
        O::Matrix => space::matrix,
        O::Div => math::divide,
        O::GetMatrix => space::get_matrix,
        O::Transform | O::TransformV | O::TransformN => space::transform,
        O::TransformU => space::units,
        O::TransformC => space::transform_color,
        O::Blackbody => space::blackbody,
        O::WavelengthColor => space::wavelength,
        O::Luminance => space::luminance,
        O::Determinant => math::determinant,
        O::CalculateNormal => math::calculatenormal,
        O::Spline => math::spline,
        O::SplineInverse => math::splineinverse,
        O::Hash => noise::hash,
        O::Random => noise::random,
        O::Printf | O::Error | O::Warning | O::Fprintf | O::Format => print::print,
        O::Concat => texts::concat,
        O::Strlen => texts::strlen,
        O::Getchar => texts::getchar,
        O::Startswith => texts::startswith,
        O::Endswith => texts::endswith,
        O::Substr => texts::substr,
        O::Stoi => texts::stoi,
        O::Stof => texts::stof,
        O::Split => texts::split,
        O::RegexSearch | O::RegexMatch => texts::regex,
        O::SetMessage => message::set,
        O::GetMessage => message::get,
        O::GetAttribute => state::get_attribute,
        O::RayType => state::raytype,
        O::Backfacing => state::backfacing,
        O::SurfaceArea => state::surface_area,
        O::Trace => light::trace,
        O::LightCount => light::count,
        O::Illuminate => light::illuminate,
        O::Texture => texture::texture,
        O::Environment => texture::environment,
        O::Texture3d => texture::texture3d,
        O::GetTextureInfo => texture::info,
        O::DictFind => dictionary::find,
        O::DictNext => dictionary::next,
        O::DictValue => dictionary::value,
        O::PointcloudSearch => points::search,
        O::PointcloudGet => points::get,
        O::PointcloudWrite => points::write,
        // What its operands are is nothing that it could do.
        code if code.is_computed() => state::nothing,
        _ => return None,
    })
}

/// The first operation of a shader that is unknown.
#[must_use]
pub fn unknown_operation(shader: &Shader) -> Option<Arc<str>> {
    shader.unknown.clone()
}
