// SPDX-License-Identifier: GPL-3.0-or-later
//! Clips as glTF's animations: channels of nodes, and pointers to everything else.
//! Source: glTF 2.0 section 3.11; KHR_animation_pointer, KHR_node_visibility. Keys of equal times, which glTF
//! does not have, are written an instant apart. Tests: `tests/save.rs::animations_are_written`.

use std::collections::HashMap;
use std::path::Path;

use serde_json::{Value, json};

use super::buffer::Buffer;
use super::nodes::Nodes;
use crate::factor_paths;
use gnurt_scene::animation::{Animation, Clip, Interpolation, LightPart, Sampler, Target};
use gnurt_scene::io::Warnings;
use gnurt_scene::io::writer::leave_out;

/// The animations of a document that has all else, with the objects that they point to.
pub(super) fn animations(
    animation: &Animation,
    nodes: &Nodes,
    document: &mut Value,
    buffer: &mut Buffer,
    (path, warnings): (&Path, &mut Warnings),
) -> Vec<Value> {
    let mut times = HashMap::new();
    let mut lost = 0;
    let mut made = Vec::new();
    for clip in &animation.clips {
        let (mut samplers, mut channels) = (Vec::new(), Vec::new());
        for channel in &clip.channels {
            let targets = targets(animation, nodes, channel.target, document);
            lost += usize::from(targets.is_empty());
            if targets.is_empty() {
                continue;
            }
            samplers.push(sampler(&channel.sampler, channel.target, &mut times, buffer));
            let number = samplers.len() - 1;
            channels.extend(targets.into_iter().map(|to| json!({ "sampler": number, "target": to })));
        }
        // Empty arrays are not allowed.
        if !channels.is_empty() {
            let Clip { name, .. } = clip;
            made.push(json!({ "name": name, "samplers": samplers, "channels": channels }));
        }
    }
    leave_out(lost, "channel of an animation", path, warnings);
    leave_out(animation.members.len(), "moving member of an object", path, warnings);
    made
}

/// The targets of a channel; a set of weights may be that of several nodes.
fn targets(animation: &Animation, nodes: &Nodes, target: Target, document: &mut Value) -> Vec<Value> {
    let node = |node: u32, path: &str| vec![json!({ "node": nodes.moving[node as usize], "path": path })];
    let weighted = |set: &u32| nodes.weighted.get(set).map_or(&[][..], |nodes| nodes);
    match target {
        Target::Translation(moving) => node(moving, "translation"),
        Target::Rotation(moving) => node(moving, "rotation"),
        Target::Scale(moving) => node(moving, "scale"),
        Target::Visible(moving) => {
            let node = nodes.moving[moving as usize];
            let extension = &mut document["nodes"][node]["extensions"];
            if extension["KHR_node_visibility"].is_null() {
                extension["KHR_node_visibility"] = json!({ "visible": true });
            }
            pointer(document, Some(format!("/nodes/{node}/extensions/KHR_node_visibility/visible")))
        }
        Target::Weights(set) => {
            weighted(&set).iter().map(|node| json!({ "node": node, "path": "weights" })).collect()
        }
        Target::Weight(set, weight) => {
            let all = weighted(&set).to_vec();
            for node in &all {
                document["nodes"][*node]["weights"] = json!(animation.weights[set as usize]);
            }
            let of = |node: &usize| pointer(document, Some(format!("/nodes/{node}/weights/{weight}")));
            all.iter().flat_map(of).collect()
        }
        Target::FieldOfView(angle) => {
            let camera = animation.cameras.iter().find(|camera| camera.field_of_view == angle);
            pointer(document, camera.map(|camera| format!("/cameras/{}/perspective/yfov", camera.camera.0)))
        }
        Target::Light(factors, part) => {
            let part = match part {
                LightPart::Color => "color",
                LightPart::Intensity => "intensity",
                LightPart::InnerAngle => "spot/innerConeAngle",
                LightPart::OuterAngle => "spot/outerConeAngle",
            };
            let light = nodes.light_factors.get(&factors);
            pointer(
                document,
                light.map(|light| format!("/extensions/KHR_lights_punctual/lights/{light}/{part}")),
            )
        }
        Target::Material(moving, part) => {
            let material = animation.materials[moving as usize].material.0;
            pointer(document, Some(format!("/materials/{material}/{}", factor_paths::path_of(part))))
        }
    }
}

/// The target of a pointer, if it has an object.
fn pointer(document: &mut Value, pointer: Option<String>) -> Vec<Value> {
    match pointer {
        Some(pointer) if make_parent(&pointer, document) => {
            let extension = json!({ "KHR_animation_pointer": { "pointer": pointer } });
            vec![json!({ "path": "pointer", "extensions": extension })]
        }
        _ => Vec::new(),
    }
}

/// Makes the extensions that a pointer names, with their defaults; whether the pointer then has an object.
fn make_parent(pointer: &str, document: &mut Value) -> bool {
    let Some((parent, _)) = pointer.rsplit_once('/') else { return false };
    let mut at = document;
    let mut is_extension = false;
    for name in parent.split('/').skip(1) {
        let next = match at {
            Value::Array(list) => name.parse::<usize>().ok().and_then(|i| list.get_mut(i)),
            Value::Object(map) => {
                if is_extension || name == "extensions" {
                    map.entry(name).or_insert_with(|| json!({}));
                }
                map.get_mut(name)
            }
            _ => None,
        };
        let Some(next) = next else { return false };
        is_extension = name == "extensions";
        at = next;
    }
    at.is_object() || at.is_array()
}

fn sampler(
    from: &Sampler,
    target: Target,
    known: &mut HashMap<(*const f32, usize), usize>,
    buffer: &mut Buffer,
) -> Value {
    let times = from.times();
    let input = *known.entry((times.as_ptr(), times.len())).or_insert_with(|| {
        let mut last = f32::NEG_INFINITY;
        let ascending: Vec<[f32; 1]> = times
            .iter()
            .map(|&time| {
                last = if time > last { time } else { last.next_up() };
                [last]
            })
            .collect();
        buffer.add_times(&ascending)
    });
    let is_flag = matches!(target, Target::Visible(_));
    let output = match (target, from.width()) {
        (Target::Visible(_), _) => buffer.add_flags(from.values()),
        (Target::Weights(_), _) => buffer.add_floats("SCALAR", from.values().as_chunks::<1>().0),
        // Rotations are of length 1; the tangents of splines are not.
        (Target::Rotation(_), _) if from.interpolation() != Interpolation::CubicSpline => {
            let keys = from.values().as_chunks::<4>().0;
            let unit =
                |q: &[f32; 4]| glam::Vec4::from(*q).try_normalize().unwrap_or(glam::Vec4::W).to_array();
            buffer.add_floats("VEC4", &keys.iter().map(unit).collect::<Vec<_>>())
        }
        (_, 2) => buffer.add_floats("VEC2", from.values().as_chunks::<2>().0),
        (_, 3) => buffer.add_floats("VEC3", from.values().as_chunks::<3>().0),
        (_, 4) => buffer.add_floats("VEC4", from.values().as_chunks::<4>().0),
        _ => buffer.add_floats("SCALAR", from.values().as_chunks::<1>().0),
    };
    let interpolation = match from.interpolation() {
        Interpolation::Linear if !is_flag => "LINEAR",
        Interpolation::CubicSpline if !is_flag => "CUBICSPLINE",
        _ => "STEP",
    };
    json!({ "input": input, "output": output, "interpolation": interpolation })
}
