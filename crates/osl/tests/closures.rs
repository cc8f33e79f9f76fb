// SPDX-License-Identifier: GPL-3.0-or-later
//! The list of closures in the documentation, values of all types, and the fields that a group reads.

use std::collections::BTreeSet;

use gnurt_osl::{Argument, Empty, Needs, Point, ShadingSystem, Value, standard_closures};

#[test]
fn the_documentation_has_all_closures_with_their_parameters() {
    let page = include_str!("../CLOSURES.md").replace("\n  ", " ");
    let rows = page.lines().filter_map(|line| line.strip_prefix("* `")?.split_once("`:"));
    let rows: Vec<(&str, &str)> = rows.filter(|(name, _)| name.contains(" (")).collect();
    let declared: BTreeSet<String> = standard_closures().iter().map(ToString::to_string).collect();
    let documented: BTreeSet<String> = rows.iter().map(|(text, _)| (*text).to_owned()).collect();
    assert_eq!(documented, declared);
    assert_eq!(rows.len(), standard_closures().len(), "each once");
    assert!(rows.iter().all(|(_, meaning)| meaning.trim().len() > 5), "{rows:?}");
}

#[test]
fn arguments_are_found_by_name_and_short_forms_arrive_as_long_ones() {
    let system = ShadingSystem::new();
    let text = "surface s () { Ci = microfacet (\"ggx\", N, 0.3, 1.5, 1) + reflection (N); }";
    let shader = system.compile("s.osl", text).expect("a shader");
    let group = system.group("g").shader(&shader, "s").build().expect("a group");
    let point = Point { n: [0.0, 0.0, 1.0], ..Point::default() };
    let shaded = group.run(&Empty, &[point]);
    let [rough, mirror] = shaded.lobes(0) else { panic!("two closures") };
    let names: Vec<&str> = rough.parameters().iter().map(|param| &*param.name).collect();
    assert_eq!(names, ["distribution", "N", "U", "xalpha", "yalpha", "eta", "refract"]);
    assert_eq!((rough.float(3), rough.triple(2)), (0.3, [0.0; 3]));
    assert_eq!(rough.named("yalpha"), Some(&Argument::Float(0.3)));
    assert_eq!(rough.named("refract"), Some(&Argument::Int(1)));
    assert_eq!(rough.named("alpha"), None);
    assert_eq!(mirror.named("eta"), Some(&Argument::Float(0.0)));
}

#[test]
fn keywords_that_are_not_given_are_zero() {
    let system = ShadingSystem::new();
    let shader =
        system.compile("s.osl", "surface s () { Ci = sheen_bsdf (N, color (1), 0.5); }").expect("a shader");
    let group = system.group("g").shader(&shader, "s").build().expect("a group");
    let shaded = group.run(&Empty, &[Point::default()]);
    assert_eq!(shaded.lobes(0)[0].named("mode"), Some(&Argument::Int(0)));
    assert_eq!(shaded.lobes(0)[0].named("thinfilm_ior"), None, "it has no such keyword");
}

#[test]
fn rust_values_of_all_kinds_are_parameters() {
    let system = ShadingSystem::new();
    let text =
        "shader s (float a = 0, int b[2] = {0, 0}, string c = \"\", string d[2] = {\"\", \"\"}, matrix e = 1,
        color f[2] = {0, 0}, float g[3] = {0, 0, 0}, output float sums[7] = {0, 0, 0, 0, 0, 0, 0}) {
        sums[0] = a;
        sums[1] = b[0] + 10 * b[1];
        sums[2] = strlen (c);
        sums[3] = strlen (d[0]) + 10 * strlen (d[1]);
        sums[4] = e[3][0];
        sums[5] = f[1][2];
        sums[6] = g[2];
    }";
    let shader = system.compile("s.osl", text).expect("a shader");
    let moved = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [4.0, 0.0, 0.0, 1.0]];
    let group = system
        .group("g")
        .param("a", std::f64::consts::PI)
        .param("b", [1, 2].as_slice())
        .param("c", String::from("four"))
        .param("d", ["a", "bcd"].as_slice())
        .param("e", moved)
        .param("f", [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]].as_slice())
        .param("g", [1.0, 2.0, 3.0].as_slice())
        .shader(&shader, "s")
        .output("sums");
    let shaded = group.build().expect("all fit").run(&Empty, &[Point::default()]);
    assert_eq!(shaded.outputs()[0].values, [std::f32::consts::PI, 21.0, 4.0, 31.0, 4.0, 6.0, 3.0]);
    assert_eq!(Value::from(0.25), Value::from(0.25_f32));
}

fn needs(text: &str) -> Needs {
    let system = ShadingSystem::new();
    let shader = system.compile("s.osl", text).expect("a shader");
    system.group("g").shader(&shader, "s").build().expect("a group").needs().clone()
}

#[test]
fn functions_that_read_a_point_count_among_its_fields() {
    let found = needs("surface s () { Ci = (backfacing () ? 1 : 1 / surfacearea ()) * emission (); }");
    assert_eq!(found.fields.into_iter().collect::<Vec<_>>(), ["backfacing", "surface_area"]);
    let found = needs(
        "shader s (output vector a = 0) { a = calculatenormal (P) * raytype (\"shadow\") * dPdu * random (); }",
    );
    assert_eq!(found.fields.into_iter().collect::<Vec<_>>(), ["dpdu", "flipped", "index", "p", "ray_kinds"]);
    assert_eq!(found.derivatives.into_iter().collect::<Vec<_>>(), ["p"]);
    let found = needs("shader s (output float a = 0) { a = Dx (u * 2) + v + N[0]; }");
    assert_eq!(found.derivatives.into_iter().collect::<Vec<_>>(), ["u"]);
}
