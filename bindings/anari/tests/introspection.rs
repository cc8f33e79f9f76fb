// SPDX-License-Identifier: GPL-3.0-or-later
//! The device's own description matches its behaviour.

use anari_library_gnurt::ffi_client::Client;
use anari_library_gnurt::types as t;

const KINDS: [t::DataType; 15] = [
    t::DEVICE,
    t::ARRAY1D,
    t::ARRAY2D,
    t::ARRAY3D,
    t::CAMERA,
    t::FRAME,
    t::GEOMETRY,
    t::GROUP,
    t::INSTANCE,
    t::LIGHT,
    t::MATERIAL,
    t::RENDERER,
    t::SURFACE,
    t::SAMPLER,
    t::VOLUME,
];

/// All kinds with all subtypes.
fn all(client: &Client) -> Vec<(t::DataType, String)> {
    let of = |&kind: &t::DataType| {
        let subtypes = client.subtypes(kind);
        if subtypes.is_empty() {
            vec![(kind, String::new())]
        } else {
            subtypes.into_iter().map(|s| (kind, s)).collect()
        }
    };
    KINDS.iter().chain(&[t::SPATIAL_FIELD, t::WORLD]).flat_map(of).collect()
}

#[test]
fn subtypes_and_extensions_are_listed() {
    let client = Client::new();
    assert_eq!(
        client.subtypes(t::GEOMETRY),
        ["cone", "curve", "cylinder", "isosurface", "quad", "sphere", "triangle"]
    );
    assert_eq!(client.subtypes(t::LIGHT), ["directional", "hdri", "point", "quad", "ring", "spot"]);
    assert_eq!(client.subtypes(t::RENDERER), ["default", "ao", "eyelight", "debug"]);
    assert_eq!(client.subtypes(t::SURFACE), Vec::<String>::new());
    let extensions = client.extensions();
    assert!(
        extensions.len() > 40 && extensions.iter().all(|name| name.starts_with("ANARI_KHR_")),
        "{extensions:?}"
    );
    for (kind, subtype) in all(&client).iter().filter(|(_, subtype)| !subtype.is_empty() && subtype != "ao") {
        let object = client.object(*kind, subtype);
        assert_ne!(object, 0, "{subtype}");
        client.release(object);
    }
    assert!(client.messages().iter().all(|m| m.severity > 4), "all subtypes that are listed can be made");
}

/// Bytes of any value of a type, of defaults' form.
fn some(client: &Client, kind: t::DataType, held: &mut Vec<usize>) -> Vec<u8> {
    let of_object = match kind {
        t::ARRAY1D => Some(client.managed(t::FLOAT32_VEC4, &[1])),
        t::ARRAY2D => Some(client.managed(t::FLOAT32_VEC3, &[1, 1])),
        t::ARRAY3D => Some(client.managed(t::FLOAT32, &[1, 1, 1])),
        t::SAMPLER => Some(client.object(kind, "image1D")),
        t::SPATIAL_FIELD => Some(client.object(kind, "structuredRegular")),
        t::GEOMETRY => Some(client.object(kind, "sphere")),
        t::MATERIAL => Some(client.object(kind, "matte")),
        t::CAMERA => Some(client.object(kind, "perspective")),
        t::RENDERER => Some(client.object(kind, "default")),
        t::GROUP | t::WORLD => Some(client.object(kind, "")),
        _ => None,
    };
    match of_object {
        Some(object) => {
            held.push(object);
            object.to_ne_bytes().to_vec()
        }
        None => vec![0; t::size(kind).unwrap_or(8).max(8)],
    }
}

#[test]
fn every_parameter_of_every_object_can_be_set_and_committed() {
    let client = Client::new();
    let mut count = 0;
    for (kind, subtype) in all(&client) {
        let parameters = client.parameters(kind, &subtype);
        assert!(parameters.iter().any(|(name, _)| name == "name"), "{} '{subtype}'", t::name(kind));
        if [t::DEVICE, t::ARRAY1D, t::ARRAY2D, t::ARRAY3D].contains(&kind) {
            continue;
        }
        for (name, of) in parameters {
            let (object, mut held) = (client.object(kind, &subtype), Vec::new());
            let (who, _) = ((kind, subtype.as_str()), client.messages());
            let words = client.parameter_words(who, &name);
            match (of, words.first()) {
                (t::STRING, Some(word)) => client.set_text(object, &name, word),
                (t::STRING, None) => client.set_text(object, &name, "a word"),
                // Functions are not given here.
                (t::FRAME_COMPLETION_CALLBACK, _) => (),
                _ => client.set(object, &name, of, &some(&client, of, &mut held)),
            }
            let text = format!("{} '{subtype}' {name} {}", t::name(kind), t::name(of));
            // Elements of lists are any here: only types matter.
            let loud: Vec<_> = client
                .messages()
                .into_iter()
                .filter(|m| m.severity < 5 && !m.text.contains("elements of type"))
                .collect();
            assert!(loud.is_empty(), "{text}: {loud:?}");
            client.commit(object);
            client.unset(object, &name);
            client.commit(object);
            // A pointer fits nowhere.
            if of != t::VOID_POINTER {
                client.set(object, &name, t::UINT64_REGION4, &[0; 64]);
                let messages = client.messages();
                assert!(
                    messages.iter().any(|m| m.severity == 3 && m.text.contains(&format!("'{name}'"))),
                    "{text}: {messages:?}"
                );
            }
            held.push(object);
            held.iter().for_each(|&object| client.release(object));
            count += 1;
        }
    }
    assert!(count > 300, "{count} parameters");
    let _ = client.messages();
    assert_eq!(client.alive(), 0, "nothing is left");
}

#[test]
fn parameters_are_described() {
    let client = Client::new();
    for (kind, subtype) in all(&client) {
        for (name, of) in client.parameters(kind, &subtype) {
            let info =
                |property, info| client.parameter_info((kind, &subtype), (&name, of), (property, info));
            assert_ne!(info("description", t::STRING), 0, "{} '{subtype}' {name}", t::name(kind));
            assert_ne!(info("required", t::BOOL), 0, "{name}");
            assert_eq!(info("description", t::STRING), info("description", t::STRING), "answers stay");
            assert_eq!(info("colour", t::STRING), 0, "no such property");
        }
    }
    let float = |of: (t::DataType, &str), name: &str, property: &str| {
        let address = client.parameter_info(of, (name, t::FLOAT32), (property, t::FLOAT32));
        client.read_float(address)
    };
    assert_eq!(float((t::GEOMETRY, "sphere"), "radius", "default"), Some(1.0));
    assert_eq!(float((t::RENDERER, "default"), "ambientRadiance", "default"), Some(0.0));
    assert_eq!(float((t::MATERIAL, "physicallyBased"), "ior", "default"), Some(1.5));
    assert_eq!(float((t::MATERIAL, "physicallyBased"), "roughness", "maximum"), Some(1.0));
    assert_eq!(float((t::MATERIAL, "physicallyBased"), "baseColor", "default"), None, "no number");
    assert_eq!(client.parameter_words((t::GEOMETRY, "cone"), "caps"), ["none", "first", "second", "both"]);
}

#[test]
fn versions_and_limits_are_told() {
    let client = Client::new();
    let number = |name: &str| {
        client.property(client.device(), name, t::INT32).map(|b| i32::from_ne_bytes([b[0], b[1], b[2], b[3]]))
    };
    assert!(number("version").is_some_and(|version| version >= 100), "a version");
    assert!(client.property(client.device(), "geometryMaxIndex", t::UINT64).is_some(), "a limit");
    assert_eq!(number("colour"), None, "no such property");
}
