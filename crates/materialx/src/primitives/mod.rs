// SPDX-License-Identifier: GPL-3.0-or-later
//! The nodes that no graph defines, in the shading language.
//! Source: [MaterialX], "Standard Nodes", "Physically Based Shading Nodes", "NPR Shading Nodes". Tests: `tests/values.rs`.

mod closures;
mod compositing;
mod flakes;
mod geometry;
mod hair;
pub(crate) mod helpers;
mod math;
mod matrices;
mod noise;
mod pictures;

use crate::error::Error;
use crate::generator::{Call, Generator, Outputs, Primitives};
use crate::parts::swizzled;
use crate::types::{Ty, Value};
use crate::xml::Element;

/// All of them.
pub(crate) struct All;

impl Primitives for All {
    fn emit<'a>(&self, g: &mut Generator<'a>, call: &Call<'a>) -> Result<Outputs, Error> {
        emit(g, call)
    }

    fn without_definition<'a>(
        &self,
        g: &mut Generator<'a>,
        scope: usize,
        node: &'a Element,
    ) -> Result<Option<Outputs>, Error> {
        without_definition(g, scope, node)
    }

    fn property(
        &self,
        g: &mut Generator<'_>,
        ty: Ty,
        kind: &str,
        space: &str,
        index: &str,
    ) -> Result<Value, String> {
        geometry::property(g, ty, kind, space, index)
    }
}

/// Nodes of former versions, which have no definition.
fn without_definition<'a>(
    g: &mut Generator<'a>,
    scope: usize,
    node: &'a Element,
) -> Result<Option<Outputs>, Error> {
    let Some(ty) = Ty::of(node.ty()).filter(|_| &*node.tag == "swizzle") else { return Ok(None) };
    let call = Call { node, def: node, scope, out: ty };
    let (value, channels) = (g.arg(&call, "in")?, g.word(&call, "channels")?);
    let parts = swizzled(&value, &channels, ty).map_err(|why| g.fault(scope, node, why))?;
    Ok(Some(vec![("out".to_owned(), g.bind(ty, parts))]))
}

/// The outputs of a node.
fn emit<'a>(g: &mut Generator<'a>, call: &Call<'a>) -> Result<Outputs, Error> {
    if let Some(outputs) = several(g, call)? {
        return Ok(outputs);
    }
    let name = g.known.outputs(call.def).first().map_or("out", |output| output.name()).to_owned();
    type Family = for<'a> fn(&mut Generator<'a>, &Call<'a>) -> Result<Option<Vec<String>>, Error>;
    let families: [Family; 9] = [
        math::emit,
        matrices::emit,
        compositing::emit,
        noise::emit,
        pictures::emit,
        geometry::emit,
        closures::emit,
        hair::emit,
        closures::emit_light,
    ];
    for family in families {
        if let Some(parts) = family(g, call)? {
            return Ok(vec![(name, g.bind(call.out, parts))]);
        }
    }
    let (category, def) = (call.category().to_owned(), call.def.name());
    Err(g.fault(call.scope, call.node, format!("'{category}' ({def}) is not supported")))
}

/// Nodes with several outputs.
fn several<'a>(g: &mut Generator<'a>, call: &Call<'a>) -> Result<Option<Outputs>, Error> {
    let outputs: Vec<(String, Value)> = match call.category() {
        "artistic_ior" => {
            let [r, edge] = [g.arg(call, "reflectivity")?, g.arg(call, "edge_color")?];
            g.needs("gnurt_artistic_ior");
            let ior = g.name("color", "0");
            let k = g.name("color", "0");
            g.body.push_str(&format!(
                "    gnurt_artistic_ior({}, {}, {ior}, {k});\n",
                r.first(),
                edge.first()
            ));
            vec![
                ("ior".into(), Value::new(Ty::Color3, vec![ior])),
                ("extinction".into(), Value::new(Ty::Color3, vec![k])),
            ]
        }
        "chiang_hair_roughness" => hair::roughness(g, call)?,
        "flake2d" | "flake3d" => flakes::emit(g, call)?,
        _ => return Ok(None),
    };
    Ok(Some(outputs))
}
