// SPDX-License-Identifier: GPL-3.0-or-later
//! The camera of a picture and the names of a scene's parts, as shaders query them.
//! Source: the standard camera attributes of the Open Shading Language.
//! Space: the screen window has y up; its unit is half of the picture's height, or world units of parallel rays.
//! Tests: `tests`; crates/render/tests/scene_queries.rs.

use std::collections::{BTreeMap, BTreeSet};

use crate::camera_projection::CameraProjection;

/// The camera of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraProperties {
    /// Columns and rows of the picture.
    pub resolution: [u32; 2],
    /// How it projects; `None` if its rays follow another rule.
    pub projection: Option<CameraProjection>,
    /// When the shutter opens and closes, in the unit of the rays' times: 0 and 1, or 0 and 0.
    pub shutter: [f32; 2],
}

impl CameraProperties {
    /// The distance of the far end of rays, which no plane ends.
    pub const FAR: f32 = 1e30;

    /// Vertical angle of view, degrees; `None` without one.
    #[must_use]
    pub fn fov(&self) -> Option<f32> {
        match self.projection? {
            CameraProjection::Perspective { half_height } => Some(2.0 * half_height.atan().to_degrees()),
            CameraProjection::Fisheye { half_angle } => Some(2.0 * half_angle.to_degrees()),
            CameraProjection::Parallel { .. } | CameraProjection::Panorama => None,
        }
    }

    /// Left, lower, right and upper edge of the picture; `None` without a known projection.
    #[must_use]
    pub fn screen_window(&self) -> Option<[f32; 4]> {
        let half_height = match self.projection? {
            CameraProjection::Parallel { half_height } => half_height,
            _ => 1.0,
        };
        let [width, height] = self.resolution.map(|n| n.max(1) as f32);
        let half_width = half_height * width / height;
        Some([-half_width, -half_height, half_width, half_height])
    }
}

/// Names by number; missing ones are empty.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SceneNames {
    /// Of instances.
    pub instances: Vec<String>,
    /// Of objects.
    pub objects: Vec<String>,
    /// Of materials.
    pub materials: Vec<String>,
    /// Sets of instances by name.
    pub sets: BTreeMap<String, BTreeSet<u32>>,
    /// The object of each instance. Empty unless requested.
    pub object_of: Vec<u32>,
    /// Attributes that have the same value all over an object, by its number. Empty unless requested.
    pub constants: BTreeMap<u32, BTreeMap<String, Vec<f32>>>,
}

/// Whether a name is that of a thing, or the last part of its path.
fn is_name_of(name: &str, of: &str) -> bool {
    !name.is_empty() && (of == name || of.rsplit('/').next() == Some(name))
}

impl SceneNames {
    /// Whether rays that are restricted to a set hit an object of an instance: the set is one of [`sets`](Self::sets), or
    /// the name of instances or objects. A `-` before the name means all others; the empty name means all.
    #[must_use]
    pub fn may_hit(&self, set: &str, instance: u32, object: u32) -> bool {
        let is_in = |name: &str| {
            let of = |list: &[String], number: u32| {
                list.get(number as usize).is_some_and(|of| is_name_of(name, of))
            };
            self.sets.get(name).is_some_and(|set| set.contains(&instance))
                || of(&self.instances, instance)
                || of(&self.objects, object)
        };
        match set.strip_prefix('-') {
            Some(excluded) => !is_in(excluded),
            None => set.is_empty() || is_in(set),
        }
    }

    /// The first instance with a name, or path that ends so, and its object; or the first object. The instance is `None` where only
    /// the object has the name.
    #[must_use]
    pub fn find(&self, name: &str) -> Option<(Option<u32>, u32)> {
        let position = |list: &[String]| list.iter().position(|of| is_name_of(name, of));
        match position(&self.instances) {
            Some(instance) => Some((Some(instance as u32), *self.object_of.get(instance)?)),
            None => position(&self.objects).map(|object| (None, object as u32)),
        }
    }

    /// The name of the geometry of an instance and an object: the instance's, or the object's if that is empty.
    #[must_use]
    pub fn of_geometry(&self, instance: u32, object: u32) -> &str {
        match self.instances.get(instance as usize) {
            Some(name) if !name.is_empty() => name,
            _ => self.objects.get(object as usize).map_or("", String::as_str),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_and_angles_follow_the_projection() {
        let of = |projection| CameraProperties { resolution: [200, 100], projection, shutter: [0.0; 2] };
        let perspective = of(Some(CameraProjection::Perspective { half_height: 1.0 }));
        assert!(perspective.fov().is_some_and(|fov| (fov - 90.0).abs() < 1e-4), "{:?}", perspective.fov());
        assert_eq!(perspective.screen_window(), Some([-2.0, -1.0, 2.0, 1.0]));
        let parallel = of(Some(CameraProjection::Parallel { half_height: 3.0 }));
        assert_eq!((parallel.fov(), parallel.screen_window()), (None, Some([-6.0, -3.0, 6.0, 3.0])));
        let fisheye = of(Some(CameraProjection::Fisheye { half_angle: std::f32::consts::FRAC_PI_2 }));
        assert_eq!(fisheye.fov(), Some(180.0));
        assert_eq!((of(None).fov(), of(None).screen_window()), (None, None), "rays of a shader");
    }

    #[test]
    fn sets_are_names_and_lists() {
        let list = |names: &[&str]| names.iter().map(ToString::to_string).collect();
        let names = SceneNames {
            instances: list(&["/room/chair", "lamp", ""]),
            objects: list(&["wood", "-odd"]),
            sets: BTreeMap::from([("props".to_owned(), BTreeSet::from([1, 2]))]),
            ..SceneNames::default()
        };
        let hit = |set: &str| [0, 1, 2].map(|instance| names.may_hit(set, instance, 1));
        for (set, expected) in [
            ("", [true, true, true]),
            ("chair", [true, false, false]),
            ("/room/chair", [true, false, false]),
            ("room", [false, false, false]),
            ("props", [false, true, true]),
            ("-props", [true, false, false]),
            ("-nothing", [true, true, true]),
            ("-", [true, true, true]),
            ("--odd", [false, false, false]),
        ] {
            assert_eq!(hit(set), expected, "'{set}'");
        }
        assert!(names.may_hit("wood", 1, 0) && !names.may_hit("wood", 1, 1), "names of objects");
    }

    #[test]
    fn geometry_has_the_first_name() {
        let list = |names: &[&str]| names.iter().map(ToString::to_string).collect();
        let names =
            SceneNames { instances: list(&["chair", ""]), objects: list(&["wood"]), ..SceneNames::default() };
        assert_eq!(
            [names.of_geometry(0, 0), names.of_geometry(1, 0), names.of_geometry(1, 7)],
            ["chair", "wood", ""]
        );
    }
}
