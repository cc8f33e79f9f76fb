// SPDX-License-Identifier: GPL-3.0-or-later
//! Trees over what a ray scene holds. Source: original.
//! Meshes lie in one object, each a geometry of it, at their places; instances need a scene: object 0 is that of all meshes,
//! the others follow. Invariant: ids that come out are those that were given. Proof: `tests/test_scene.py`.

use std::sync::Arc;

use gnurt_accel::{BuildOptions, Hit, Instance, ObjectTree, SceneTree, Threads, Triangles};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::meshes::{Mesh, Placed, carried};

/// What is asked.
#[derive(Debug)]
pub(crate) enum Trees {
    Object(ObjectTree),
    /// And the instances after the first: their numbers and their geometries.
    Scene(SceneTree, Vec<(u32, u32)>),
}

/// Runs an expression for either kind of tree, which have methods of the same names.
macro_rules! ask {
    ($trees:expr, $tree:ident => $answer:expr) => {
        match $trees {
            $crate::trees::Trees::Object($tree) => $answer,
            $crate::trees::Trees::Scene($tree, _) => $answer,
        }
    };
}
pub(crate) use ask;

type Soup = (Vec<[f32; 3]>, Vec<[u32; 3]>);

/// Arrays of all that is built, taken out of Python.
pub(crate) struct Plan {
    meshes: Vec<Soup>,
    instances: Vec<(u32, Placed, Soup)>,
}

impl Plan {
    pub(crate) fn new(py: Python<'_>, meshes: &[Option<Mesh>], placed: &[Option<Placed>]) -> PyResult<Self> {
        let soup = |mesh: &Mesh| -> PyResult<Soup> { Ok((mesh.positions(py)?, mesh.indices(py)?)) };
        let at_place = |mesh: &Option<Mesh>| -> PyResult<Soup> {
            // What was removed keeps its number.
            let Some(mesh) = mesh else { return Ok(Soup::default()) };
            let (mut positions, indices) = soup(mesh)?;
            if let Some(place) = &mesh.place {
                positions.iter_mut().for_each(|at| *at = carried(place, *at));
            }
            Ok((positions, indices))
        };
        let of = |(i, placed): (usize, &Option<Placed>)| {
            let placed = (*placed)?;
            let mesh = meshes.get(placed.geom_id as usize)?.as_ref()?;
            Some(soup(mesh).map(|soup| (i as u32, placed, soup)))
        };
        Ok(Self {
            meshes: meshes.iter().map(at_place).collect::<PyResult<_>>()?,
            instances: placed.iter().enumerate().filter_map(of).collect::<PyResult<_>>()?,
        })
    }

    /// Builds; without the interpreter.
    pub(crate) fn build(self, threads: Threads) -> PyResult<Trees> {
        let object = |soups: &[Soup]| {
            let meshes: Vec<Triangles> =
                soups.iter().map(|(positions, indices)| Triangles { positions, indices }).collect();
            ObjectTree::try_build(&meshes, &BuildOptions::default(), threads, &())
                .map_err(|error| PyValueError::new_err(error.to_string()))
        };
        let all = object(&self.meshes)?;
        if self.instances.is_empty() {
            return Ok(Trees::Object(all));
        }
        let mut shown = vec![Instance::identity(Arc::new(all))];
        let mut ids = Vec::with_capacity(self.instances.len());
        let mut built: Vec<(u32, Arc<ObjectTree>)> = Vec::new();
        for (inst_id, Placed { geom_id, place }, soup) in self.instances {
            let known = built.iter().find(|(id, _)| *id == geom_id).map(|(_, tree)| tree.clone());
            let tree = match known {
                Some(tree) => tree,
                None => {
                    let tree = Arc::new(object(&[soup])?);
                    built.push((geom_id, tree.clone()));
                    tree
                }
            };
            shown.push(Instance::new(tree, place));
            ids.push((inst_id, geom_id));
        }
        let scene = SceneTree::try_build(&shown, &BuildOptions::default(), threads, &())
            .map_err(|error| PyValueError::new_err(error.to_string()))?;
        Ok(Trees::Scene(scene, ids))
    }
}

impl Trees {
    /// Geometry and instance, or -1, of an answer in which the trees gave these.
    pub(crate) fn ids(&self, geom_id: u32, inst_id: u32) -> (u32, u32) {
        match self {
            Self::Scene(_, ids) if inst_id != 0 && inst_id != u32::MAX => {
                ids.get(inst_id as usize - 1).map_or((u32::MAX, u32::MAX), |&(inst, geom)| (geom, inst))
            }
            _ => (geom_id, u32::MAX),
        }
    }

    /// Unit normal of a triangle that was hit; zeros where there is none.
    pub(crate) fn normal(&self, [prim_id, geom_id, inst_id, leaf_id]: [u32; 4]) -> [f32; 3] {
        if prim_id == u32::MAX {
            return [0.0; 3];
        }
        let hit = Hit { t: 0.0, u: 0.0, v: 0.0, prim_id, geom_id, inst_id, leaf_id };
        ask!(self, tree => tree.normal(&hit)).unwrap_or_default()
    }
}
