// SPDX-License-Identifier: GPL-3.0-or-later
//! Checks descriptions that programs make: array lengths, index ranges, ids.
//! Files are checked by their readers; this is for scenes made by code and by API calls.
//! Cost: one pass over the indices. Tests: `tests::finds_each_mistake`.

use crate::mesh::{Mesh, Rate};
use crate::primitives::{CurveForm, Primitives};
use crate::scene::Scene;

/// A mistake in a description, made by the caller.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{location}: {problem}")]
pub struct CheckError {
    /// Which value of the scene, such as `mesh 3 (door)`.
    pub location: String,
    /// The fault.
    pub problem: String,
}

impl Mesh {
    /// Checks that optional arrays are empty or full and that every index is in range; the error names the
    /// first fault.
    pub fn check(&self) -> Result<(), String> {
        let vertices = self.positions.len();
        let full = |what: &str, length: usize| match length == 0 || length == vertices {
            true => Ok(()),
            false => Err(format!("{length} {what} for {vertices} vertices")),
        };
        full("normals", self.normals.len())?;
        full("texture coordinates", self.texcoords.len())?;
        full("tangents", self.tangents.len())?;
        full("colours", self.colors.len())?;
        if let Some(bad) = self.indices.iter().position(|t| t.iter().any(|&i| i as usize >= vertices)) {
            let triangle = self.indices[bad];
            return Err(format!(
                "triangle {bad} has corners {triangle:?}, but there are {vertices} vertices"
            ));
        }
        self.check_primitives()?;
        for attribute in &self.attributes {
            let values = match attribute.rate {
                Rate::Triangle => self.primitive_count(),
                Rate::Vertex => vertices,
            };
            let (name, components, floats) =
                (&attribute.name, attribute.components as usize, attribute.data.len());
            if !(1..=16).contains(&components) {
                return Err(format!("attribute `{name}` has {components} components, not 1 to 16"));
            }
            if values.checked_mul(components) != Some(floats) {
                return Err(format!(
                    "attribute `{name}` has {floats} floats, not {values} times {components}"
                ));
            }
        }
        Ok(())
    }

    /// The first fault of its curves or spheres.
    fn check_primitives(&self) -> Result<(), String> {
        let vertices = self.positions.len();
        let radii = match &self.primitives {
            Primitives::Triangles => return Ok(()),
            Primitives::Curves(curves) => &curves.radii,
            Primitives::Spheres(radii) => radii,
        };
        if !self.indices.is_empty() {
            return Err("triangles beside curves or spheres: they need a mesh of their own".to_owned());
        }
        if radii.len() != vertices {
            return Err(format!("{} radii for {vertices} vertices", radii.len()));
        }
        let Primitives::Curves(curves) = &self.primitives else { return Ok(()) };
        if curves.form == CurveForm::Oriented && self.normals.len() != vertices {
            return Err(format!("{} normals of oriented curves for {vertices} vertices", self.normals.len()));
        }
        if !curves.spans.is_empty() && curves.spans.len() != curves.segments.len() {
            return Err(format!("{} spans for {} segments", curves.spans.len(), curves.segments.len()));
        }
        let order = curves.basis.order();
        let is_bad = |&first: &u32| first as usize + order > vertices;
        match curves.segments.iter().position(is_bad) {
            Some(bad) => Err(format!(
                "segment {bad} begins at vertex {} and takes {order}, but there are {vertices}",
                curves.segments[bad]
            )),
            None => Ok(()),
        }
    }
}

impl Scene {
    /// Whether every mesh is in order and every id points to something of this scene; the error is the first mistake.
    pub fn check(&self) -> Result<(), CheckError> {
        let at = |kind: &str, i: usize, name: &str| format!("{kind} {i} ({name})");
        let exists = |id: usize, count: usize, what: &str| match id < count {
            true => Ok(()),
            false => Err(format!("{what} {id} does not exist")),
        };
        let result = |location: String| move |problem| CheckError { location, problem };
        for (i, mesh) in self.meshes().iter().enumerate() {
            let checked =
                mesh.check().and_then(|()| exists(mesh.material.index(), self.materials().len(), "material"));
            checked.map_err(result(at("mesh", i, &mesh.name)))?;
        }
        for (i, object) in self.objects().iter().enumerate() {
            let mut meshes = object.meshes.iter();
            let checked = meshes.try_for_each(|mesh| exists(mesh.index(), self.meshes().len(), "mesh"));
            checked.map_err(result(at("object", i, &object.name)))?;
        }
        if let Err(error) = self.levels() {
            return Err(CheckError { location: "objects".to_owned(), problem: error.to_string() });
        }
        for (i, instance) in self.instances().iter().enumerate() {
            let checked = exists(instance.object.index(), self.objects().len(), "object");
            checked.map_err(result(at("instance", i, &instance.name)))?;
        }
        for (i, material) in self.materials().iter().enumerate() {
            let mut used = material.textures();
            let checked =
                used.try_for_each(|(t, _)| exists(t.texture.index(), self.textures().len(), "texture"));
            checked.map_err(result(at("material", i, &material.name)))?;
        }
        for (id, displacement) in self.displacements() {
            let i = id.index();
            let checked = exists(i, self.materials().len(), "material").and_then(|()| {
                let texture = displacement.texture();
                texture.map_or(Ok(()), |t| exists(t.texture.index(), self.textures().len(), "texture"))
            });
            checked.map_err(result(at("displacement of material", i, "")))?;
        }
        for (i, light) in self.lights().iter().enumerate() {
            if let Some(texture) = light.texture() {
                let checked = exists(texture.index(), self.textures().len(), "texture");
                checked.map_err(result(at("light", i, "environment")))?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::id::{MaterialId, MeshId, ObjectId, TextureId};
    use crate::material::{Material, TextureRef};
    use crate::primitives::{CurveBasis, Curves};
    use crate::{Affine, Attribute};

    fn good() -> Mesh {
        Mesh { positions: vec![[0.0; 3]; 3], indices: vec![[0, 1, 2]], ..Mesh::default() }
    }

    fn problem(edit: impl Fn(&mut Scene)) -> String {
        let mut scene = Scene::new();
        scene.add_material(Material::matte("m", [0.5; 3]));
        let mesh = scene.add_mesh(good());
        let object = scene.add_object_of("o", vec![mesh]);
        scene.instantiate(object, Affine::IDENTITY);
        scene.check().expect("good so far");
        edit(&mut scene);
        scene.check().expect_err("a mistake").to_string()
    }

    #[test]
    fn finds_each_mistake() {
        let mesh = |edit: fn(&mut Mesh)| problem(|s| edit(s.edit_mesh(MeshId(0))));
        assert!(mesh(|m| m.indices[0][2] = 3).starts_with("mesh 0 (): triangle 0"), "an index");
        assert!(mesh(|m| m.normals = vec![[0.0; 3]; 2]).contains("2 normals for 3 vertices"), "normals");
        assert!(mesh(|m| m.material = MaterialId(1)).contains("material 1 does not exist"), "a material");
        let attribute = mesh(|m| {
            m.attributes =
                vec![Attribute { name: "a".into(), rate: Rate::Triangle, components: 2, data: vec![0.0] }];
        });
        assert!(attribute.contains("attribute `a` has 1 floats, not 1 times 2"), "an attribute: {attribute}");
        assert!(problem(|s| _ = s.add_object_of("p", vec![MeshId(7)])).contains("object 1 (p)"), "a mesh id");
        let itself = |s: &mut Scene| {
            let member = crate::Member::new(ObjectId(0), Affine::IDENTITY);
            s.edit_object(ObjectId(0)).members.push(member);
        };
        assert!(problem(itself).starts_with("objects: object 0 holds itself"), "a circle");
        let bad = |s: &mut Scene| s.edit_instance(crate::InstanceId(0)).object = ObjectId(9);
        assert!(problem(bad).contains("object 9 does not exist"), "an object id");
    }

    #[test]
    fn finds_missing_textures() {
        let mut scene = Scene::new();
        let mut material = Material::matte("lamp", [0.5; 3]);
        material.emission_texture = Some(TextureRef::new(TextureId(4)));
        scene.add_material(material);
        let error = scene.check().expect_err("no such texture");
        assert_eq!(error.to_string(), "material 0 (lamp): texture 4 does not exist", "place and problem");
    }

    #[test]
    fn faults_of_curves_are_named() {
        let curves = Curves::of_strands(CurveBasis::BSpline, CurveForm::Round, [4]);
        let primitives = Primitives::Curves(Box::new(Curves { radii: vec![0.1; 4], ..curves }));
        let good = Mesh { positions: vec![[0.0; 3]; 4], primitives, ..Mesh::default() };
        good.check().expect("good so far");
        assert_eq!(good.corners(0), Some([1, 2, 1]), "between the middle vertices");
        let bad = |edit: fn(&mut Mesh)| {
            let mut mesh = good.clone();
            edit(&mut mesh);
            mesh.check().expect_err("a mistake")
        };
        assert!(bad(|m| _ = m.positions.pop()).contains("4 radii for 3 vertices"), "radii");
        assert!(bad(|m| m.indices.push([0; 3])).contains("mesh of their own"), "triangles");
        let segment = |m: &mut Mesh| {
            let Primitives::Curves(curves) = &mut m.primitives else { return };
            curves.segments[0] = 1;
        };
        assert!(bad(segment).contains("segment 0 begins at vertex 1 and takes 4"), "a segment");
        assert!(bad(|m| m.primitives = Primitives::Spheres(vec![1.0])).contains("1 radii"), "spheres");
    }
}
