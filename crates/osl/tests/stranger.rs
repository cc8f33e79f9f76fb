// SPDX-License-Identifier: GPL-3.0-or-later
//! What the documentation promises, by the public interface alone, as another renderer would use it.

use gnurt_osl::{
    Argument, Data, Empty, Error, Event, Given, Host, Point, Shader, ShadingSystem, TextureOptions, Type,
};

fn points(count: usize) -> Vec<Point> {
    let point = |k: usize| Point {
        u: ((k as f32 + 0.5) / count as f32).into(),
        p: [k as f32, 1.0, 2.0].into(),
        n: [0.0, 0.0, 1.0],
        index: k as i32,
        ..Point::default()
    };
    (0..count).map(point).collect()
}

fn compiled(system: &ShadingSystem, text: &str) -> Shader {
    system.compile("test.osl", text).expect("the text compiles")
}

#[test]
fn mistakes_name_file_line_and_remedy() {
    let system = ShadingSystem::new();
    let Err(Error::Compile(messages)) =
        system.compile("red.osl", "surface red ()\n{\n    Ci = difuse (N);\n}\n")
    else {
        panic!("it must not compile")
    };
    let all = messages.concat();
    assert!(all.contains("red.osl:3") && all.contains("difuse") && all.contains("diffuse"), "{all}");
    let absent = system.read("absent.osl").expect_err("there is no such file");
    assert!(absent.to_string().starts_with("absent.osl: "), "{absent}");
    let damaged = system.read_oso("a.oso", "OpenShadingLanguage 1.00\nnonsense").expect_err("no shader");
    assert!(damaged.to_string().starts_with("a.oso: "), "{damaged}");
    let shader = compiled(&system, "shader s (float a = 1, output float b = 0) { b = a; }");
    let group = || system.group("g");
    for (made, expected) in [
        (group().build(), "it has no layers"),
        (
            group().param("c", 1.0).shader(&shader, "s").build(),
            "layer 's' (shader 's'): unknown parameter 'c'; did you mean 'a'? parameters: a, b",
        ),
        (
            group().param("a", "one").shader(&shader, "s").build(),
            "parameter 'a' is of type float; the value is a text",
        ),
        (
            group().shader(&shader, "s").output("d").build(),
            "there is no output 'd' of floats or ints; outputs: s.b",
        ),
        (group().shader(&shader, "s").shader(&shader, "s").build(), "two layers are named 's'"),
        (group().shader(&shader, "s").param("a", 1.0).build(), "parameter 'a' has no shader after it"),
        (
            group().shader(&shader, "s").shader(&shader, "t").connect("t", "b", "s", "a").build(),
            "layer 's' must follow layer 't'",
        ),
        (
            group()
                .live_param("a", 1.0)
                .shader(&shader, "s")
                .live_param("a", 1.0)
                .shader(&shader, "t")
                .build(),
            "both have a live parameter 'a'",
        ),
    ] {
        let why = made.expect_err(expected).to_string();
        assert!(why.starts_with("group 'g': ") && why.contains(expected), "{why}");
    }
}

#[test]
fn compiled_forms_come_back() {
    let system = ShadingSystem::new();
    let shader =
        compiled(&system, "surface s (color Cs = 0.5, string name = \"a\") { Ci = Cs * diffuse (N); }");
    let again = system.read_oso("s.oso", &shader.oso()).expect("it is a shader");
    assert_eq!((again.name(), again.kind(), again.parameters()), ("s", "surface", shader.parameters()));
    assert_eq!(shader.parameters()[0].ty, Type::COLOR);
}

#[test]
fn needs_are_those_of_the_code() {
    let system = ShadingSystem::new();
    let text =
        "surface s (string map = \"wood.exr\", float worn = 0 [[ int interpolated = 1 ]], float live = 1) {
        color c = texture (map, u, v);
        float age = 0;
        getattribute (\"car\", \"age\", age);
        getattribute (\"dust\", age);
        point q = transform (\"object\", P);
        if (raytype (\"shadow\")) c *= q[0] * age * worn * live;
        if (trace (P, N)) c = 0;
        Ci = c * diffuse (N) + emission ();
    }";
    let shader = compiled(&system, text);
    let group = system.group("g").live_param("live", 2.0).shader(&shader, "s").build().expect("a group");
    let needs = group.needs();
    let list = |set: &std::collections::BTreeSet<String>| set.iter().cloned().collect::<Vec<_>>().join(" ");
    assert_eq!(list(&needs.globals), "Ci N P u v");
    let names = |set: &std::collections::BTreeSet<&str>| set.iter().copied().collect::<Vec<_>>().join(" ");
    assert_eq!(names(&needs.fields), "n p ray_kinds u v");
    assert_eq!(names(&needs.derivatives), "p u v", "of the filter of the texture, and of the ray");
    assert_eq!(list(&needs.textures), "wood.exr");
    assert_eq!(list(&needs.userdata), "worn", "live parameters are not asked of the geometry");
    assert_eq!(list(&needs.closures), "diffuse emission");
    assert!(list(&needs.spaces).contains("object") && needs.ray_kinds.contains("shadow") && needs.traces);
    let pair = |object: &str, name: &str| (object.to_owned(), name.to_owned());
    assert!(needs.attributes.contains(&pair("car", "age")) && needs.attributes.contains(&pair("", "dust")));
    assert!(!needs.has_unknown_names);
    let unknown = compiled(
        &system,
        "shader s (output color c = 0) { c = texture (format (\"%d.exr\", int (u * 9)), u, v); }",
    );
    assert!(system.group("h").shader(&unknown, "s").build().expect("a group").needs().has_unknown_names);
}

struct World;

impl Host for World {
    fn userdata(&self, name: &str, _: Type, point: &Point) -> Option<Given> {
        (name == "worn").then(|| Data::Float(vec![point.index as f32 + 1.0]).into())
    }

    fn attribute(&self, object: &str, name: &str, _: Option<i32>, ty: Type, _: &Point) -> Option<Given> {
        (object == "car" && name == "age" && ty == Type::FLOAT).then(|| Data::Float(vec![7.0]).into())
    }

    fn texture(
        &self,
        file: &str,
        [s, t]: [gnurt_osl::Dual<f32>; 2],
        _: &TextureOptions,
        _: &Point,
    ) -> Result<[gnurt_osl::Dual<f32>; 4], String> {
        (file == "wood.exr").then(|| [s, t, 0.25.into(), 1.0.into()]).ok_or_else(|| format!("no {file}"))
    }
}

#[test]
fn hosts_answer_and_engines_agree() {
    let text = "surface s (float worn = 0 [[ int interpolated = 1 ]], output color seen = 0, output float age = 0) {
        seen = texture (\"wood.exr\", u, 0.5);
        getattribute (\"car\", \"age\", age);
        Ci = worn * microfacet (\"ggx\", N, 0.3, 1.5, 0)
            + layer (dielectric_bsdf (N, vector (1, 0, 0), color (1), color (0), 0.1, 0.1, 1.5, \"ggx\", \"thinfilm_ior\", 1.3),
                     seen * diffuse (N));
    }";
    let [machine, interpreter] = [ShadingSystem::new(), ShadingSystem::new().interpreted()].map(|system| {
        let shader = compiled(&system, text);
        let group =
            system.group("g").shader(&shader, "s").output("seen").output("age").build().expect("a group");
        group.wait_for_code();
        let statistics = group.statistics();
        assert!(statistics.layers == 1 && statistics.cells > 0);
        group.run(&World, &points(37))
    });
    assert_eq!(machine.output("age").expect("kept").values, vec![7.0; 37]);
    for k in 0..37 {
        assert_eq!(machine.lobes(k), interpreter.lobes(k), "point {k}");
        let seen = &machine.output("seen").expect("kept").values[3 * k..3 * k + 3];
        assert_eq!(seen, [(k as f32 + 0.5) / 37.0, 0.5, 0.25]);
        let [first, second] = machine.lobes(k) else { panic!("two closures") };
        assert_eq!((&*first.name, first.text(0), first.weight), ("microfacet", "ggx", [k as f32 + 1.0; 3]));
        let ([top], [base]) = (second.lobes(0), second.lobes(1)) else { panic!("a layer holds two") };
        assert_eq!(top.named("thinfilm_ior"), Some(&Argument::Float(1.3)));
        assert_eq!((&*base.name, base.weight), ("diffuse", [seen[0], seen[1], seen[2]]));
    }
}

#[test]
fn messages_name_their_points() {
    let system = ShadingSystem::new();
    let shader = compiled(&system, "shader s () { if (u > 0.9) warning (\"late: %d\", int (P[0])); }");
    let group = system.group("g").shader(&shader, "s").build().expect("a group");
    let events = group.run(&Empty, &points(40)).events;
    assert_eq!(events.len(), 4, "{events:?}");
    let (point, Event::Warning(text)) = &events[0] else { panic!("{events:?}") };
    assert!(*point == 36 && text.contains("late: 36"), "{point}: {text}");
}

#[test]
fn live_parameters_change_without_compiling() {
    let system = ShadingSystem::new();
    let text = "shader s (color tint = 1, int count = 2, output color c = 0) { c = tint * count * u; }";
    let shader = compiled(&system, text);
    let group =
        system.group("g").live_param("tint", [1.0, 2.0, 3.0]).live_param("count", 3).shader(&shader, "s");
    let group = group.output("c").build().expect("a group");
    let at_half = [Point { u: 0.5.into(), ..Point::default() }];
    let seen = || group.run(&Empty, &at_half).output("c").expect("kept").values.clone();
    assert_eq!(seen(), [1.5, 3.0, 4.5]);
    group.set("s", "tint", [4.0, 0.0, 2.0]).expect("a colour");
    group.set("s", "count", 1).expect("a number");
    assert_eq!(seen(), [2.0, 0.0, 1.0]);
    let wrong = group.set("s", "tint", "red").expect_err("a text").to_string();
    assert!(wrong.contains("parameter 'tint' is of type color; the value is a text"), "{wrong}");
    assert!(group.set("s", "u", 1.0).expect_err("absent").to_string().contains("no live parameter 'u'"));
}

#[test]
fn threads_share_a_group() {
    let system = ShadingSystem::new();
    let shader = compiled(&system, "surface s () { Ci = noise (P * 3.7) * diffuse (N); }");
    let group = system.group("g").shader(&shader, "s").build().expect("a group");
    let expected = group.run(&Empty, &points(200));
    std::thread::scope(|scope| {
        for _ in 0..4 {
            scope.spawn(|| {
                let found = group.run(&Empty, &points(200));
                (0..200).for_each(|k| assert_eq!(found.lobes(k), expected.lobes(k), "point {k}"));
            });
        }
    });
}
