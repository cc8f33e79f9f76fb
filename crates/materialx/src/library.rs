// SPDX-License-Identifier: GPL-3.0-or-later
//! MaterialX's own definitions, embedded: `library/` holds its files as they are. Parsed once, when a document asks first.
//! Tests: `tests/library.rs`.

use std::collections::HashMap;
use std::sync::{Arc, LazyLock};

use crate::document::inherit;
use crate::xml::{Element, parse};

macro_rules! carried {
    ($($file:literal)*) => { &[$(($file, include_str!(concat!("../library/", $file, ".mtlx"))),)*] };
}

const FILES: &[(&str, &str)] = carried! {
    "stdlib/stdlib_defs" "stdlib/stdlib_ng" "pbrlib/pbrlib_defs" "pbrlib/pbrlib_ng" "nprlib/nprlib_defs"
    "nprlib/nprlib_ng" "cmlib/cmlib_defs" "cmlib/cmlib_ng" "lights/lights_defs" "bxdf/disney_principled"
    "bxdf/gltf_pbr" "bxdf/open_pbr_surface" "bxdf/standard_surface" "bxdf/usd_preview_surface"
    "bxdf/lama/lama_add" "bxdf/lama/lama_conductor" "bxdf/lama/lama_dielectric" "bxdf/lama/lama_diffuse"
    "bxdf/lama/lama_emission" "bxdf/lama/lama_generalized_schlick" "bxdf/lama/lama_iridescence"
    "bxdf/lama/lama_layer" "bxdf/lama/lama_mix" "bxdf/lama/lama_sheen" "bxdf/lama/lama_sss"
    "bxdf/lama/lama_surface" "bxdf/lama/lama_translucent" "bxdf/translation/open_pbr_to_standard_surface"
    "bxdf/translation/standard_surface_to_gltf_pbr" "bxdf/translation/standard_surface_to_open_pbr"
    "bxdf/translation/standard_surface_to_usd"
};

/// Definitions by name: those of a document, or the embedded ones.
#[derive(Debug, Default)]
pub(crate) struct Definitions<'a> {
    nodedefs: HashMap<&'a str, &'a Element>,
    of_node: HashMap<&'a str, Vec<&'a Element>>,
    /// Graphs by the definition that they implement.
    graphs: HashMap<&'a str, &'a Element>,
    graphs_by_name: HashMap<&'a str, &'a Element>,
    /// Definitions by the graph that implements them, of `implementation` elements.
    implemented: HashMap<&'a str, &'a str>,
    /// Geometric properties.
    pub(crate) geomprops: HashMap<&'a str, &'a Element>,
    /// Units by type and name, in that of scale 1.
    units: HashMap<(&'a str, &'a str), f32>,
}

static ROOTS: LazyLock<Vec<Element>> = LazyLock::new(|| {
    let root = |(i, (file, text)): (usize, &(&str, &str))| {
        let mut root = parse(text, i as u32).unwrap_or_else(|(line, why)| panic!("{file}:{line}: {why}"));
        inherit(&mut root, None, &Arc::from(""));
        root
    };
    FILES.iter().enumerate().map(root).collect()
});

static EMBEDDED: LazyLock<Definitions<'static>> =
    LazyLock::new(|| Definitions::of(ROOTS.iter().flat_map(|root| &root.children)));

impl<'a> Definitions<'a> {
    pub(crate) fn of(elements: impl Iterator<Item = &'a Element>) -> Self {
        let mut all = Self::default();
        for element in elements {
            match &*element.tag {
                "nodedef" => {
                    all.nodedefs.insert(element.name(), element);
                    all.of_node.entry(element.get("node").unwrap_or("")).or_default().push(element);
                }
                "nodegraph" => {
                    all.graphs_by_name.insert(element.name(), element);
                    if let Some(nodedef) = element.given("nodedef") {
                        all.graphs.insert(nodedef, element);
                    }
                }
                "implementation" => {
                    if let (Some(nodedef), Some(graph)) =
                        (element.given("nodedef"), element.given("nodegraph"))
                    {
                        all.implemented.insert(nodedef, graph);
                    }
                }
                "geompropdef" => {
                    all.geomprops.insert(element.name(), element);
                }
                "unitdef" => {
                    let ty = element.get("unittype").unwrap_or("");
                    for unit in element.all("unit") {
                        let scale = unit.get("scale").and_then(|scale| scale.parse().ok()).unwrap_or(1.0);
                        all.units.insert((ty, unit.name()), scale);
                    }
                }
                _ => {}
            }
        }
        all
    }

    pub(crate) fn nodedef(&self, name: &str) -> Option<&'a Element> {
        self.nodedefs.get(name).copied()
    }

    pub(crate) fn nodedefs(&self) -> impl Iterator<Item = &'a Element> {
        self.nodedefs.values().copied()
    }

    pub(crate) fn of_node(&self, node: &str) -> &[&'a Element] {
        self.of_node.get(node).map_or(&[], |defs| &defs[..])
    }

    /// The graph that implements a definition.
    pub(crate) fn graph(&self, nodedef: &str) -> Option<&'a Element> {
        let named = || self.graphs_by_name.get(*self.implemented.get(nodedef)?).copied();
        self.graphs.get(nodedef).copied().or_else(named)
    }

    pub(crate) fn unit(&self, ty: &str, name: &str) -> Option<f32> {
        self.units.iter().find(|((t, n), _)| *t == ty && *n == name).map(|(_, scale)| *scale)
    }

    /// The type of a unit.
    pub(crate) fn unit_type(&self, name: &str) -> Option<&'a str> {
        self.units.keys().find(|(_, known)| *known == name).map(|(ty, _)| *ty)
    }
}

/// The embedded definitions.
pub(crate) fn embedded() -> &'static Definitions<'static> {
    &EMBEDDED
}
