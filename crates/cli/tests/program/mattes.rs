// SPDX-License-Identifier: GPL-3.0-or-later
//! `gnurt render --layers cryptomatte`: metadata and layers in the file, pieces, films with an open shutter.

use gnurt::image::{Picture, read};
use gnurt::mattes::matte;
use gnurt::render::MatteKind;

use super::harness::Folder;

const SMALL: &str = "render builtin:cornell -r 40x32 --spp 4 --integrator path";

fn manifest(picture: &Picture, layer: &str) -> serde_json::Value {
    let names = picture.metadata.iter().filter(|(name, _)| name.ends_with("/name"));
    let (name, _) = names.clone().find(|(_, value)| value == layer).unwrap_or_else(|| panic!("{layer}"));
    let key = name.strip_suffix("/name").expect("a name");
    assert_eq!(key.len(), "cryptomatte/1234567".len(), "{key}");
    assert_eq!(picture.metadata(&format!("{key}/hash")), Some("MurmurHash3_32"));
    assert_eq!(picture.metadata(&format!("{key}/conversion")), Some("uint32_to_float32"));
    let text = picture.metadata(&format!("{key}/manifest")).expect("a manifest");
    serde_json::from_str(text).expect("an object")
}

#[test]
fn files_have_mattes_and_names() {
    let folder = Folder::new();
    let picture = |name: &str| read(&folder.at(name)).expect("a picture");
    folder.gnurt(&format!("{SMALL} --layers cryptomatte,normal --crypto-depth 4 -o whole.exr")).success();
    let whole = picture("whole.exr");
    let names: Vec<&str> = whole.layers.iter().map(|layer| layer.name.as_str()).collect();
    for name in ["CryptoObject00", "CryptoObject01", "CryptoMaterial01", "CryptoAsset01", "N"] {
        assert!(names.contains(&name), "{name}: {names:?}");
    }
    assert_eq!(names.len(), 7, "two of each kind, and normals: {names:?}");
    let materials = manifest(&whole, "CryptoMaterial");
    assert_eq!(materials["green"], format!("{:08x}", gnurt::render::matte_id("green")), "{materials}");
    let mut sum = vec![0.0; whole.pixel_count()];
    for (name, _) in materials.as_object().expect("names") {
        let shares = matte(&whole, MatteKind::Material, name).expect("mattes");
        sum.iter_mut().zip(shares).for_each(|(sum, share)| *sum += share);
    }
    for (sum, pixel) in sum.iter().zip(&whole.color) {
        assert!((sum - pixel[3]).abs() < 1e-6, "all that is not background has a name: {sum}, {pixel:?}");
    }
    for piece in [1, 2] {
        let layers = "--layers cryptomatte,normal --crypto-depth 4";
        folder.gnurt(&format!("{SMALL} {layers} --piece {piece}/2 -o p{piece}.exr")).success();
    }
    folder.gnurt("join p1.exr p2.exr -o joined.exr").success();
    let joined = picture("joined.exr");
    assert_eq!(manifest(&joined, "CryptoObject"), manifest(&whole, "CryptoObject"), "names of all pieces");
    let bits = |picture: &Picture| matte(picture, MatteKind::Material, "green").expect("mattes");
    assert_eq!(bits(&joined), bits(&whole), "and all pixels");
    folder.gnurt("convert whole.exr half.exr --bits 16").success();
    assert_eq!(bits(&picture("half.exr")), bits(&whole), "ids are not rounded");
    let refused = "--compression pxr24 rounds the ids";
    folder.gnurt("convert whole.exr o.exr --compression pxr24").fails(2, refused);
    folder.gnurt(&format!("{SMALL} --layers cryptomatte --crypto-depth 1 -o o.exr")).fails(2, "2");
}

#[test]
fn moving_things_have_moving_mattes() {
    let folder = Folder::new();
    super::animation::animated(&folder);
    let clip = "render a.gltf --animation slide -r 48x32 --spp 8 --at 0.2 --shutter 0.5 --integrator path";
    folder.gnurt(&format!("{clip} --layers crypto-object -o whole.exr")).success();
    let whole = read(&folder.at("whole.exr")).expect("a picture");
    let names = manifest(&whole, "CryptoObject");
    let names: Vec<&String> = names.as_object().expect("names").keys().collect();
    assert!(!names.is_empty(), "something is seen");
    let mut blurred = false;
    for name in &names {
        let shares = matte(&whole, MatteKind::Object, name).expect("mattes");
        let others = names.iter().filter(|other| other != &name);
        let hidden: String = others.map(|other| format!(" --set instances.{other}.visible=false")).collect();
        folder.gnurt(&format!("{clip}{hidden} --layers none -o alone.exr")).success();
        let alone = read(&folder.at("alone.exr")).expect("a picture");
        for (share, pixel) in shares.iter().zip(&alone.color) {
            assert!(*share <= pixel[3] + 1e-6, "{name}: {share} of {pixel:?}");
            blurred |= (0.1..0.9).contains(share);
        }
        if names.len() == 1 {
            assert!(shares.iter().zip(&alone.color).all(|(share, p)| (share - p[3]).abs() < 1e-6), "{name}");
        }
    }
    assert!(blurred, "edges move");
}
