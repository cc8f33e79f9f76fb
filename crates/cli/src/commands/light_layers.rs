// SPDX-License-Identifier: GPL-3.0-or-later
//! Layers of a call: those of `--layers`, or else those that the scene's file wants; and of its light groups under
//! `--light-groups`.
//! Tests: `tests/program/light_layers.rs`.

use gnurt::layers::{LayerList, layers};
use gnurt::render::{LightLayer, RenderOptions, World, missing_output, unknown_labels};
use gnurt::scene::Scene;

use crate::arguments::RenderArguments;
use crate::failure::{Failure, Outcome};
use crate::messages::Messages;

/// The layers that the scene's file wants, as far as the integrator has them.
fn of_file(
    options: &RenderOptions,
    arguments: &RenderArguments,
    scene: &Scene,
    messages: Messages,
) -> Option<LayerList> {
    let has_layers = arguments.output.as_deref().is_some_and(|path| {
        gnurt::image::PictureFormat::from_path(path).is_ok_and(|format| format.has_layers)
    });
    let outputs = &scene.labels().outputs;
    if outputs.is_empty() || arguments.layers.is_some() || !has_layers {
        return None;
    }
    match layers(&outputs.join(",")) {
        Ok(mut list) => {
            let all = list.light.len();
            list.light.retain(|layer| options.integrator.has_light_layer(layer));
            if list.light.len() < all {
                messages.warning(format_args!(
                    "--integrator {} lacks layers of light that the scene's file wants; path has them",
                    options.integrator
                ));
            }
            Some(list)
        }
        Err(why) => {
            messages.warning(format_args!("outputs of the scene's file: {why}"));
            None
        }
    }
}

/// The options with the layers of the scene's file, and a layer for each of its light groups if that is requested; and the
/// list of layers to keep.
pub(super) fn complete(
    options: &RenderOptions,
    arguments: &RenderArguments,
    scene: &Scene,
    messages: Messages,
) -> (RenderOptions, Option<LayerList>) {
    let mut options = options.clone();
    let list = arguments.layers.clone().or_else(|| of_file(&options, arguments, scene, messages));
    if let Some(list) = list.as_ref().filter(|_| arguments.layers.is_none()) {
        options.light_layers.clone_from(&list.light);
        options.mattes.kinds.clone_from(&list.mattes);
    }
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
    (options, list)
}

/// Rejects layers by names that nothing in the world has.
pub(super) fn check(world: &World, scene: &Scene, options: &RenderOptions) -> Outcome {
    if options.light_layers.is_empty() {
        return Ok(());
    }
    if let Some(why) = missing_output(world, &options.light_layers) {
        return Err(Failure::usage(format_args!("--layers: {why}")));
    }
    let unknown = unknown_labels(world, &options.light_layers).map_err(Failure::usage)?;
    let Some(label) = unknown.first() else { return Ok(()) };
    let groups = scene.labels().group_names();
    let groups = if groups.is_empty() { "none".into() } else { groups.join(", ") };
    Err(Failure::usage(format_args!(
        "--layers: no light, material or light group is called '{label}'; light groups are: {groups}"
    )))
}
