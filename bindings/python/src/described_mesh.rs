// SPDX-License-Identifier: GPL-3.0-or-later
//! Meshes of a scene from arrays: attributes per vertex, per corner and per triangle, and several materials.
//! Corners of one vertex become vertices of their own as far as their values differ. Each material gets a mesh.
//! Tests: `tests/test_textures.py`.

use gnurt::scene::{Attribute, Mesh as SceneMesh, Rate};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::{Numbers, array};
use crate::geometries::{Kind, StoredGeometry};
use crate::given::Given;
use crate::soups::Soup;

/// Meshes before they are in an object, each with the index of its material among `materials`.
pub(crate) struct DescribedMesh {
    pub(crate) name: String,
    pub(crate) parts: Vec<(usize, SceneMesh)>,
    /// Numbers of materials; `None` = none was given.
    pub(crate) materials: Option<Vec<usize>>,
    pub(crate) placement: Option<[[f64; 3]; 4]>,
}

/// Rows of `width` numbers for vertices, corners or triangles.
struct Values {
    width: usize,
    data: Vec<f32>,
    per: Per,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Per {
    Vertex,
    Corner,
    Triangle,
}

impl Values {
    /// `(vertices, width)` or `(triangles, 3, width)`; of attributes the width is free, and `(vertices,)` is one number for each.
    fn new(name: &str, value: &Bound<'_, PyAny>, width: Option<usize>, counts: [usize; 2]) -> PyResult<Self> {
        let [vertices, triangles] = counts;
        let found = array(name, value)?;
        let shape: Vec<usize> = found.getattr("shape")?.extract()?;
        let fits = |w: usize| (1..=16).contains(&w) && width.is_none_or(|width| width == w);
        let (per, width) = match shape[..] {
            [n] if n == vertices && width.is_none() => (Per::Vertex, 1),
            [n, w] if n == vertices && fits(w) => (Per::Vertex, w),
            [n, 3, w] if n == triangles && fits(w) => (Per::Corner, w),
            _ => {
                let w = width.map_or("1 to 16".into(), |width| width.to_string());
                return Err(PyValueError::new_err(format!(
                    "{name}: expected shape ({vertices}, {w}), one row for each vertex, or ({triangles}, 3, {w}), one \
                     for each corner, not {}",
                    found.getattr("shape")?
                )));
            }
        };
        let rows = found.call_method1("reshape", (shape.iter().product::<usize>() / width, width))?;
        Ok(Self { width, data: flat(&Numbers::new(name, &rows, Some(width))?, width), per })
    }

    /// `(triangles,)` or `(triangles, width)`.
    fn of_triangles(name: &str, value: &Bound<'_, PyAny>, triangles: usize) -> PyResult<Self> {
        let found = array(name, value)?;
        let shape: Vec<usize> = found.getattr("shape")?.extract()?;
        let width = match shape[..] {
            [n] if n == triangles => 1,
            [n, w] if n == triangles && (1..=16).contains(&w) => w,
            _ => {
                return Err(PyValueError::new_err(format!(
                    "{name}: expected shape ({triangles},) or ({triangles}, 1 to 16), not {}",
                    found.getattr("shape")?
                )));
            }
        };
        let rows = found.call_method1("reshape", (triangles, width))?;
        Ok(Self { width, data: flat(&Numbers::new(name, &rows, Some(width))?, width), per: Per::Triangle })
    }

    fn row(&self, index: usize) -> &[f32] {
        &self.data[index * self.width..][..self.width]
    }

    /// Those of a part's vertices or triangles.
    fn taken(&self, part: &Part) -> Vec<f32> {
        let chosen = match self.per {
            Per::Vertex => &part.vertices,
            Per::Corner => &part.corners,
            Per::Triangle => &part.triangles,
        };
        chosen.iter().flat_map(|&index| self.row(index)).copied().collect()
    }
}

fn flat(numbers: &Numbers, width: usize) -> Vec<f32> {
    fn gather<T: Copy>(all: &[T], step: usize, count: usize, width: usize, single: fn(T) -> f32) -> Vec<f32> {
        (0..count).flat_map(|i| all[i * step..][..width].iter().map(|&x| single(x))).collect()
    }
    match numbers {
        Numbers::Single(rows) => gather(rows.all(), rows.step(), rows.count(), width, |x| x),
        Numbers::Double(rows) => gather(rows.all(), rows.step(), rows.count(), width, |x| x as f32),
    }
}

/// Triangles of one material: where its vertices come from.
#[derive(Default)]
struct Part {
    /// By new vertex: the old one, and one of the corners that use it.
    vertices: Vec<usize>,
    corners: Vec<usize>,
    triangles: Vec<usize>,
    indices: Vec<[u32; 3]>,
}

impl Part {
    /// Of these triangles. Corners of a vertex are one if all values are equal.
    fn new(faces: &[[u32; 3]], triangles: Vec<usize>, values: &[&Values], vertices: usize) -> Self {
        const NONE: u32 = u32::MAX;
        let mut part = Self { triangles, ..Self::default() };
        let mut first = vec![NONE; vertices];
        let mut next: Vec<u32> = Vec::new();
        let equal = |a: usize, b: usize| {
            values
                .iter()
                .all(|all| all.row(a).iter().map(|x| x.to_bits()).eq(all.row(b).iter().map(|x| x.to_bits())))
        };
        for &triangle in &part.triangles {
            part.indices.push([0, 1, 2].map(|k| {
                let (corner, vertex) = (3 * triangle + k, faces[triangle][k] as usize);
                let mut known = first[vertex];
                while known != NONE && !equal(part.corners[known as usize], corner) {
                    known = next[known as usize];
                }
                if known == NONE {
                    known = part.vertices.len() as u32;
                    part.vertices.push(vertex);
                    part.corners.push(corner);
                    next.push(std::mem::replace(&mut first[vertex], known));
                }
                known
            }));
        }
        part
    }
}

impl DescribedMesh {
    /// By the arguments.
    pub(crate) fn new(py: Python<'_>, given: &mut Given) -> PyResult<Self> {
        let needed = |name: &str| PyTypeError::new_err(format!("{name}: is missing"));
        let vertices = given.get("vertices")?.ok_or_else(|| needed("vertices"))?;
        let faces = given.get("faces")?.ok_or_else(|| needed("faces"))?;
        let placement = given.get("transform")?;
        let mesh = StoredGeometry::mesh(&vertices, &faces, Kind::Triangles, false, "float32")?;
        let mesh = mesh.placed(placement.as_ref())?;
        let Soup::Triangles(positions, faces) = Soup::new(py, &mesh)? else {
            return Err(PyValueError::new_err("faces: expected triangles"));
        };
        let counts = [positions.len(), faces.len()];
        let mut known = Vec::new();
        for (name, width) in [("normals", 3), ("texcoords", 2), ("tangents", 4), ("colors", 4)] {
            let values = given.get(name)?.map(|value| Values::new(name, &value, Some(width), counts));
            known.push(values.transpose()?);
        }
        let mut others = named(given, "attributes", |name, value| Values::new(name, value, None, counts))?;
        others.extend(named(given, "face_attributes", |name, value| {
            Values::of_triangles(name, value, faces.len())
        })?);
        let (materials, slots) = materials(given, faces.len())?;
        let split: Vec<&Values> = known
            .iter()
            .flatten()
            .chain(others.iter().map(|(_, values)| values))
            .filter(|values| values.per == Per::Corner)
            .collect();
        let name = given.text("name")?.unwrap_or_default();
        let count = materials.as_ref().map_or(1, Vec::len);
        let mut triangles: Vec<Vec<usize>> = vec![Vec::new(); count];
        slots.iter().enumerate().for_each(|(triangle, &slot)| triangles[slot].push(triangle));
        let parts = triangles
            .into_iter()
            .enumerate()
            .filter(|(slot, all)| count == 1 && *slot == 0 || !all.is_empty());
        let parts = parts.map(|(slot, triangles)| {
            let part = match count == 1 && split.is_empty() {
                // All as it was given, vertices of no triangle included.
                true => Part {
                    vertices: (0..counts[0]).collect(),
                    corners: Vec::new(),
                    indices: faces.clone(),
                    triangles,
                },
                false => Part::new(&faces, triangles, &split, counts[0]),
            };
            let taken = |k: usize| known[k].as_ref().map(|values| values.taken(&part)).unwrap_or_default();
            let attribute = |(name, values): &(String, Values)| Attribute {
                name: name.clone(),
                rate: if values.per == Per::Triangle { Rate::Triangle } else { Rate::Vertex },
                components: values.width as u32,
                data: values.taken(&part),
            };
            let mesh = SceneMesh {
                name: name.clone(),
                normals: taken(0).as_chunks().0.to_vec(),
                texcoords: taken(1).as_chunks().0.to_vec(),
                tangents: taken(2).as_chunks().0.to_vec(),
                colors: taken(3).as_chunks().0.to_vec(),
                positions: part.vertices.iter().map(|&vertex| positions[vertex]).collect(),
                attributes: others.iter().map(attribute).collect(),
                indices: part.indices,
                ..SceneMesh::default()
            };
            (slot, mesh)
        });
        Ok(Self { parts: parts.collect(), name, materials, placement: mesh.placement })
    }
}

/// The arrays of a dict, by their names.
fn named(
    given: &mut Given,
    argument: &'static str,
    read: impl Fn(&str, &Bound<'_, PyAny>) -> PyResult<Values>,
) -> PyResult<Vec<(String, Values)>> {
    let Some(all) = given.get(argument)? else { return Ok(Vec::new()) };
    let no_dict = || PyTypeError::new_err(format!("{argument}: expected a dict of names and arrays"));
    let all = all.cast::<PyDict>().map_err(|_| no_dict())?;
    all.iter()
        .map(|(name, value)| {
            let name: String = name.extract().map_err(|_| no_dict())?;
            let values = read(&format!("{argument}: '{name}'"), &value)?;
            Ok((name, values))
        })
        .collect()
}

/// The `attributes` of a mesh without triangles: a row for each vertex.
pub(crate) fn vertex_attributes(given: &mut Given, vertices: usize) -> PyResult<Vec<Attribute>> {
    let all = named(given, "attributes", |name, value| Values::new(name, value, None, [vertices, 0]))?;
    let attribute = |(name, values): (String, Values)| Attribute {
        name,
        rate: Rate::Vertex,
        components: values.width as u32,
        data: values.data,
    };
    Ok(all.into_iter().map(attribute).collect())
}

/// Numbers of materials, and which of them each triangle has.
fn materials(given: &mut Given, triangles: usize) -> PyResult<(Option<Vec<usize>>, Vec<usize>)> {
    let value = given.get("material")?;
    let chosen = given.get("face_materials")?;
    let materials = match &value {
        None => None,
        Some(value) => match (value.extract::<usize>(), value.extract::<Vec<usize>>()) {
            (Ok(one), _) => Some(vec![one]),
            (_, Ok(several)) if !several.is_empty() => Some(several),
            _ => return Err(PyTypeError::new_err("material: expected the number of a material, or several")),
        },
    };
    let count = materials.as_ref().map_or(1, Vec::len);
    let Some(chosen) = chosen else {
        return match count {
            1 => Ok((materials, vec![0; triangles])),
            _ => Err(PyValueError::new_err(
                "face_materials: is missing; it gives each triangle one of several materials",
            )),
        };
    };
    let numbers = Numbers::new("face_materials", &chosen, None)?;
    if numbers.count() != triangles {
        let found = numbers.count();
        return Err(PyValueError::new_err(format!(
            "face_materials: expected shape ({triangles},), not ({found},)"
        )));
    }
    let slots = flat(&numbers, 1).into_iter().map(|slot| match slot {
        slot if slot >= 0.0 && slot < count as f32 && slot.fract() == 0.0 => Ok(slot as usize),
        slot => Err(PyValueError::new_err(format!(
            "face_materials: expected whole numbers from 0 to {}, not {slot}",
            count - 1
        ))),
    });
    Ok((materials, slots.collect::<PyResult<_>>()?))
}
