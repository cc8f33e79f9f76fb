// SPDX-License-Identifier: GPL-3.0-or-later
//! Meshes: polygons and subdivision surfaces, cut by the materials of their faces.
//! Source: UsdGeomMesh, UsdGeomSubset. Space: that of the prim. Tests: `tests/meshes.rs`, `tests/judge.py`.

use std::borrow::Cow;

use gnurt_scene::io::Oddity;
use gnurt_scene::io::reader::{Excess, clean_by};
use gnurt_scene::labels::ControlMesh;
use gnurt_scene::subdivision::{
    Boundary, Channel, Faces, LEVEL, MOST_TRIANGLES, Scheme, Surface, affordable_level, refine,
    smooth_normals,
};
use gnurt_scene::{Mesh, MeshId, ObjectId};
use openusd::sdf::Path;

use crate::attributes::{Attribute, Elements, Spread};
use crate::bent::Bent;
use crate::builder::Builder;
use crate::contents::Contents;
use crate::material::Use;
use crate::value;
use crate::weld::Corners;

/// Triangles beyond which a surface is refined less often, unless `--subdivision` says how often.
const DENSE: u64 = 250_000;

/// The level of displaced surfaces, and the triangles up to which they have it.
const DISPLACED: (u32, u64) = (LEVEL + 3, 4 * DENSE);

/// The polygons of a mesh as they are read.
pub(crate) struct Polygons {
    pub(crate) points: Vec<[f32; 3]>,
    pub(crate) faces: Faces,
}

/// Faces that one material covers.
struct Part {
    material: Use,
    /// By face of the control mesh: whether it is in the part.
    takes: Vec<bool>,
    is_subset: bool,
}

/// Normals, colours and opacities.
type Looks = [Option<Attribute>; 3];

impl Builder<'_> {
    /// The object of a mesh; `None` where there is nothing to show.
    ///
    /// `bent`: its points where something moves them, and the turns of its normals.
    pub(crate) fn mesh(&mut self, prim: &Path, bent: Option<Bent>) -> Option<ObjectId> {
        let varying = self.reader.varying();
        let mut polygons = self.polygons(prim)?;
        if let Some(bent) = &bent {
            polygons.points.clone_from(&bent.points);
        }
        let bound = self.bound(prim);
        self.polygon_object(prim, polygons, bound, bent, varying)
    }

    /// Points and faces, or a warning.
    pub(crate) fn polygons(&self, prim: &Path) -> Option<Polygons> {
        let reader = self.reader;
        let [corners, counts, points] =
            reader.values(prim, ["faceVertexIndices", "faceVertexCounts", "points"]);
        let points = points.and_then(value::into_points);
        let [counts, corners] = [counts, corners].map(|value| value.and_then(value::into_integers));
        let (Some(points), Some(counts), Some(corners)) = (points, counts, corners) else {
            // A mesh without points is a place for some to come.
            return None;
        };
        match Faces::of(&counts, corners, points.len()) {
            Ok(faces) if faces.is_empty() => None,
            Ok(faces) => Some(Polygons { points, faces }),
            Err(fault) => {
                reader.note(Oddity::BadMesh, prim, fault);
                None
            }
        }
    }

    fn polygon_object(
        &mut self,
        prim: &Path,
        polygons: Polygons,
        bound: Option<Path>,
        bent: Option<Bent>,
        varying: u64,
    ) -> Option<ObjectId> {
        let reader = self.reader;
        let Polygons { mut points, mut faces } = polygons;
        let mut looks = self.looks(prim, &faces);
        let is_bent = bent.is_some();
        if let (Some(bent), Some(normals)) = (bent, &mut looks[0]) {
            bent.rotate(&faces, normals);
        }
        let [_, colors, opacities] = &looks;
        let has = (colors.is_some(), opacities.is_some());
        let parts = self.parts(prim, &faces, bound.as_ref(), has);
        let materials: Vec<_> = parts.iter().map(|part| part.material.id).collect();
        let key = if is_bent || self.is_prototype { None } else { self.shared_key(prim, &materials) };
        if let Some(&known) = key.as_ref().and_then(|key| self.objects.get(key)) {
            return Some(known);
        }
        let texcoords: Vec<Option<Attribute>> =
            parts.iter().map(|part| self.texcoords(prim, &faces, &part.material)).collect();
        let holes = reader.value(prim, "holeIndices").as_ref().and_then(value::integers).unwrap_or_default();
        let mut is_hole = vec![false; faces.len()];
        for &hole in &holes {
            if let Some(hole) = usize::try_from(hole).ok().and_then(|hole| is_hole.get_mut(hole)) {
                *hole = true;
            }
        }
        let is_left_handed = reader.word(prim, "orientation").as_deref() == Some("leftHanded");
        let surface = self.surface(prim, &faces);
        let linear = reader.word(prim, "faceVaryingLinearInterpolation");
        let mut attributes: Vec<Option<Attribute>> = looks.into_iter().chain(texcoords).collect();
        let mut contents = Contents::new();
        contents.add(&(prim.name(), &materials, bound.as_ref().and_then(Path::name)));
        contents.add(&(is_left_handed, &linear));
        contents.add(&holes);
        contents.add_floats(points.as_flattened());
        contents.add_faces(&faces);
        attributes.iter().for_each(|attribute| contents.add_attribute(attribute.as_ref()));
        for part in &parts {
            contents.add(&part.material.has_colors);
            if parts.len() > 1 {
                contents.add_flags(&part.takes);
            }
        }
        contents.add_surface(surface.as_ref());
        // Equal now is not equal later: motion asks for the same objects at all moments.
        let contents =
            (!is_bent && !self.is_prototype && reader.varying() == varying).then(|| contents.sum());
        if let Some(&known) = contents.as_ref().and_then(|contents| self.equal.get(contents)) {
            return Some(known);
        }
        let mut parents: Option<Vec<u32>> = None;
        let shown = faces.iter().zip(&is_hole).filter(|(_, is_hole)| !**is_hole);
        let control_triangles: u64 = shown.map(|(corners, _)| corners.len() as u64 - 2).sum();
        let mut control = None;
        if let Some(surface) = surface {
            let requested = reader.files.access.subdivision;
            // Displacement is as fine as the triangles that it moves.
            let is_displaced = parts.iter().any(|part| part.material.is_displaced);
            let usual = if is_displaced { DISPLACED } else { (LEVEL, DENSE) };
            let (level, most) = requested.map_or(usual, |level| (level, MOST_TRIANGLES));
            let most = most.min(reader.files.access.budget.left() / 256);
            let level = affordable_level(&faces, level, most);
            let mut channels = vec![Channel {
                width: 3,
                values: points.as_flattened().to_vec(),
                corners: None,
                is_linear: false,
            }];
            let of_attributes: Vec<Option<Channel>> =
                attributes.iter().map(|attribute| attribute.as_ref()?.channel()).collect();
            channels.extend(of_attributes.iter().flatten().cloned());
            if linear.as_deref() == Some("all") {
                channels.iter_mut().filter(|c| c.corners.is_some()).for_each(|c| c.is_linear = true);
            }
            let mut refined = refine(&surface, channels, level);
            let mut channels = std::mem::take(&mut refined.channels).into_iter();
            let values = channels.next().map(|channel| channel.values).unwrap_or_default();
            points = values.chunks_exact(3).map(|p| [p[0], p[1], p[2]]).collect();
            for (attribute, channel) in attributes.iter_mut().zip(of_attributes) {
                let channel = channel.and_then(|_| channels.next());
                *attribute = attribute.take().map(|attribute| attribute.refined(&refined, channel));
            }
            if surface.scheme != Scheme::Bilinear {
                let (corners, normals) = smooth_normals(&refined.faces, &points, &refined.creases);
                let spread = Spread::Corners(Elements::Listed(corners));
                attributes[0] = Some(Attribute { width: 3, values: normals.into_flattened(), spread });
            }
            let scheme = match surface.scheme {
                Scheme::CatmullClark => "catmullClark",
                Scheme::Loop => "loop",
                Scheme::Bilinear => "bilinear",
            };
            control = Some(ControlMesh { scheme, level, triangles: control_triangles });
            (faces, parents) = (refined.faces, Some(refined.parents));
        }
        if is_left_handed && control.is_some() {
            // Normals of faces that run the other way.
            let normals = attributes[0].iter_mut().flat_map(|attribute| &mut attribute.values);
            normals.for_each(|x| *x = -*x);
        }
        let triangles: usize = faces.iter().map(|corners| corners.len() - 2).sum();
        if let Err(excess) = reader.files.access.budget.hold(triangles.saturating_mul(3 * 48)) {
            reader.note(Oddity::BadMesh, prim, format_args!("{excess}; {}", Excess::REMEDY));
            return None;
        }
        let mut meshes: Vec<MeshId> = Vec::new();
        let has_parts = parts.len() > 1;
        for (i, part) in parts.iter().enumerate() {
            let corners = Corners {
                faces: &faces,
                points: if has_parts {
                    Cow::Borrowed(&points[..])
                } else {
                    Cow::Owned(std::mem::take(&mut points))
                },
                normals: attributes[0].as_ref(),
                texcoords: attributes[3 + i].as_ref(),
                colors: attributes[1].as_ref().filter(|_| part.material.has_colors),
                opacities: attributes[2].as_ref().filter(|_| part.material.has_colors),
                is_left_handed,
                is_whole: holes.is_empty() && !part.takes.contains(&false),
            };
            let control_face = |face: usize| parents.as_ref().map_or(face, |parents| parents[face] as usize);
            let mut mesh = corners.mesh(&mut self.cutter, |face| {
                let face = control_face(face);
                part.takes[face] && !is_hole[face]
            });
            mesh.material = part.material.id;
            mesh.name = prim.name().unwrap_or_default().to_owned();
            meshes.extend(self.add_mesh(mesh));
        }
        if meshes.is_empty() {
            return None;
        }
        let object = self.scene.add_object_of(prim.as_str(), meshes);
        match control {
            Some(control) => _ = self.scene.labels_mut().control_meshes.insert(object, control),
            None => {
                let ids = &self.scene.object(object).meshes;
                let left: u64 = ids.iter().map(|&id| self.scene.mesh(id).indices.len() as u64).sum();
                let flat = control_triangles.saturating_sub(left);
                if flat > 0 {
                    self.scene.labels_mut().flat_triangles.insert(object, flat);
                }
            }
        }
        let has_subsets = parts.len() > 1 || parts.iter().any(|part| part.is_subset);
        if has_subsets {
            let name = bound.as_ref().and_then(Path::name).unwrap_or_default().to_owned();
            self.scene.labels_mut().bound_materials.insert(object, name);
        }
        if let Some(key) = key {
            self.objects.insert(key, object);
        }
        if let Some(contents) = contents {
            self.equal.insert(contents, object);
        }
        Some(object)
    }

    /// Adds a mesh unless nothing of it is left to be seen.
    pub(crate) fn add_mesh(&mut self, mut mesh: Mesh) -> Option<MeshId> {
        let threads = self.reader.files.access.threads();
        clean_by(&mut mesh, &self.reader.path, &mut self.reader.warnings(), threads);
        (mesh.primitive_count() > 0).then(|| self.scene.add_mesh(mesh))
    }

    /// The control mesh of a subdivision surface; `None` of polygons.
    fn surface(&self, prim: &Path, faces: &Faces) -> Option<Surface> {
        let reader = self.reader;
        let scheme = match reader.word(prim, "subdivisionScheme").as_deref() {
            None | Some("catmullClark") => Scheme::CatmullClark,
            Some("bilinear") => Scheme::Bilinear,
            Some("loop") if faces.iter().all(|corners| corners.len() == 3) => Scheme::Loop,
            Some("loop") => {
                reader.unsupported(
                    prim,
                    "subdivision by 'loop' of faces that are no triangles, shown as polygons",
                );
                return None;
            }
            Some("none") => return None,
            Some(other) => {
                reader.unsupported(prim, format_args!("subdivision by '{other}', shown as polygons"));
                return None;
            }
        };
        let boundary = match reader.word(prim, "interpolateBoundary").as_deref() {
            Some("none") => Boundary::None,
            Some("edgeOnly") => Boundary::EdgeOnly,
            _ => Boundary::EdgeAndCorner,
        };
        let integers =
            |name: &str| reader.value(prim, name).as_ref().and_then(value::integers).unwrap_or_default();
        let numbers = |name: &str| {
            reader.value(prim, name).as_ref().and_then(value::floats).map(|(_, v)| v).unwrap_or_default()
        };
        let (lengths, chain, sharpnesses) =
            (integers("creaseLengths"), integers("creaseIndices"), numbers("creaseSharpnesses"));
        let mut creases = Vec::new();
        let (mut at, mut edge) = (0, 0);
        // One sharpness for each chain, or one for each edge.
        let is_per_chain = sharpnesses.len() == lengths.len();
        for (i, &length) in lengths.iter().enumerate() {
            let end = (at + usize::try_from(length).unwrap_or(0)).min(chain.len());
            for pair in chain[at..end].windows(2) {
                let sharpness = sharpnesses.get(if is_per_chain { i } else { edge }).copied().unwrap_or(0.0);
                edge += 1;
                if let (Ok(a), Ok(b)) = (u32::try_from(pair[0]), u32::try_from(pair[1])) {
                    creases.push(([a, b], sharpness));
                }
            }
            at = end;
        }
        let corners = integers("cornerIndices").into_iter().zip(numbers("cornerSharpnesses"));
        let corners =
            corners.filter_map(|(vertex, sharpness)| Some((u32::try_from(vertex).ok()?, sharpness)));
        Some(Surface { scheme, boundary, faces: faces.clone(), creases, corners: corners.collect() })
    }

    fn looks(&self, prim: &Path, faces: &Faces) -> Looks {
        let reader = self.reader;
        let is_smooth = reader.word(prim, "subdivisionScheme").is_none_or(|scheme| scheme != "none");
        let normals = if is_smooth {
            None
        } else {
            let of = |name: &str, fallback: &str| reader.attribute(prim, name, faces, 3..=3, fallback);
            of("primvars:normals", "constant").or_else(|| of("normals", "vertex"))
        };
        let inherited = |name: &str, widths: std::ops::RangeInclusive<usize>| {
            let own = reader.value(prim, name).is_some();
            if own {
                return reader.attribute(prim, name, faces, widths, "constant");
            }
            // Values for all of a mesh are those of ancestors, too.
            prim.strict_ancestors().take_while(|above| !above.is_abs_root()).find_map(|above| {
                let found = reader.value(&above, name)?;
                let (width, values) = value::floats(&found).filter(|(width, _)| widths.contains(width))?;
                (values.len() == width).then_some(Attribute { width, values, spread: Spread::Constant })
            })
        };
        [normals, inherited("primvars:displayColor", 3..=4), inherited("primvars:displayOpacity", 1..=1)]
    }

    /// The texture coordinates that a material reads, or else those that meshes usually have.
    fn texcoords(&self, prim: &Path, faces: &Faces, material: &Use) -> Option<Attribute> {
        let of =
            |name: &str| self.reader.attribute(prim, &format!("primvars:{name}"), faces, 2..=3, "constant");
        match &material.texcoords {
            Some(name) => of(name),
            None => of("st").or_else(|| of("UVMap")),
        }
    }

    /// The parts that subsets with materials of their own make.
    fn parts(
        &mut self,
        prim: &Path,
        faces: &Faces,
        bound: Option<&Path>,
        (has_colors, has_opacities): (bool, bool),
    ) -> Vec<Part> {
        let mut is_left = vec![true; faces.len()];
        let mut parts = Vec::new();
        for subset in self.reader.children(prim) {
            if self.reader.kind(&subset) != "GeomSubset" {
                continue;
            }
            let family = self.reader.word(&subset, "familyName").unwrap_or_default();
            let element = self.reader.word(&subset, "elementType").unwrap_or_else(|| "face".into());
            if family != "materialBind" || element != "face" {
                continue;
            }
            let Some(material) = self.bindings.of(self.reader, &subset) else { continue };
            if Some(&material) == bound {
                continue;
            }
            let indices = self.reader.value(&subset, "indices").as_ref().and_then(value::integers);
            let mut takes = vec![false; faces.len()];
            for index in indices.unwrap_or_default() {
                match usize::try_from(index).ok().filter(|&index| index < faces.len()) {
                    Some(face) => {
                        takes[face] = is_left[face];
                        is_left[face] = false;
                    }
                    None => {
                        self.reader.note(Oddity::BadAttribute, &subset, format_args!("no face {index}"));
                        break;
                    }
                }
            }
            let material = self.materials.of(self.reader, &mut self.scene, &material);
            parts.push(Part { material, takes, is_subset: true });
        }
        if is_left.contains(&true) {
            let material = match bound {
                Some(material) => self.materials.of(self.reader, &mut self.scene, material),
                None => self.materials.unbound(&mut self.scene, has_colors, has_opacities),
            };
            parts.push(Part { material, takes: is_left, is_subset: false });
        }
        parts
    }
}
