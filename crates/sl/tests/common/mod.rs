// SPDX-License-Identifier: GPL-3.0-or-later
//! Runs a shader's text at one point of an empty world.

use gnurt_sl::diagnostics::Style;
use gnurt_sl::exec::{Event, Host, Machine, Plan, PlanOptions, Point};
use gnurt_sl::group::Group;
use gnurt_sl::ir::Shader;
use gnurt_sl::{Compiled, Options, compile};
use gnurt_sl_lib::color::ColorSystem;
use std::sync::Arc;

/// A world in which nothing is.
pub(crate) struct Empty(ColorSystem);

impl Default for Empty {
    fn default() -> Self {
        Self(ColorSystem::named("Rec709").expect("it is known"))
    }
}

impl Host for Empty {
    fn color_system(&self) -> &ColorSystem {
        &self.0
    }
}

/// Compiles a text without files.
pub(crate) fn compiled(text: &str) -> Compiled {
    compile("test.osl", text, &Options::default(), &|_| None)
}

/// All messages about a text.
#[allow(dead_code, reason = "not every test asks for messages")]
pub(crate) fn messages(text: &str, style: Style) -> String {
    let compiled = compiled(text);
    compiled.diagnostics.list.iter().map(|d| d.render(&compiled.sources, style)).collect()
}

/// The shader of a text.
pub(crate) fn shader(text: &str) -> Shader {
    let compiled = compiled(text);
    let diagnostics_of: Vec<String> = compiled.diagnostics.list.iter().map(|d| d.message.clone()).collect();
    compiled.shader.unwrap_or_else(|| panic!("it does not compile: {diagnostics_of:?}\n{text}"))
}

/// The output of a group at one point.
pub(crate) fn diagnostics_of(group: &Group) -> Vec<Event> {
    let plan = Plan::new(group, &PlanOptions::default()).expect("all operations are known");
    let world = Empty::default();
    let mut machine = Machine::new(&plan, &world);
    machine.run(&Point::default());
    machine.events
}

/// The output of a shader, errors as lines that start with `ERROR`.
#[allow(dead_code, reason = "not every test runs shaders")]
pub(crate) fn output(text: &str) -> String {
    let mut group = Group::default();
    group.add(Arc::new(shader(text)), None, &[], &mut Vec::new());
    diagnostics_of(&group)
        .into_iter()
        .map(|event| match event {
            Event::Print(text) => text,
            Event::Error(text) => format!("ERROR {text}\n"),
            Event::Warning(text) => format!("WARNING {text}\n"),
            Event::File(name, text) => format!("{name}: {text}"),
        })
        .collect()
}

/// The output of statements in a shader's body.
#[allow(dead_code, reason = "not every test runs shaders")]
pub(crate) fn body(statements: &str) -> String {
    output(&format!("shader test() {{ {statements} }}"))
}
