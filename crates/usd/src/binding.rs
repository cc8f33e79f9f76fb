// SPDX-License-Identifier: GPL-3.0-or-later
//! Which material a prim is bound to: by its own binding, its ancestors' or collections, by purpose and strength.
//! Source: UsdShadeMaterialBindingAPI (material resolution). The purpose is `full`, then that of all.
//! Prims without that schema bind nothing, as by default in OpenUSD. Tests: `tests/materials.rs`.

use std::collections::HashMap;
use std::rc::Rc;

use openusd::sdf::Path;
use openusd::usd::{Collection, MembershipQuery};

use crate::reader::Reader;
use crate::value;

/// Purposes in the order in which they are looked for.
const PURPOSES: [&str; 2] = ["full", ""];

/// A binding and whether it is stronger than those of descendants.
struct Bound {
    material: Path,
    is_strong: bool,
}

/// What one prim binds, by purpose.
#[derive(Default)]
struct Own {
    direct: [Option<Bound>; 2],
    collections: [Vec<(MembershipQuery, Bound)>; 2],
}

/// Bindings of prims that were looked at.
#[derive(Default)]
pub(crate) struct Bindings {
    known: HashMap<Path, Rc<Own>>,
}

impl Bindings {
    /// The material of a prim.
    pub(crate) fn of(&mut self, reader: &Reader, prim: &Path) -> Option<Path> {
        let chain: Vec<Rc<Own>> = prim.ancestors_below_root().map(|above| self.own(reader, &above)).collect();
        (0..PURPOSES.len()).find_map(|purpose| {
            let mut best: Option<&Path> = None;
            for own in &chain {
                let direct = own.direct[purpose].iter();
                let members = own.collections[purpose].iter();
                let members =
                    members.filter(|(query, _)| query.is_path_included(prim)).map(|(_, bound)| bound);
                // At one prim collections go before the direct binding.
                for bound in members.chain(direct) {
                    if best.is_none() || bound.is_strong {
                        best = Some(&bound.material);
                    }
                }
            }
            best.cloned()
        })
    }

    fn own(&mut self, reader: &Reader, prim: &Path) -> Rc<Own> {
        if let Some(known) = self.known.get(prim) {
            return known.clone();
        }
        let own = Rc::new(read(reader, prim));
        self.known.insert(prim.clone(), own.clone());
        own
    }
}

fn read(reader: &Reader, prim: &Path) -> Own {
    let mut own = Own::default();
    let names = reader.properties(prim);
    let mut names = names.iter().filter(|name| name.starts_with("material:binding")).peekable();
    if let (Some(name), false) = (names.peek(), reader.has_schema(prim, "MaterialBindingAPI")) {
        let what = format_args!("{name} without MaterialBindingAPI among apiSchemas, ignored as by OpenUSD");
        reader.unsupported(prim, what);
        return own;
    }
    for name in names {
        let rest = &name["material:binding".len()..];
        let parts: Vec<&str> = rest.split(':').skip(1).collect();
        let targets = reader.targets(prim, name);
        let strength = reader.metadata_of_relationship(prim, name, "bindMaterialAs");
        let is_strong =
            strength.as_ref().and_then(value::word).is_some_and(|s| s == "strongerThanDescendants");
        let purpose = |name: &str| PURPOSES.iter().position(|known| *known == name);
        match parts[..] {
            [] | [_] if parts.first() != Some(&"collection") => {
                let Some(purpose) = purpose(parts.first().copied().unwrap_or("")) else { continue };
                if let Some(material) =
                    targets.into_iter().next().filter(|target| is_material(reader, prim, target))
                {
                    own.direct[purpose] = Some(Bound { material, is_strong });
                }
            }
            ["collection", .., _] => {
                let Some(purpose) = purpose(if parts.len() > 2 { parts[1] } else { "" }) else { continue };
                let [collection, material] = &targets[..] else { continue };
                if !is_material(reader, prim, material) {
                    continue;
                }
                let Some((owner, property)) = collection.split_property() else { continue };
                let Some(collection) = property.strip_prefix("collection:") else { continue };
                let query = Collection::new(owner, collection).compute_membership_query(&reader.stage);
                if let Ok(query) = query {
                    let material = material.clone();
                    own.collections[purpose].push((query, Bound { material, is_strong }));
                }
            }
            _ => {}
        }
    }
    own
}

/// Whether a target is a material, or a warning.
fn is_material(reader: &Reader, prim: &Path, target: &Path) -> bool {
    let is_one = reader.kind(target) == "Material";
    if !is_one {
        reader.unsupported(prim, format_args!("bound to {target}, which is no Material"));
    }
    is_one
}
