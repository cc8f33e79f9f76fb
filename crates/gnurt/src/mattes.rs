// SPDX-License-Identifier: GPL-3.0-or-later
//! Metadata of Cryptomatte: for each kind of mattes its name, its hash and the names behind its ids.
//! Source: \[FJ16\], version 1.2.0: `cryptomatte/KEY/{name,hash,conversion,manifest}`; the key is the first seven digits of
//! the id of the layer's name. Invariant: a manifest lists the names in the picture, each with the id that its channels have.
//! Tests: `tests`, crates/cli/tests/program/mattes.rs.

use std::collections::{BTreeMap, BTreeSet};

use gnurt_image::{ChannelData, Picture};
use gnurt_render::{MatteKind, matte_id, matte_names};
use gnurt_scene::Scene;

/// The beginning of all names of metadata.
const PREFIX: &str = "cryptomatte/";
const MANIFEST: &str = "manifest";
/// Names and ids in hexadecimal digits.
type Manifest = BTreeMap<String, String>;

fn key(kind: MatteKind, what: &str) -> String {
    let id = format!("{:08x}", matte_id(kind.layer()));
    format!("{PREFIX}{}/{what}", &id[..7])
}

/// Writes the metadata of the mattes in a picture of a scene.
pub fn describe(picture: &mut Picture, scene: &Scene) {
    for kind in MatteKind::ALL {
        let ids = ids_in(picture, kind);
        let Some(ids) = ids else { continue };
        let names = matte_names(scene, kind, &ids);
        let manifest: Manifest = names.into_iter().map(|(name, id)| (name, format!("{id:08x}"))).collect();
        put(picture, kind, &manifest);
    }
}

fn put(picture: &mut Picture, kind: MatteKind, manifest: &Manifest) {
    let manifest = serde_json::to_string(manifest).unwrap_or_default();
    let all = [
        ("name", kind.layer()),
        ("hash", "MurmurHash3_32"),
        ("conversion", "uint32_to_float32"),
        (MANIFEST, &manifest),
    ];
    for (what, value) in all {
        picture.set_metadata(&key(kind, what), value);
    }
}

/// Adds the names of another part of the picture.
pub fn merge(picture: &mut Picture, part: &Picture) {
    for kind in MatteKind::ALL {
        let of = |picture: &Picture| -> Option<Manifest> {
            serde_json::from_str(picture.metadata(&key(kind, MANIFEST))?).ok()
        };
        let Some(more) = of(part) else { continue };
        let mut all = of(picture).unwrap_or_default();
        all.extend(more);
        put(picture, kind, &all);
    }
}

/// Whether a name of metadata is Cryptomatte's.
#[must_use]
pub fn is_metadata(name: &str) -> bool {
    name.starts_with(PREFIX)
}

/// Whether a layer of this name holds mattes.
#[must_use]
pub fn is_matte(layer: &str) -> bool {
    MatteKind::ALL.iter().any(|kind| is_of(layer, *kind))
}

/// Whether a layer holds mattes of a kind.
fn is_of(layer: &str, kind: MatteKind) -> bool {
    layer.strip_prefix(kind.layer()).is_some_and(|rest| rest.len() == 2 && rest.parse::<u8>().is_ok())
}

/// The ids in the layers of a kind; `None` if there are no such layers.
fn ids_in(picture: &Picture, kind: MatteKind) -> Option<BTreeSet<u32>> {
    let mut layers = picture.layers.iter().filter(|layer| is_of(&layer.name, kind)).peekable();
    layers.peek()?;
    let mut ids = BTreeSet::new();
    for layer in layers {
        for channel in layer.channels.iter().filter(|channel| matches!(&channel.name[..], "R" | "B")) {
            if let ChannelData::F32(values) = &channel.data {
                ids.extend(values.iter().map(|value| value.to_bits()).filter(|&id| id != 0));
            }
        }
    }
    Some(ids)
}

/// How much of each pixel a thing of a kind covers, by its name; `None` if the picture has no such mattes.
#[must_use]
pub fn matte(picture: &Picture, kind: MatteKind, name: &str) -> Option<Vec<f32>> {
    let id = matte_id(name);
    let mut covered: Option<Vec<f32>> = None;
    for layer in picture.layers.iter().filter(|layer| is_of(&layer.name, kind)) {
        let covered = covered.get_or_insert_with(|| vec![0.0; picture.pixel_count()]);
        for [id_channel, coverage] in [["R", "G"], ["B", "A"]] {
            let [ids, shares] = [id_channel, coverage].map(|name| layer.channel(name).map(|c| &c.data));
            let (Some(ChannelData::F32(ids)), Some(ChannelData::F32(shares))) = (ids, shares) else {
                continue;
            };
            for ((covered, found), share) in covered.iter_mut().zip(ids).zip(shares) {
                *covered += if found.to_bits() == id { *share } else { 0.0 };
            }
        }
    }
    covered
}

#[cfg(test)]
mod tests {
    use super::*;
    use gnurt_image::Layer;

    fn picture(id: u32) -> Picture {
        let mut picture = Picture::new(1, 1);
        let four = [("R", f32::from_bits(id)), ("G", 0.75), ("B", 0.0), ("A", 0.0)];
        picture.layers.push(Layer::floats("CryptoObject00", four.map(|(name, value)| (name, vec![value]))));
        picture
    }

    #[test]
    fn names_are_written_and_merged() {
        let mut scene = gnurt_scene::Scene::new();
        for name in ["a \"quoted\" ü", "other"] {
            let object = scene.add_object_of("", Vec::new());
            let id = scene.instantiate(object, gnurt_scene::Affine::IDENTITY);
            scene.edit_instance(id).name = name.into();
        }
        let mut first = picture(matte_id("a \"quoted\" ü"));
        describe(&mut first, &scene);
        let entry = |picture: &Picture, what: &str| {
            picture.metadata(&key(MatteKind::Object, what)).map(str::to_owned).expect("an entry")
        };
        assert_eq!(entry(&first, "name"), "CryptoObject");
        let id = format!("{:08x}", matte_id("a \"quoted\" ü"));
        assert_eq!(
            entry(&first, MANIFEST),
            format!("{{\"a \\\"quoted\\\" ü\":\"{id}\"}}"),
            "names in the picture"
        );
        let mut second = picture(matte_id("other"));
        describe(&mut second, &scene);
        merge(&mut first, &second);
        assert!(
            entry(&first, MANIFEST).contains("other") && entry(&first, MANIFEST).contains("quoted"),
            "both"
        );
        assert_eq!(matte(&second, MatteKind::Object, "other"), Some(vec![0.75]), "its share");
        assert_eq!(matte(&second, MatteKind::Asset, "other"), None, "no such layers");
        assert!(
            is_matte("CryptoAsset07")
                && !is_matte("CryptoAsset")
                && is_metadata(&key(MatteKind::Asset, "name"))
        );
    }
}
