// SPDX-License-Identifier: GPL-3.0-or-later
//! A node's mesh in many instances: EXT_mesh_gpu_instancing. Source: that extension. Space: the node's.
//! Tests: `tests/gltf.rs`.

use super::accessor;
use super::document::Document;
use super::json::{Index, NodeInstances};
use gnurt_scene::Member;
use gnurt_scene::affine::Affine;
use gnurt_scene::animation::Trs;
use gnurt_scene::io::Error;

/// `node_from_instance` of each; `None` where the extension has none of its attributes.
pub(super) fn copies(
    document: &Document<'_>,
    from: &NodeInstances,
    node: Index,
) -> Result<Option<Vec<Affine>>, Error> {
    let transform = format!("nodes[{}].extensions.EXT_mesh_gpu_instancing", node.0);
    let read3 = |index: Option<Index>| {
        index.map(|index| accessor::floats::<3>(document, index, &transform, None)).transpose()
    };
    let attributes = &from.attributes;
    let translations = read3(attributes.translation)?;
    let rotations = attributes
        .rotation
        .map(|index| accessor::floats::<4>(document, index, &transform, None))
        .transpose()?;
    let scales = read3(attributes.scale)?;
    let counts = [
        translations.as_ref().map(Vec::len),
        rotations.as_ref().map(Vec::len),
        scales.as_ref().map(Vec::len),
    ];
    let mut there = counts.into_iter().flatten();
    let Some(count) = there.next() else { return Ok(None) };
    if there.any(|other| other != count) {
        let [t, r, s] = counts.map(|count| count.map_or_else(|| "no".to_owned(), |count| count.to_string()));
        let problem = format!("{t} TRANSLATION, {r} ROTATION and {s} SCALE values");
        return Err(document.error(&transform, problem, "expected as many of each"));
    }
    document.hold(count * size_of::<Member>(), &transform)?;
    let parts = |i: usize| Trs {
        translation: translations.as_ref().map_or([0.0; 3], |all| all[i].map(f64::from)),
        rotation: rotations.as_ref().map(|all| all[i].map(f64::from)),
        scale: scales.as_ref().map_or([1.0; 3], |all| all[i].map(f64::from)),
    };
    Ok(Some((0..count).map(|i| parts(i).affine()).collect()))
}
