// SPDX-License-Identifier: GPL-3.0-or-later
//! Point clouds that shaders search, read and write.

use crate::common::{Empty, shader};
use gnurt_sl::exec::{Event, Host, Machine, Plan, PlanOptions, Point};
use gnurt_sl::group::Group;
use gnurt_sl_lib::Dual;
use gnurt_sl_lib::color::ColorSystem;
use gnurt_sl_lib::points::{Column, PointCloud};
use std::cell::RefCell;
use std::sync::Arc;

/// A world with one cloud, "a".
#[derive(Default)]
struct Cloudy(Empty, RefCell<PointCloud>);

impl Host for Cloudy {
    fn color_system(&self) -> &ColorSystem {
        self.0.color_system()
    }

    fn point_cloud(&self, file: &str) -> Result<Arc<PointCloud>, String> {
        if file == "a" {
            Ok(Arc::new(self.1.borrow().clone()))
        } else {
            Err(format!("could not open \"{file}\""))
        }
    }

    fn write_point(&self, file: &str, position: [f32; 3], row: &[Column]) -> Result<bool, String> {
        assert_eq!(file, "a");
        Ok(self.1.borrow_mut().push(position, row))
    }
}

/// The output of statements at a point of that world.
fn diagnostics_of(world: &Cloudy, statements: &str, p: [f32; 3]) -> String {
    let mut group = Group::default();
    group.add(Arc::new(shader(&format!("shader test () {{ {statements} }}"))), None, &[], &mut Vec::new());
    let plan = Plan::new(&group, &PlanOptions::default()).expect("all operations are known");
    let mut machine = Machine::new(&plan, world);
    let p = Dual::new(p, [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    machine.run(&Point { p, ..Point::default() });
    let text = |event: &Event| match event {
        Event::Print(text) => text.clone(),
        Event::Error(text) => format!("ERROR {text}\n"),
        other => panic!("{other:?}"),
    };
    machine.events.iter().map(text).collect()
}

const WRITE: &str = "int fits = pointcloud_write (\"a\", P, \"u\", P[0] * 10, \"c\", (color) P, \"n\", int (P[0]), \"s\", format (\"p%g\", P[0]));
    printf (\"%d\", fits);";

#[test]
fn points_are_written_and_found() {
    let world = Cloudy::default();
    for x in [0.0, 1.0, 2.0, 4.0] {
        assert_eq!(diagnostics_of(&world, WRITE, [x, 0.0, 0.0]), "1");
    }
    assert_eq!(
        diagnostics_of(&world, "printf (\"%d\", pointcloud_write (\"a\", P, \"u\", 3));", [9.0; 3]),
        "0",
        "another kind"
    );
    let declarations = "int index[3]; float far[3]; float ten[4]; color c[3]; string s[3]; int n[3]; point at[3];
        int found = pointcloud_search (\"a\", P, 2.5, 10, 1, \"index\", index, \"distance\", far, \"u\", ten, \"s\", s);
        printf (\"%d:%d %d %d;%g %g;%g %g;%s;\", found, index[0], index[1], index[2], far[0], far[2], ten[0], ten[1], s[1]);
        printf (\"%d %d;\", pointcloud_get (\"a\", index, found, \"c\", c), pointcloud_get (\"a\", index, 2, \"n\", n));
        printf (\"%d;\", pointcloud_get (\"a\", index, 1, \"position\", at));
        printf (\"%g %d %g %g\", c[2], n[1], Dx (far[1]), at[0][0]);";
    let expected = "3:1 2 0;0.25 1.25;10 20;p2;1 1;1;0 0 0 2 -1 1";
    assert_eq!(
        diagnostics_of(&world, declarations, [1.25, 0.0, 0.0]),
        expected,
        "nearest first; arrays bound how many"
    );
}

#[test]
fn what_is_not_there_is_told() {
    let world = Cloudy::default();
    diagnostics_of(&world, WRITE, [0.0; 3]);
    for (statements, expected) in [
        (
            "int i[2]; printf (\"%d\", pointcloud_search (\"b\", P, 1, 2, \"index\", i));",
            "ERROR pointcloud_search: could not open \"b\"\n0",
        ),
        ("int i[2]; printf (\"%d\", pointcloud_search (\"\", P, 1, 2, \"index\", i));", "0"),
        (
            "int i[1]; float x[1]; printf (\"%d\", pointcloud_get (\"a\", i, 1, \"w\", x));",
            "ERROR Accessing unexisting attribute w in pointcloud \"a\"\n0",
        ),
        (
            "int i[1]; int x[1]; printf (\"%d\", pointcloud_get (\"a\", i, 1, \"u\", x));",
            "ERROR Type of attribute \"u\" : float[1] not compatible with OSL's int[1] in \"a\" pointcloud\n0",
        ),
        (
            "int i[1] = { -5 }; float x[1] = { 7 }; printf (\"%d %g\", pointcloud_get (\"a\", i, 1, \"u\", x), x[0]);",
            "1 0",
        ),
        (
            "int i[1]; float x[1] = { 7 }; printf (\"%d %g\", pointcloud_get (\"b\", i, 0, \"u\", x), x[0]);",
            "1 7",
        ),
    ] {
        assert_eq!(diagnostics_of(&world, statements, [0.0; 3]), expected, "{statements}");
    }
}
