// SPDX-License-Identifier: GPL-3.0-or-later
//! Extensions to OSL, and points in batches.

use crate::common::{Empty, compiled, shader};
use gnurt_sl::exec::{
    Arriving, ClosureDecl, ClosureParam, Event, Host, LANES, Machine, Plan, PlanOptions, Point, Points,
    Program, Results, TraceOptions,
};
use gnurt_sl::group::Group;
use gnurt_sl::types::Type;
use gnurt_sl::{Options, compile};
use gnurt_sl_lib::Dual;
use gnurt_sl_lib::color::ColorSystem;
use std::sync::Arc;

/// Three lights, of which the second reaches nothing; rays see their direction.
struct Lit(Empty, [ClosureDecl; 2]);

impl Default for Lit {
    fn default() -> Self {
        let normal = ClosureParam::new("N", Type::NORMAL);
        let diffuse = ClosureDecl { name: "diffuse".into(), params: [normal].into() };
        Self(Empty::default(), [diffuse, ClosureDecl { name: "emission".into(), params: [].into() }])
    }
}

impl Host for Lit {
    fn color_system(&self) -> &ColorSystem {
        self.0.color_system()
    }

    fn closures(&self) -> &[ClosureDecl] {
        &self.1
    }

    fn light_count(&self) -> i32 {
        3
    }

    fn illuminate(
        &self,
        light: i32,
        p: [f32; 3],
        category: &str,
        shadowed: bool,
        _: &Point,
    ) -> Option<Arriving> {
        let strength = if shadowed { 1.0 } else { 10.0 } + if category == "key" { 100.0 } else { 0.0 };
        let dir = if light == 0 { [0.0, 0.0, 1.0] } else { [1.0, 0.0, 0.0] };
        (light != 1).then_some(Arriving {
            dir,
            light: [strength; 3],
            distance: p[0] + light as f32,
            pdf: 0.5,
        })
    }

    fn trace(&self, _: Dual<[f32; 3]>, r: Dual<[f32; 3]>, options: &TraceOptions, _: &Point) -> bool {
        r.value[2] < options.maxdist
    }

    fn radiance(&self, _: Dual<[f32; 3]>, r: Dual<[f32; 3]>, _: &TraceOptions, _: &Point) -> [f32; 3] {
        r.value
    }
}

fn plan(text: &str, outputs: &[&str]) -> Plan {
    let mut group = Group::default();
    group.add(Arc::new(shader(text)), None, &[], &mut Vec::new());
    let outputs = outputs.iter().map(ToString::to_string).collect();
    Plan::new(&group, &PlanOptions { outputs, iterations: 1000, ..PlanOptions::default() })
        .expect("it is known")
}

fn printed(text: &str) -> String {
    let (plan, world) = (plan(text, &[]), Lit::default());
    let mut machine = Machine::new(&plan, &world);
    machine.run(&Point { p: Dual::from([7.0, 0.0, 0.0]), ..Point::default() });
    let text = |event| match event {
        Event::Print(text) => text,
        other => format!("{other:?}"),
    };
    machine.events.into_iter().map(text).collect()
}

#[test]
fn light_loops_go_through_the_lights_that_reach_the_point() {
    let body = r#"printf("%g %g %g %g; ", L[0], Cl[0], lightdist, lightpdf);"#;
    for (head, expected) in [
        ("(P)", "0 1 7 0.5; 1 1 9 0.5; "),
        ("(P, \"shadow\", 0)", "0 10 7 0.5; 1 10 9 0.5; "),
        ("(P + 1, \"category\", \"key\")", "0 101 8 0.5; 1 101 10 0.5; "),
        ("(P, vector (0, 0, 2), 0.5)", "0 1 7 0.5; "),
        ("(P, vector (2, 0, 0), 0.5, \"shadow\", 0)", "1 10 9 0.5; "),
    ] {
        let found = printed(&format!("surface s () {{ illuminance {head} {{ {body} }} }}"));
        assert_eq!(found, expected, "illuminance {head}");
    }
    let nested = "surface s () { int n = 0; illuminance (P) illuminance (P) { if (lightdist > 8) continue; ++n; } printf (\"%d\", n); }";
    assert_eq!(printed(nested), "2", "loops in loops, and left early");
}

#[test]
fn trace_gives_a_colour_where_one_is_wanted() {
    let text = r#"surface s () {
        vector d = vector (0.25, 0.5, 0.75);
        color seen = trace (P, d);
        int hit = trace (P, d), near = trace (P, d, "maxdist", 0.5);
        printf ("%g %d %d %g %d", seen, hit, near, 2 * (color) trace (P, d), trace (P, d) ? 3 : 4);
    }"#;
    assert_eq!(printed(text), "0.25 0.5 0.75 1 0 0.5 1 1.5 3", "what is seen, and whether");
    let strict = Options { strict: true, ..Options::default() };
    let osl = "surface s () { color seen = trace (P, I); printf (\"%g\", seen); }";
    let compiled = compile("s.osl", osl, &strict, &|_| None).shader.expect("OSL knows it");
    let colour = gnurt_sl::ir::write(&compiled, "");
    assert!(colour.contains("int"), "an int that becomes grey: {colour}");
}

#[test]
fn osl_itself_has_none_of_it() {
    let strict = Options { strict: true, ..Options::default() };
    for text in [
        "light l () { }",
        "camera c () { }",
        "pixel p () { }",
        "environment e () { }",
        "surface s () { illuminance (P) { } }",
        "surface s () { Ci = radiance (); }",
    ] {
        let known = compile("s.osl", text, &Options::default(), &|_| None);
        assert!(known.shader.is_some(), "{text}: {:?}", known.diagnostics);
        assert!(compile("s.osl", text, &strict, &|_| None).shader.is_none(), "{text} is not OSL");
    }
    // Names of OSL's programs stay theirs.
    let names = "struct light { float a; }; light make (float x) { light l; l.a = x; return l; }
        surface s (float camera = 1, color pixel = 0) { float weight = 2, L = 3; light l = make (weight + L + camera); printf (\"%g\", l.a); }";
    assert_eq!(printed(names), "6", "no new word is reserved");
    let found = compiled("surface s () { float a = lightdist; }");
    assert!(found.shader.is_none(), "only lights know it");
}

#[test]
fn lights_and_cameras_leave_what_they_say() {
    let light = plan(
        "light l (color c = 2) { vector way = point (1, 2, 2) - Ps; lightdist = length (way); L = normalize (way); Cl = c * xi[1]; }",
        &["L", "Cl", "lightdist"],
    );
    let mut points = Points { count: 2, ..Points::default() };
    points.set(0, &Point { xi: [0.0, 0.25], ..Point::default() });
    points.set(1, &Point { ps: Dual::from([1.0, 2.0, 1.0]), xi: [0.0, 0.5], ..Point::default() });
    let mut out = Results::default();
    light.run(&Lit::default(), &points, &mut out);
    let at =
        |name: &str| light.retained().iter().find(|retained| retained.name == name).expect("it is kept").row;
    assert_eq!(out.rows[at("lightdist")][..2], [3.0, 1.0], "how far");
    assert_eq!(out.rows[at("L") + 2][..2], [2.0 / 3.0, 1.0], "where");
    assert_eq!(out.rows[at("Cl")][..2], [0.5, 1.0], "how much");
    let camera = plan(
        "camera c () { I = vector (u, v, raster[0]); P = 1; if (u > 1) { weight = 2; tmax = 3; } }",
        &["P", "I", "weight", "tmax"],
    );
    points.set(0, &Point { u: 0.5.into(), v: 0.25.into(), raster: [9.0, 0.0], ..Point::default() });
    camera.run(&Lit::default(), &points, &mut out);
    let row = |k: usize| out.rows[k][0];
    assert_eq!((0..10).map(row).collect::<Vec<_>>(), [1.0, 1.0, 1.0, 0.5, 0.25, 9.0, 1.0, 1.0, 1.0, 1e30]);
}

#[test]
fn batches_are_points() {
    let text = "surface s (output float a = 0, output int b = 0) {
        a = noise (P * 3) + Dx (P[0]) * u; b = int (10 * v);
        Ci = a * diffuse (N); if (v > 0.5) Ci = Ci + v * emission () * color (1, 2, 3); printf (\"%d\", b); }";
    let (plan, world) = (plan(text, &["a", "b"]), Lit::default());
    let mut points = Points { count: LANES, ..Points::default() };
    let all: Vec<Point> = (0..LANES)
        .map(|i| {
            let x = i as f32 / 7.0;
            let p = Dual::new([x, 1.0 - x, x * x], [x, 0.0, 0.0], [0.0; 3]);
            Point { p, u: x.into(), v: (i as f32 / 16.0).into(), n: [0.0, 1.0, x], ..Point::default() }
        })
        .collect();
    all.iter().enumerate().for_each(|(lane, point)| points.set(lane, point));
    let mut out = Results::default();
    for _ in 0..2 {
        plan.run(&world, &points, &mut out);
        let mut machine = Machine::new(&plan, &world);
        for (lane, point) in all.iter().enumerate() {
            assert_eq!(format!("{:?}", points.point(lane)), format!("{point:?}"), "as it was put in");
            machine.run(point);
            for retained in plan.retained() {
                let (_, data) = machine.output(Some(0), &retained.name).expect("an output");
                let one = match data {
                    gnurt_sl::hir::Data::Int(list) => list[0] as f32,
                    gnurt_sl::hir::Data::Float(list) => list[0],
                    gnurt_sl::hir::Data::Str(_) => unreachable!("numbers"),
                };
                assert_eq!(out.rows[retained.row][lane], one, "{} at {lane}", retained.name);
            }
            let one: Vec<_> = machine
                .components(machine.ci())
                .into_iter()
                .map(|(weight, component)| {
                    let numbers = component.params.into_iter().flat_map(|(_, _, data)| match data {
                        gnurt_sl::hir::Data::Float(list) => list,
                        _ => unreachable!("floats"),
                    });
                    (weight, component.name, numbers.collect::<Vec<_>>())
                })
                .collect();
            let many: Vec<_> = out
                .closures
                .parts(out.ci[lane], lane)
                .into_iter()
                .map(|(weight, part)| {
                    let decl = &world.closures()[part.kind as usize];
                    let count: usize = decl.params.iter().map(|param| param.ty.size()).sum();
                    let numbers = (0..count).map(|i| f32::from_bits(part.cells(i).at(lane)));
                    (weight, decl.name.clone(), numbers.collect::<Vec<_>>())
                })
                .collect();
            assert_eq!(one, many, "closures at {lane}");
        }
        let diagnostics_of: Vec<_> = out.events.iter().map(|(lane, _)| *lane).collect();
        assert_eq!(diagnostics_of, (0..LANES).collect::<Vec<_>>(), "each says its own");
    }
}

#[test]
fn what_does_not_end_is_left_out() {
    let (plan, world) = (plan("surface s () { while (1) { } Ci = emission (); }", &[]), Lit::default());
    let points = Points { count: LANES, ..Points::default() };
    let mut out = Results::default();
    let mut diagnostics_of = 0;
    for _ in 0..4 {
        plan.run(&world, &points, &mut out);
        diagnostics_of += out.events.len();
        assert_eq!(out.ci, [0; LANES], "nothing comes out");
    }
    assert_eq!(diagnostics_of, 33, "told of each, and that there is an end to it");
}

#[test]
fn dictionaries_are_asked() {
    let text = r#"shader test () {
        string all = "<pack><lens name='wide' f='24,28,1'/><lens name='long' f='85 105'/></pack>";
        for (int lens = dict_find (all, "//lens"); lens; lens = dict_next (lens)) {
            string name; vector f;
            dict_value (lens, "name", name);
            int found = dict_value (lens, "f", f);
            printf ("%s %g %d;", name, f, found + dict_value (lens, "none", name));
        }
        printf ("%d", dict_find ("none.xml", "//lens") + dict_find ("none.xml", "//lens"));
    }"#;
    let out = crate::common::output(text);
    let expected =
        "wide 24 28 1 1;long 85 105 0 1;ERROR XML parsed with errors: File was not found, at offset 0\n-2";
    assert_eq!(out, expected, "nodes in order, numbers with any gap, a missing file told once");
}

#[test]
fn results_that_are_no_numbers_are_told_where_that_is_asked_for() {
    let mut group = Group::default();
    let text = "shader test (float x = 1e30, output float y = 0, output float z = 0) { y = (x + u) * x; z = y - y; }";
    group.add(Arc::new(shader(text)), None, &[], &mut Vec::new());
    let plan = Plan::new(&group, &PlanOptions::default()).expect("all operations are known");
    let world = Empty::default();
    let mut machine = Machine::new(&plan, &world);
    machine.run(&Point::default());
    assert_eq!(machine.events, [], "nobody asked");
    machine.check_numbers();
    machine.run(&Point::default());
    let diagnostics_of: Vec<String> = machine.events.iter().map(|event| format!("{event:?}")).collect();
    assert!(
        diagnostics_of[0].contains("inf value in y") && diagnostics_of[1].contains("nan value in z"),
        "{diagnostics_of:?}"
    );
}

/// Known weights of 0 and 1, nothing at all, variables that are read before they are written, loops, and functions that end early.
#[test]
fn closures_are_the_same_where_known_weights_are_left_out() {
    for body in [
        "float w = 0; closure color c = w * emission (); Ci = c + (1 - w) * diffuse (N);",
        "float w = 1; closure color c = w * emission (), d = 0; Ci = (1 - w) * c + w * (d + c) + d;",
        "color w = color (1, 0, 1); closure color c = w * emission (); Ci = c * w + c * color (1) + c * 0;",
        "closure color c = 0; if (u > 0.5) c = diffuse (N); Ci = c + 0 * diffuse (N); Ci += c;",
        "closure color c; for (int i = 0; i < 3; ++i) { closure color d = i * emission (); c = c + d * 1; } Ci = c;",
        "closure color d; for (int i = 0; i < 2; ++i) { Ci = Ci + d; d = emission (); float w = i; Ci += w * d; }",
        "float before = 3; closure color c = before * emission (); float w; c = w * c + c; w = 1; Ci = w * c;",
        "closure color half (float x) { closure color none = 0; if (x > 0.5) return none; return x * diffuse (N); } Ci = half (0.75) + half (0) + half (0.25);",
        "closure color c = emission (); c = 0; Ci = c; c = diffuse (N); Ci = Ci + c * 1; c = 0 * c;",
        "if (u > 2) return; float w = 2; w = w; Ci = w * 0.5 * emission () + 0 * (w * diffuse (N));",
    ] {
        let mut group = Group::default();
        let text = format!("surface s () {{ {body} }}");
        let (functions, main) = match body.split_once("} Ci = half") {
            Some((function, main)) => (format!("{function}}}"), format!("Ci = half{main}")),
            None => (String::new(), body.to_owned()),
        };
        let text = if functions.is_empty() { text } else { format!("{functions} surface s () {{ {main} }}") };
        group.add(Arc::new(shader(&text)), None, &[], &mut Vec::new());
        let world = Lit::default();
        let found = [false, true].map(|optimise| {
            let options = PlanOptions { optimise, ..PlanOptions::default() };
            let plan = Plan::new(&group, &options).expect("it is known");
            let mut machine = Machine::new(&plan, &world);
            [0.25, 0.75].map(|u: f32| {
                machine.run(&Point { u: u.into(), n: [0.0, 1.0, 0.0], ..Point::default() });
                let list = machine.components(machine.ci());
                format!("{list:?}")
            })
        });
        assert_eq!(found[0], found[1], "{text}");
        assert!(found[0][1] != "[]" || found[0][0] != "[]", "something is left: {text}");
    }
}
