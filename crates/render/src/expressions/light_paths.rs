// SPDX-License-Identifier: GPL-3.0-or-later
//! What a picture's paths are compared with: the automaton of its layers of light, and the classes of its world.
//! Tests: crates/render/tests/light_layers.rs.

use super::automaton::Automaton;
use super::classes::Classes;
use super::layer::{LightLayer, labels_of};
use super::syntax::ExpressionError;
use crate::world::World;

/// Automaton and classes.
#[derive(Debug)]
pub(crate) struct LightPaths {
    pub(crate) automaton: Automaton,
    pub(crate) classes: Classes,
}

impl LightPaths {
    /// For these layers of pictures of a world.
    pub(crate) fn new(world: &World, layers: &[LightLayer]) -> Result<Self, ExpressionError> {
        let (classes, alphabet) = Classes::of(world, labels_of(layers)?);
        let expressions: Vec<&str> = layers.iter().map(LightLayer::of_paths).collect();
        Ok(Self { automaton: Automaton::new(&expressions, &alphabet)?, classes })
    }
}

/// The labels in expressions of layers that nothing in the world has.
///
/// # Errors
/// The layers cannot be rendered for this world.
pub fn unknown_labels(world: &World, layers: &[LightLayer]) -> Result<Vec<String>, ExpressionError> {
    LightPaths::new(world, layers)?;
    let known = world.labels();
    let of_lights = known.lights.iter().chain([&known.environment]).chain(known.instances.values());
    let all = of_lights.chain(&known.materials);
    let has = |label: &str| {
        let (only, is_group) = label.strip_prefix('@').map_or((label, false), |rest| (rest, true));
        only.is_empty()
            || all.clone().any(|names| names.group.as_deref() == Some(only) || (!is_group && names.is(only)))
    };
    Ok(labels_of(layers)?.into_iter().filter(|label| !has(label)).collect())
}
