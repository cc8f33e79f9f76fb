// SPDX-License-Identifier: GPL-3.0-or-later
//! Checks that an animation made by a program fits its scene: indices are in range, arrays have the right
//! lengths. Files are checked by their readers, and by this once more. Cost: one pass. Tests:
//! `tests/animation.rs`.

use super::clip::{Channel, Target};
use super::model::{Animation, Attachment};
use crate::check::CheckError;
use crate::scene::Scene;

pub(super) fn check(animation: &Animation, scene: &Scene) -> Result<(), CheckError> {
    let at = |list: &str, i: usize| {
        let location = format!("animation {list} {i}");
        move |problem| CheckError { location, problem }
    };
    for (i, node) in animation.nodes.iter().enumerate() {
        on_node(&node.parent, i).map_err(at("node", i))?;
    }
    let nodes = animation.nodes.len();
    for (i, instance) in animation.instances.iter().enumerate() {
        exists("instance", instance.instance.index(), scene.instances().len())
            .and_then(|()| exists("node", instance.node as usize, nodes))
            .map_err(at("instance", i))?;
    }
    for (i, member) in animation.members.iter().enumerate() {
        let members = || scene.objects()[member.object.index()].members.len();
        exists("object", member.object.index(), scene.objects().len())
            .and_then(|()| exists("member", member.member as usize, members()))
            .and_then(|()| exists("node", member.node as usize, nodes))
            .map_err(at("member", i))?;
    }
    for (i, skin) in animation.skins.iter().enumerate() {
        let mut joints = skin.joints.iter();
        joints.try_for_each(|joint| on_node(&joint.attachment, nodes)).map_err(at("skin", i))?;
    }
    for i in 0..animation.bodies.len() {
        check_body(animation, i, scene).map_err(at("body", i))?;
    }
    for (i, camera) in animation.cameras.iter().enumerate() {
        exists("camera", camera.camera.index(), scene.cameras().len())
            .and_then(|()| on_node(&camera.attachment, nodes))
            .and_then(|()| {
                exists("field of view", camera.field_of_view as usize, animation.fields_of_view.len())
            })
            .map_err(at("camera", i))?;
    }
    for (i, light) in animation.lights.iter().enumerate() {
        exists("light", light.light.index(), scene.lights().len())
            .and_then(|()| on_node(&light.attachment, nodes))
            .and_then(|()| exists("light factors", light.factors as usize, animation.light_factors.len()))
            .map_err(at("light", i))?;
    }
    for (i, material) in animation.materials.iter().enumerate() {
        exists("material", material.material.index(), scene.materials().len()).map_err(at("material", i))?;
    }
    for (i, clip) in animation.clips.iter().enumerate() {
        let mut channels = clip.channels.iter();
        channels.try_for_each(|channel| check_channel(animation, channel)).map_err(at("clip", i))?;
    }
    Ok(())
}

fn exists(what: &str, number: usize, count: usize) -> Result<(), String> {
    if number < count { Ok(()) } else { Err(format!("{what} {number} does not exist")) }
}

/// Whether the node under it is among the first `count` nodes.
fn on_node(location: &Attachment, count: usize) -> Result<(), String> {
    match location {
        Attachment::On(node) if *node as usize >= count => {
            Err(format!("its parent node {node} does not precede it"))
        }
        _ => Ok(()),
    }
}

fn check_body(animation: &Animation, body: usize, scene: &Scene) -> Result<(), String> {
    let body = &animation.bodies[body];
    exists("mesh", body.mesh.index(), scene.meshes().len())?;
    body.base.check()?;
    let vertices = body.base.positions.len();
    for morph in &body.morphs {
        let most = [&morph.positions, &morph.normals, &morph.tangents].map(|deltas| deltas.vertices());
        if most.iter().any(|&count| count > vertices) {
            return Err(format!("a morph target has more than {vertices} vertices"));
        }
    }
    if let Some(set) = body.weights {
        exists("set of weights", set as usize, animation.weights.len())?;
    }
    let Some(skin) = body.skin else { return Ok(()) };
    exists("skin", skin as usize, animation.skins.len())?;
    let Some(influences) = &body.influences else { return Ok(()) };
    if influences.vertices() > vertices {
        return Err(format!("joints for {} of {vertices} vertices", influences.vertices()));
    }
    match influences.joints() as usize {
        0 => Ok(()),
        used => exists("joint", used - 1, animation.skins[skin as usize].joints.len()),
    }
}

fn check_channel(animation: &Animation, channel: &Channel) -> Result<(), String> {
    let node = |node: u32, width| exists("node", node as usize, animation.nodes.len()).map(|()| width);
    let set = |set: u32| {
        exists("set of weights", set as usize, animation.weights.len())
            .map(|()| animation.weights[set as usize].len())
    };
    let width = match channel.target {
        Target::Translation(n) | Target::Scale(n) => node(n, 3)?,
        Target::Rotation(n) => node(n, 4)?,
        Target::Visible(n) => node(n, 1)?,
        Target::Weights(s) => set(s)?,
        Target::Weight(s, weight) => {
            exists("weight", weight as usize, set(s)?)?;
            1
        }
        Target::FieldOfView(angle) => {
            exists("field of view", angle as usize, animation.fields_of_view.len())?;
            1
        }
        Target::Light(light, part) => {
            exists("light factors", light as usize, animation.light_factors.len())?;
            part.width()
        }
        Target::Material(material, part) => {
            exists("material", material as usize, animation.materials.len())?;
            part.width()
        }
    };
    match channel.sampler.width() {
        found if found == width => Ok(()),
        found => Err(format!("a value of {found} numbers drives one of {width}")),
    }
}
