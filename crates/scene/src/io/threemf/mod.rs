// SPDX-License-Identifier: GPL-3.0-or-later
//! 3MF: meshes and assemblies for 3D printing, in an archive of XML.
//! Source: 3MF Consortium, Core Specification 1.3 and Materials and Properties Extension 1.2 (colour groups),
//! Production Extension 1.1 (parts in several files). Units become metres, z upwards becomes y upwards. Each
//! object of the file becomes one of ours, an assembly one with members, each item to be built an instance. A
//! triangle has the colour of its first corner. Textures, composites and slices are left out with a warning.
//! Tests: `tests/solids.rs`.

mod model;
mod xml;
mod zip;

use std::collections::{BTreeMap, HashMap};
use std::path::Path;

use model::{Body, Model};

use super::clean::clean;
use super::format::Format;
use super::source::{self, Access};
use super::{Error, Loaded, Warnings};
use crate::affine::Affine;
use crate::id::{MaterialId, ObjectId};
use crate::material::{DEFAULT_ALBEDO, Material};
use crate::mesh::Mesh;
use crate::scene::{Member, Object, Scene};

/// Members in members that are followed.
const DEEPEST: usize = 32;

/// The format.
pub(super) const FORMAT: Format = Format {
    name: "3MF",
    extensions: &["3mf"],
    notes: "meshes, assemblies, colours; no textures, composites, slices",
    read: Some(load),
    read_whole: false,
    says_up: true,
    write: None,
};

/// The files of an archive that hold models, by their names in it.
type Models = HashMap<String, Model>;

fn load(path: &Path, access: &Access) -> Result<Loaded, Error> {
    let bytes = source::read(path)?;
    access.budget.add_file(bytes.len() as u64);
    let broken = || Error::data(path, None, "no archive", "expected a 3MF file, which is a ZIP archive");
    let parts = zip::parts(&bytes).ok_or_else(broken)?;
    let mut warnings = Warnings::default();
    let mut models = Models::new();
    let is_model = |name: &str| name.to_ascii_lowercase().ends_with(".model");
    for part in parts.iter().filter(|part| is_model(&part.name)) {
        let fault = |(problem, remedy): (String, &str)| Error::data(path, None, problem, remedy);
        let text = part.read(&access.budget).map_err(fault)?;
        let text = String::from_utf8_lossy(&text);
        let model = model::read(&text, &part.name, path, access, &mut warnings)?;
        models.insert(normal(&part.name), model);
    }
    let root = models.iter().filter(|(_, model)| !model.items.is_empty()).map(|(name, _)| name.clone()).min();
    let root = match root.or_else(|| models.keys().min().cloned()) {
        Some(root) => root,
        None => return Err(Error::data(path, None, "no model in the archive", "expected 3D/3dmodel.model")),
    };
    let mut builder = Builder {
        models: &models,
        path,
        scene: Scene::new(),
        made: HashMap::new(),
        materials: HashMap::new(),
    };
    let model = &models[&root];
    let metres = model.metres_per_unit;
    // x, z, -y.
    let upright = Affine { columns: [[metres, 0.0, 0.0], [0.0, 0.0, -metres], [0.0, metres, 0.0], [0.0; 3]] };
    for item in &model.items {
        let file = item.file.as_deref().map_or_else(|| root.clone(), normal);
        let object = builder.object(&file, item.object, 0, &mut warnings)?;
        builder.scene.instantiate(object, upright * item.transform);
    }
    Ok(Loaded { scene: builder.scene, warnings, files: vec![path.to_owned()] })
}

/// A name in the archive without its leading slash, in lower case, as names are compared.
fn normal(name: &str) -> String {
    name.trim_start_matches('/').to_lowercase()
}

/// The scene in the making.
struct Builder<'a> {
    models: &'a Models,
    path: &'a Path,
    scene: Scene,
    made: HashMap<(String, u32), ObjectId>,
    materials: HashMap<[u32; 4], MaterialId>,
}

impl Builder<'_> {
    fn object(
        &mut self,
        file: &str,
        id: u32,
        depth: usize,
        warnings: &mut Warnings,
    ) -> Result<ObjectId, Error> {
        let key = (file.to_owned(), id);
        if let Some(&known) = self.made.get(&key) {
            return Ok(known);
        }
        let wrong = |problem: String, remedy: &str| Error::data(self.path, None, problem, remedy);
        if depth > DEEPEST {
            return Err(wrong(format!("object {id} of {file}: assemblies too deep"), "expected 32 levels"));
        }
        let models = self.models;
        let object = models.get(file).and_then(|model| model.objects.get(&id));
        let object = object.ok_or_else(|| wrong(format!("object {id} of {file} does not exist"), ""))?;
        let made = match &object.body {
            Body::Mesh { positions, triangles } => {
                let meshes = self.meshes(&object.name, positions, triangles, warnings);
                let meshes = meshes.into_iter().map(|mesh| self.scene.add_mesh(mesh)).collect();
                self.scene.add_object_of(object.name.clone(), meshes)
            }
            Body::Components(components) => {
                let mut members = Vec::with_capacity(components.len());
                for component in components {
                    let file = component.file.as_deref().map_or_else(|| file.to_owned(), normal);
                    let part = self.object(&file, component.object, depth + 1, warnings)?;
                    members.push(Member::new(part, component.transform));
                }
                self.scene.add_object(Object { name: object.name.clone(), members, ..Object::default() })
            }
        };
        self.made.insert(key, made);
        Ok(made)
    }

    /// One mesh for each colour.
    fn meshes(
        &mut self,
        name: &str,
        positions: &[[f32; 3]],
        triangles: &[([u32; 3], Option<[f32; 4]>)],
        warnings: &mut Warnings,
    ) -> Vec<Mesh> {
        let mut by_material: BTreeMap<MaterialId, Vec<[u32; 3]>> = BTreeMap::new();
        for (triangle, color) in triangles {
            by_material.entry(self.material(*color)).or_default().push(*triangle);
        }
        let mesh = |(material, mut indices): (MaterialId, Vec<[u32; 3]>)| {
            // Only the vertices of these triangles.
            let mut own = HashMap::new();
            let mut kept = Vec::new();
            for corner in indices.iter_mut().flatten() {
                *corner = *own.entry(*corner).or_insert_with(|| {
                    kept.push(positions[*corner as usize]);
                    kept.len() as u32 - 1
                });
            }
            let name = name.to_owned();
            let mut mesh = Mesh { name, positions: kept, indices, material, ..Mesh::default() };
            clean(&mut mesh, self.path, warnings);
            mesh
        };
        by_material.into_iter().map(mesh).filter(|mesh| !mesh.indices.is_empty()).collect()
    }

    fn material(&mut self, color: Option<[f32; 4]>) -> MaterialId {
        let color = color.unwrap_or([DEFAULT_ALBEDO, DEFAULT_ALBEDO, DEFAULT_ALBEDO, 1.0]);
        let scene = &mut self.scene;
        *self.materials.entry(color.map(f32::to_bits)).or_insert_with(|| {
            let [r, g, b, _] = color;
            scene.add_material(Material::matte(format!("material {}", scene.materials().len()), [r, g, b]))
        })
    }
}
