// SPDX-License-Identifier: GPL-3.0-or-later
//! Light links by names: the instances that names mean.
//! A name is that of an instance, a path that it lies below, or the last part of its path. Tests: `tests`.

use crate::id::InstanceId;
use crate::labels::Shining;
use crate::scene::Scene;

/// Which link of a light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LinkKind {
    /// The instances that it lights.
    Lit,
    /// The instances that stop its light.
    Shadows,
}

/// Whether an instance of this name is meant by another one.
fn is_meant(instance: &str, name: &str) -> bool {
    let is_below = || instance.strip_prefix(name).is_some_and(|rest| rest.starts_with('/'));
    instance == name || is_below() || instance.rsplit('/').next() == Some(name)
}

impl Scene {
    /// The instances that names mean, ascending; the names that mean none.
    #[must_use]
    pub fn instances_named<'a>(&self, names: &[&'a str]) -> (Vec<InstanceId>, Vec<&'a str>) {
        let mut found = Vec::new();
        let mut is_known = vec![false; names.len()];
        for (id, instance) in (0..).map(InstanceId).zip(self.instances()) {
            let mut is_one = false;
            for (known, name) in is_known.iter_mut().zip(names) {
                let is_it = is_meant(&instance.name, name);
                *known |= is_it;
                is_one |= is_it;
            }
            if is_one {
                found.push(id);
            }
        }
        let unknown = names.iter().zip(is_known).filter(|(_, known)| !known).map(|(name, _)| *name).collect();
        (found, unknown)
    }

    /// Links a light to some instances; `None` = all.
    pub fn link_light(&mut self, shining: Shining, kind: LinkKind, instances: Option<Vec<InstanceId>>) {
        let links = self.labels_mut().light_links.entry(shining).or_default();
        match kind {
            LinkKind::Lit => links.lit = instances,
            LinkKind::Shadows => links.shadows = instances,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::affine::Affine;

    #[test]
    fn names_mean_instances() {
        let mut scene = Scene::new();
        for name in ["/World/Table", "/World/Set/Wall", "/World/Set/Floor", "/World/Settee"] {
            let object = scene.add_object_of("", Vec::new());
            let id = scene.instantiate(object, Affine::IDENTITY);
            scene.edit_instance(id).name = name.into();
        }
        let ids = |ids: &[u32]| ids.iter().copied().map(InstanceId).collect::<Vec<_>>();
        assert_eq!(scene.instances_named(&["/World/Set"]), (ids(&[1, 2]), vec![]), "all below");
        assert_eq!(scene.instances_named(&["Floor", "Table"]), (ids(&[0, 2]), vec![]), "the last part");
        assert_eq!(scene.instances_named(&["Chair", "Wall"]), (ids(&[1]), vec!["Chair"]), "a slip");
    }
}
