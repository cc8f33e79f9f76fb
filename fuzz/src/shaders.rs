// SPDX-License-Identifier: GPL-3.0-or-later
//! Shaders that are run: at one point of an empty world, by the interpreter and by machine code.

use std::sync::Arc;

use gnurt_jit::{Compiled, Lanes};
use gnurt_simd::Level;
use gnurt_sl::exec::{Host, Machine, Plan, PlanOptions, Point, Points, unknown_operation};
use gnurt_sl::group::Group;
use gnurt_sl::hir::Data;
use gnurt_sl::ir::{Shader, SymbolKind};
use gnurt_sl::types::Base;
use gnurt_sl_lib::Dual;
use gnurt_sl_lib::color::ColorSystem;

/// Iterations of loops of a point.
const ITERATIONS: u64 = 300;

struct Empty(ColorSystem);

impl Host for Empty {
    fn color_system(&self) -> &ColorSystem {
        &self.0
    }
}

fn empty() -> Empty {
    Empty(ColorSystem::named("Rec709").expect("it is known"))
}

fn point() -> Point {
    Point {
        p: Dual::new([0.25, -1.5, 3.0], [0.1, 0.0, 0.0], [0.0, 0.2, 0.0]),
        u: Dual::new(0.375, 0.1, 0.0),
        v: Dual::new(0.75, 0.0, 0.1),
        n: [0.0, 0.0, 1.0],
        ng: [0.0, 0.0, 1.0],
        ..Point::default()
    }
}

fn plan(group: &Group) -> Option<Arc<Plan>> {
    if group.layers.iter().any(|layer| unknown_operation(&layer.shader).is_some()) {
        return None;
    }
    Plan::new(group, &PlanOptions { iterations: ITERATIONS, ..PlanOptions::default() }).ok().map(Arc::new)
}

fn alone(shader: Shader) -> Group {
    let mut group = Group::default();
    group.add(Arc::new(shader), None, &[], &mut Vec::new());
    group
}

/// Outputs that are numbers or texts, by layer.
fn outputs(group: &Group) -> Vec<(usize, String)> {
    let mut found = Vec::new();
    for (number, layer) in group.layers.iter().enumerate() {
        for symbol in layer.shader.symbols.iter().filter(|s| s.kind == SymbolKind::OutputParam) {
            if symbol.ty.struct_id().is_none() && symbol.ty.base != Base::Closure {
                found.push((number, symbol.name.to_string()));
            }
        }
    }
    found
}

/// No number is like any other.
fn reported(data: &Data) -> String {
    match data {
        Data::Float(list) => {
            let bits = list.iter().map(|x| if x.is_nan() { "nan".into() } else { format!("{:x}", x.to_bits()) });
            bits.collect::<Vec<_>>().join(" ")
        }
        other => format!("{other:?}"),
    }
}

/// The output of a shader at a point, by the interpreter.
pub fn messages(shader: Shader) -> Vec<String> {
    messages_of(&alone(shader))
}

/// The same of a group.
pub fn messages_of(group: &Group) -> Vec<String> {
    let Some(plan) = plan(group) else { return vec!["refused".into()] };
    let world = empty();
    let mut machine = Machine::new(&plan, &world);
    machine.run(&point());
    let mut list: Vec<String> = machine.events.iter().map(|event| format!("{event:?}")).collect();
    for (layer, name) in outputs(group) {
        let (_, data) = machine.output(Some(layer), &name).expect("an output");
        list.push(format!("{layer}.{name} {}", reported(&data)));
    }
    list
}

/// Its output by machine code; `None` if there is none.
pub fn coded(shader: Shader) -> Option<Vec<String>> {
    let group = alone(shader);
    let plan = plan(&group)?;
    let code = Compiled::new(plan, Level::best()).ok()?;
    let world = empty();
    let mut points = Points { count: 1, ..Points::default() };
    points.set(0, &point());
    let mut lanes = Lanes::new(&code, &world);
    lanes.run(&points);
    let mut list: Vec<String> = lanes.take_events().iter().map(|(_, event)| format!("{event:?}")).collect();
    for (layer, name) in outputs(&group) {
        let (_, data) = lanes.output(0, Some(layer), &name).expect("an output");
        list.push(format!("{layer}.{name} {}", reported(&data)));
    }
    Some(list)
}

/// Four small shaders for groups, by name.
pub fn known(name: &str) -> Option<Arc<Shader>> {
    let text = match name {
        "a" => "shader a (float x = 1, output float y = 0, output color c = 0) { y = x * 2; c = color (x, u, v); }",
        "b" => "surface b (float x = 2 [[int interpolated = 1]], color c[2] = {1, 2}, string s = \"t\") { Ci = x * c[0] * diffuse (N); printf (s); }",
        "c" => "struct S { float p; color q[3]; }; shader c (S s = {1, {2, 3, 4}}, output S t = {0, {0, 0, 0}}, matrix m = 1) { t = s; t.p = m[0][1]; }",
        "d" => "shader d (float a[] = {1, 2}, int i = 1, output closure color k = 0) { k = a[i] * emission (); }",
        _ => return None,
    };
    gnurt_sl::compile("known.osl", text, &gnurt_sl::Options::default(), &|_| None).shader.map(Arc::new)
}
