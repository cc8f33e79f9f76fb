// SPDX-License-Identifier: GPL-3.0-or-later
//! STL, text and binary: triangles without anything else.
//! Source: 3D Systems, StereoLithography Interface Specification, 1989. A file is binary if its length is the
//! one that its count of triangles gives; many binary files begin with `solid`, as texts do. Equal corners
//! become one vertex. Normals in the file are ignored: the corners' order gives them. Units and the axis that
//! points upwards are not in the format. Tests: `tests/solids.rs`.

use std::collections::HashMap;
use std::path::Path;

use gnurt_image::Excess;

use super::clean::clean;
use super::error::quoted;
use super::format::{Format, SceneWriter};
use super::save::stl as save;
use super::source::{self, Access};
use super::{Error, Loaded, Oddity, Warnings};
use crate::affine::Affine;
use crate::material::{DEFAULT_ALBEDO, Material};
use crate::mesh::Mesh;
use crate::scene::Scene;

/// Bytes before the triangles of a binary file: a text, and their number.
const HEADER: usize = 84;
/// Bytes of a triangle of a binary file: normal, corners, two bytes without a meaning.
const TRIANGLE: usize = 50;

/// The format.
pub(super) const FORMAT: Format = Format {
    name: "STL",
    extensions: &["stl"],
    notes: "triangles only; `--up-axis z` for most",
    read: Some(load),
    read_whole: true,
    says_up: false,
    write: Some(SceneWriter {
        save: save::save,
        companions: |_, _| Vec::new(),
        has_materials: false,
        has_animations: false,
        has_strands: false,
        is_whole: true,
    }),
};

/// A mesh in the making, whose equal corners are one vertex.
struct Welder<'a> {
    mesh: Mesh,
    known: HashMap<[u32; 3], u32>,
    access: &'a Access,
    path: &'a Path,
}

impl Welder<'_> {
    fn add(&mut self, corners: [[f32; 3]; 3]) -> Result<(), Error> {
        let hold = |bytes| {
            let excess = |e: Excess| Error::data(self.path, None, e.to_string(), Excess::REMEDY);
            self.access.budget.hold(bytes).map_err(excess)
        };
        let mut triangle = [0; 3];
        for (to, corner) in triangle.iter_mut().zip(corners) {
            // Both zeros are one place.
            let key = corner.map(|x| (x + 0.0).to_bits());
            let next = self.mesh.positions.len() as u32;
            *to = match self.known.get(&key) {
                Some(&vertex) => vertex,
                None => {
                    hold(size_of::<[f32; 3]>() + 2 * size_of::<([u32; 3], u32)>())?;
                    self.known.insert(key, next);
                    self.mesh.positions.push(corner);
                    next
                }
            };
        }
        hold(size_of::<[u32; 3]>())?;
        self.mesh.indices.push(triangle);
        Ok(())
    }
}

fn load(path: &Path, access: &Access) -> Result<Loaded, Error> {
    let bytes = source::read(path)?;
    access.budget.add_file(bytes.len() as u64);
    let name = path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
    let mesh = Mesh { name: name.clone(), ..Mesh::default() };
    let mut welder = Welder { mesh, known: HashMap::new(), access, path };
    let count = bytes.get(80..HEADER).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    let length = count.map(|count| HEADER as u64 + u64::from(count) * TRIANGLE as u64);
    let is_text = bytes.trim_ascii_start().starts_with(b"solid");
    let mut warnings = Warnings::default();
    match length {
        Some(length) if length == bytes.len() as u64 || !is_text => {
            if length > bytes.len() as u64 {
                let problem = format!("{} triangles need {length} bytes", count.unwrap_or(0));
                let remedy = format!("the file has {}; it may have been cut off", bytes.len());
                return Err(Error::data(path, None, problem, remedy));
            }
            if length < bytes.len() as u64 {
                warnings.note(Oddity::TrailingData, path, None, "");
            }
            binary(&bytes[HEADER..length as usize], &mut welder)?;
        }
        _ if is_text => text(&bytes, path, &mut welder)?,
        _ => return Err(Error::data(path, None, "no STL file", "expected `solid` or a binary header")),
    }
    let Welder { mut mesh, known, .. } = welder;
    drop(known);
    clean(&mut mesh, path, &mut warnings);
    let mut scene = Scene::new();
    mesh.material = scene.add_material(Material::matte(name.clone(), [DEFAULT_ALBEDO; 3]));
    if !mesh.indices.is_empty() {
        let mesh = scene.add_mesh(mesh);
        let object = scene.add_object_of(name, vec![mesh]);
        scene.instantiate(object, Affine::IDENTITY);
    }
    Ok(Loaded { scene, warnings, files: vec![path.to_owned()] })
}

fn binary(bytes: &[u8], to: &mut Welder<'_>) -> Result<(), Error> {
    for triangle in bytes.chunks_exact(TRIANGLE) {
        let number = |k: usize| f32::from_le_bytes([0, 1, 2, 3].map(|i| triangle[4 * k + i]));
        to.add([3, 6, 9].map(|k| [number(k), number(k + 1), number(k + 2)]))?;
    }
    Ok(())
}

fn text(bytes: &[u8], path: &Path, to: &mut Welder<'_>) -> Result<(), Error> {
    let mut corners: Vec<[f32; 3]> = Vec::with_capacity(3);
    for (line, bytes) in (1..).zip(bytes.split(|&b| b == b'\n')) {
        let line_text = String::from_utf8_lossy(bytes);
        let wrong = |problem: String, remedy: &str| Err(Error::data(path, Some(line), problem, remedy));
        let mut words = line_text.split_ascii_whitespace();
        let Some(keyword) = words.next() else { continue };
        match keyword.to_ascii_lowercase().as_str() {
            "vertex" => {
                let mut number = || words.next()?.parse::<f32>().ok();
                let corner = (|| Some([number()?, number()?, number()?]))();
                let Some(corner) = corner else {
                    return wrong(quoted(line_text.trim()), "expected `vertex` and 3 numbers");
                };
                if corners.len() == 3 {
                    return wrong("facet with more than 3 corners".into(), "STL has triangles only");
                }
                corners.push(corner);
            }
            "endfacet" => {
                let [a, b, c] = corners[..] else {
                    return wrong(format!("facet with {} corners", corners.len()), "expected 3");
                };
                to.add([a, b, c])?;
                corners.clear();
            }
            "solid" | "facet" | "outer" | "endloop" | "endsolid" => {}
            _ => return wrong(format!("unknown keyword {}", quoted(keyword)), "expected STL's"),
        }
    }
    match corners.is_empty() {
        true => Ok(()),
        false => Err(Error::data(path, None, "facet without an end", "the file may have been cut off")),
    }
}
