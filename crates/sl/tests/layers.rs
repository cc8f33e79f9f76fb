// SPDX-License-Identifier: GPL-3.0-or-later
//! Optimisation between layers: what is left of small groups.

use crate::common::shader;
use gnurt_sl::exec::{Plan, PlanOptions};
use gnurt_sl::group::Group;
use gnurt_sl::opcode::Opcode;
use std::sync::Arc;

/// A group of layers named a, b, c .. and of connections "a.x b.y".
fn group(texts: &[&str], connections: &[&str]) -> Group {
    let mut group = Group::default();
    let mut made: Vec<(&str, Arc<gnurt_sl::ir::Shader>)> = Vec::new();
    for (text, name) in texts.iter().zip(["a", "b", "c", "d"]) {
        let known = made.iter().find(|(known, _)| known == text).map(|(_, shader)| shader.clone());
        let shader = known.unwrap_or_else(|| Arc::new(shader(text)));
        made.push((text, shader.clone()));
        group.add(shader, Some(name), &[], &mut Vec::new());
    }
    for connection in connections {
        let parts: Vec<&str> = connection.split(['.', ' ']).collect();
        group.connect(parts[0], parts[1], parts[2], parts[3]).expect("a connection");
    }
    group
}

fn plan(group: &Group) -> Plan {
    let options = PlanOptions { drops_outputs: true, outputs: vec!["f".into()], ..PlanOptions::default() };
    Plan::new(group, &options).expect("a plan")
}

fn codes(plan: &Plan, layer: usize) -> Vec<Opcode> {
    let mut list = Vec::new();
    gnurt_sl::ir::ops(&plan.layers[layer].shader.code, &mut |op| list.push(op.code));
    list
}

const LAST: &str = "shader last (float x = 1, output float f = 0) { f = u; if (x > 2) f = sin (v); }";

#[test]
fn constants_go_through_connections() {
    let five = "shader five (output float o = 0) { o = 5; }";
    let plan = plan(&group(&[five, LAST], &["a.o b.x"]));
    assert!(plan.layers[1].copies.is_empty(), "nothing is fetched");
    assert_eq!(codes(&plan, 1), [Opcode::Assign, Opcode::Sin], "the condition is known");
}

#[test]
fn copies_are_passed_over() {
    let source = "shader source (output float o = 0) { o = noise (P); }";
    let dot = "shader dot (float x = 0, output float o = 0) { o = x; }";
    let plan = plan(&group(&[source, dot, LAST], &["a.o b.x", "b.o c.x"]));
    assert_eq!(plan.layers[2].copies.iter().map(|copy| copy.layer).collect::<Vec<_>>(), [0], "the source");
}

#[test]
fn equal_layers_are_one() {
    let place = "shader place (output float o = 0) { o = noise (P); }";
    let sum = "shader sum (float x = 0, float y = 0, output float f = 0) { f = x + y; }";
    let plan = plan(&group(&[place, place, sum], &["a.o c.x", "b.o c.y"]));
    assert!(plan.layers[2].copies.iter().all(|copy| copy.layer == 0), "both come from the first");
}

#[test]
fn outputs_without_readers_are_not_made() {
    let two = "shader two (output float o = 0, output color c = 0) { o = u; c = noise (P) * v; }";
    let plan = plan(&group(&[two, LAST], &["a.o b.x"]));
    assert_eq!(codes(&plan, 0), [Opcode::Assign], "the colour goes");
}
