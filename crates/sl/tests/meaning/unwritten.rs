// SPDX-License-Identifier: GPL-3.0-or-later
//! Reads of variables that were never written.

use crate::common::{Empty, shader};
use gnurt_sl::exec::{Event, Machine, Plan, PlanOptions, Point};
use gnurt_sl::group::Group;
use std::sync::Arc;

/// What is told at two points: kind and name of each variable, and the operation with its number.
fn told(body: &str) -> [Vec<String>; 2] {
    let mut group = Group::default();
    let text = format!("shader test (output float f = 0) {{ {body} }}");
    group.add(Arc::new(shader(&text)), None, &[], &mut Vec::new());
    let options = PlanOptions { optimise: false, ..PlanOptions::default() };
    let (plan, world) = (Plan::new(&group, &options).expect("it is known"), Empty::default());
    let mut machine = Machine::new(&plan, &world);
    machine.check_reads_of_unwritten();
    [0, 1].map(|index| {
        machine.run(&Point { index, ..Point::default() });
        let text = |event| match event {
            Event::Error(text) => text,
            other => panic!("{other:?}"),
        };
        let short = |text: String| {
            let (_, rest) = text.split_once("uninitialized value in ").expect("another message");
            let (what, rest) = rest.split_once(" at ").expect("a place");
            let (_, op) = rest.split_once("op ").expect("an operation");
            format!("{what}: {}", op.trim_end_matches(')'))
        };
        machine.events.drain(..).map(text).map(short).collect()
    })
}

#[test]
fn reads_of_what_was_never_written_are_told_at_each_point_once() {
    // Operation 0 evaluates the output.
    for (body, expected) in [
        ("float x; f = x; f += x;", &["float x: 1 'assign', arg 1"][..]),
        ("float x = 1; f = x;", &[]),
        ("float x; if (u > 2) x = 1; f = x;", &["float x: 4 'assign', arg 1"]),
        ("{ float x; f += x; }", &["float x: 1 'add', arg 2"]),
        ("color c; c[1] = 1; f = c[1]; f = c[2];", &["color c: 4 'compref', arg 1"]),
        ("float a[3]; int i = 1; a[i] = 2; f = a[i]; f = a[i + 1];", &["float[3] a: 6 'aref', arg 1"]),
        ("matrix m; m[1][2] = 3; f = m[1][2]; f = m[2][1];", &["matrix m: 4 'mxcompref', arg 1"]),
        ("int i; if (i) f = 1;", &["int i: 1 'if', arg 0"]),
        // The condition is compared with 0 by OSL's compiler: a number more.
        ("for (int i = 0; i < 2; ++i) f = 1; string s; f = strlen (s);", &["string s: 7 'strlen', arg 1"]),
        ("color c = color (1, 2, 3); float a[2] = {u, v}; f = c[1] + a[0] + P[2] + f;", &[]),
        ("int k (output int x) { x = 1; return 2; } int x; f = k (x) + x;", &[]),
    ] {
        let expected: Vec<String> = expected.iter().map(ToString::to_string).collect();
        assert_eq!(told(body), [expected.clone(), expected], "{body}");
    }
}
