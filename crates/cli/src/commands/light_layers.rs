// SPDX-License-Identifier: GPL-3.0-or-later
//! Layers of light of a call: those of `--layers`, and of the scene's light groups under `--light-groups`.
//! Tests: `tests/program/light_layers.rs`.

use gnurt::render::{LightLayer, RenderOptions, World, unknown_labels};
use gnurt::scene::Scene;

use crate::arguments::RenderArguments;
use crate::failure::{Failure, Outcome};
use crate::messages::Messages;

/// The options with a layer for each light group of the scene, if that is requested.
pub(super) fn with_groups(
    options: &RenderOptions,
    arguments: &RenderArguments,
    scene: &Scene,
    messages: Messages,
) -> RenderOptions {
    let mut options = options.clone();
    if arguments.light_groups {
        let groups = scene.labels().group_names();
        if groups.is_empty() {
            messages.warning(
                "--light-groups: no light has a group; give some, as by --set lights.NAME.group=key",
            );
        }
        let is_new = |layer: &LightLayer| options.light_layers.iter().all(|known| known.name != layer.name);
        let more: Vec<LightLayer> = LightLayer::of_groups(&groups).into_iter().filter(is_new).collect();
        options.light_layers.extend(more);
    }
    options
}

/// Rejects layers by names that nothing in the world has.
pub(super) fn check(world: &World, scene: &Scene, options: &RenderOptions) -> Outcome {
    if options.light_layers.is_empty() {
        return Ok(());
    }
    let unknown = unknown_labels(world, &options.light_layers).map_err(Failure::usage)?;
    let Some(label) = unknown.first() else { return Ok(()) };
    let groups = scene.labels().group_names();
    let groups = if groups.is_empty() { "none".into() } else { groups.join(", ") };
    Err(Failure::usage(format_args!(
        "--layers: no light, material or light group is called '{label}'; light groups are: {groups}"
    )))
}
