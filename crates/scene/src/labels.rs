// SPDX-License-Identifier: GPL-3.0-or-later
//! Labels of a scene's parts, from its file: names of lights, moments, the wished picture.
//! Nothing here changes a picture by itself. Tests: crates/usd/tests/{lights,cameras}.rs.

use std::collections::{BTreeMap, BTreeSet};

use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::id::{CameraId, InstanceId, LightId, MaterialId, ObjectId};

/// Facts about a scene's parts.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Labels {
    /// Names of lights without a surface.
    pub lights: BTreeMap<LightId, String>,
    /// Instances that are the surface of a light: they are listed as lights, not as meshes.
    pub luminaires: BTreeMap<InstanceId, Luminaire>,
    /// The first and the last moment in seconds of a file that is read at a moment; `None` = all moments are in the scene.
    pub times: Option<[f64; 2]>,
    /// The camera that the file wants to be seen through.
    pub camera: Option<CameraId>,
    /// Columns and rows of the picture that the file wants.
    pub resolution: Option<[u32; 2]>,
    /// The layers that the file wants in pictures: words, `light:NAME` and `NAME=EXPRESSION` as in `--layers`.
    pub outputs: Vec<String>,
    /// Objects with a refined mesh, and the control mesh of each.
    pub control_meshes: BTreeMap<ObjectId, ControlMesh>,
    /// Objects whose file has triangles without area, which no ray hits and their meshes lack; how many.
    pub flat_triangles: BTreeMap<ObjectId, u64>,
    /// Objects whose file names one material for the whole, or none (""), whatever parts of it are made of.
    pub bound_materials: BTreeMap<ObjectId, String>,
    /// Groups of lights; a group is a layer of its own in pictures that are mixed later.
    pub light_groups: BTreeMap<Shining, String>,
    /// Instances that leave a hole in the picture: camera rays see nothing there, other rays see them.
    pub holdouts: BTreeSet<InstanceId>,
    /// Sets of instances by name that rays of shaders may be restricted to (`traceset`).
    pub trace_sets: BTreeMap<String, BTreeSet<InstanceId>>,
    /// Lights that do not light everything, or whose light not everything stops.
    pub light_links: BTreeMap<Shining, LightLinks>,
}

/// The instances that a light reaches, and those that stop it; `None` = all.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct LightLinks {
    /// Instances that are lit.
    pub lit: Option<Vec<InstanceId>>,
    /// Instances that cast shadows.
    pub shadows: Option<Vec<InstanceId>>,
}

/// Something that gives off light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Shining {
    /// A light without a surface.
    Light(LightId),
    /// The surfaces of an emissive material.
    Material(MaterialId),
    /// The surfaces of an instance; counts before their materials.
    Instance(InstanceId),
}

/// Names of trace sets: at most so long.
const LONGEST_SET: usize = 100;

/// Longest name of a light group.
const LONGEST_GROUP: usize = 100;

impl Labels {
    /// Puts the light of something into a group. Characters that names of layers cannot have become `_`.
    pub fn set_light_group(&mut self, shining: Shining, group: &str) {
        let fine = |c: char| if c.is_alphanumeric() || "_-. ".contains(c) { c } else { '_' };
        let name: String = group.trim().chars().take(LONGEST_GROUP).map(fine).collect();
        if !name.is_empty() {
            self.light_groups.insert(shining, name);
        }
    }

    /// Adds an instance to sets by their names between commas.
    ///
    /// # Errors
    /// A name is longer than 100 bytes, begins with `-`, or has other characters than letters, digits, `_`, `-`, `.` and
    /// spaces. Nothing is added then.
    pub fn add_to_trace_sets(&mut self, instance: InstanceId, names: &str) -> Result<(), String> {
        let is_fine = |c: char| c.is_alphanumeric() || "_-. ".contains(c);
        let names: Vec<&str> = names.split(',').map(str::trim).filter(|name| !name.is_empty()).collect();
        let is_wrong =
            |name: &&&str| name.len() > LONGEST_SET || name.starts_with('-') || !name.chars().all(is_fine);
        if let Some(name) = names.iter().find(is_wrong) {
            return Err(format!(
                "invalid name of a trace set '{name}'; give letters, digits, _ . and spaces, and - within"
            ));
        }
        for name in names {
            self.trace_sets.entry(name.to_owned()).or_default().insert(instance);
        }
        Ok(())
    }

    /// The names of the sets of an instance, ascending.
    #[must_use]
    pub fn trace_sets_of(&self, instance: InstanceId) -> Vec<&str> {
        let of = self.trace_sets.iter().filter(|(_, set)| set.contains(&instance));
        of.map(|(name, _)| name.as_str()).collect()
    }

    /// The names of all light groups, each once, ascending.
    #[must_use]
    pub fn group_names(&self) -> Vec<&str> {
        let mut names: Vec<&str> = self.light_groups.values().map(String::as_str).collect();
        names.sort_unstable();
        names.dedup();
        names
    }
}

/// A light with a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Luminaire {
    /// A rectangle.
    Rect,
    /// A disk.
    Disk,
    /// A sphere.
    Sphere,
    /// The mantle of a cylinder.
    Cylinder,
    /// Any mesh.
    Mesh,
}

impl Luminaire {
    /// Its name in lists.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Rect => "rect",
            Self::Disk => "disk",
            Self::Sphere => "sphere",
            Self::Cylinder => "cylinder",
            Self::Mesh => "mesh",
        }
    }
}

/// A mesh before it was refined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ControlMesh {
    /// The rule: `catmullClark`, `loop` or `bilinear`.
    pub scheme: &'static str,
    /// How often it was refined.
    pub level: u32,
    /// Triangles of its faces, cut into fans.
    pub triangles: u64,
}

/// The rules that a control mesh may have.
const SCHEMES: [&str; 3] = ["catmullClark", "loop", "bilinear"];

impl Serialize for ControlMesh {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        (self.scheme, self.level, self.triangles).serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for ControlMesh {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let (word, level, triangles) = <(String, u32, u64)>::deserialize(deserializer)?;
        let scheme = SCHEMES.into_iter().find(|scheme| *scheme == word);
        let scheme = scheme.ok_or_else(|| D::Error::custom("a scheme of subdivision is unknown"))?;
        Ok(Self { scheme, level, triangles })
    }
}
