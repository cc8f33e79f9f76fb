// SPDX-License-Identifier: GPL-3.0-or-later
//! The values that a world's surface shaders put out for layers.
//! Tests: crates/cli/tests/program/shader_outputs.rs.

use gnurt_shading::{OutputKind, ShaderOutput};

use crate::expressions::LightLayer;
use crate::world::World;

/// All outputs of a world's materials; those of one name have the form that holds them all.
#[must_use]
pub fn shader_outputs(world: &World) -> Vec<ShaderOutput> {
    let mut found: Vec<ShaderOutput> = Vec::new();
    for output in world.materials().shaders().flat_map(|shader| shader.outputs()) {
        match found.iter_mut().find(|known| known.name == output.name) {
            Some(known) => known.kind = known.kind.max(output.kind),
            None => found.push(output.clone()),
        }
    }
    found.sort_by(|a, b| a.name.cmp(&b.name));
    found
}

/// Why the layers cannot be made, if one asks for an output that no shader of the world has.
#[must_use]
pub fn missing_output(world: &World, layers: &[LightLayer]) -> Option<String> {
    let outputs = shader_outputs(world);
    let is_missing = |name: &&str| outputs.iter().all(|output| output.name != **name);
    let name = layers.iter().filter_map(LightLayer::output).find(is_missing)?;
    let names: Vec<&str> = outputs.iter().map(|output| &output.name[..]).collect();
    let names = if names.is_empty() { "none".into() } else { names.join(", ") };
    Some(format!("no shader of the scene has an output '{name}'; there are: {names}"))
}

/// The form of each layer; light is a colour.
pub(crate) fn kinds(world: &World, layers: &[LightLayer]) -> Vec<OutputKind> {
    if layers.iter().all(|layer| layer.output().is_none()) {
        return vec![OutputKind::Color; layers.len()];
    }
    let outputs = shader_outputs(world);
    let kind = |name: &str| outputs.iter().find(|output| output.name == name).map(|output| output.kind);
    layers.iter().map(|layer| layer.output().and_then(kind).unwrap_or(OutputKind::Color)).collect()
}
