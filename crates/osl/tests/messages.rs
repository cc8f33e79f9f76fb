// SPDX-License-Identifier: GPL-3.0-or-later
//! Messages name the place, the fault and the remedy.

use gnurt_osl::{Empty, Error, Event, GroupBuilder, Point, Shader, ShadingSystem};

fn compiled(system: &ShadingSystem, text: &str) -> Shader {
    system.compile("test.osl", text).expect("the text compiles")
}

#[track_caller]
fn fault(group: GroupBuilder, parts: &[&str]) {
    let why = group.build().expect_err("it must not be built").to_string();
    for part in parts {
        assert!(why.contains(part), "'{part}' is not in: {why}");
    }
    assert!(!why.contains("ConnectShaders") && why.lines().count() == 1, "{why}");
}

#[test]
fn parameters_are_named_with_layer_shader_and_suggestion() {
    let system = ShadingSystem::new();
    let matte = compiled(
        &system,
        "surface matte (color Cs = 0.5, float Kd = 1, closure color under = 0) { Ci = Kd * Cs * diffuse (N) + under; }",
    );
    let group = || system.group("g");
    fault(
        group().param("kd", 0.5).shader(&matte, "m"),
        &["layer 'm' (shader 'matte'): unknown parameter 'kd'; did you mean 'Kd'? parameters: Cs, Kd"],
    );
    fault(
        group().param("Kd", [1.0, 2.0, 3.0]).shader(&matte, "m"),
        &["parameter 'Kd' is of type float; the value is three floats"],
    );
    fault(group().param("under", 1.0).shader(&matte, "m"), &["parameter 'under' is a closure"]);
    fault(
        group().param("nix", 1).param("nox", 2).shader(&matte, "m"),
        &["unknown parameter 'nix'; parameters", "'nox'"],
    );
}

#[test]
fn connections_are_named_with_layers_and_remedies() {
    let system = ShadingSystem::new();
    let dots =
        compiled(&system, "shader dots (float size = 1, output color Cout = 0) { Cout = mod (P, size); }");
    let matte = compiled(&system, "surface matte (color Cs = 0.5) { Ci = Cs * diffuse (N); }");
    let both = || system.group("g").shader(&dots, "dots").shader(&matte, "matte");
    fault(
        both().connect("dot", "Cout", "matte", "Cs"),
        &["'dot.Cout' to 'matte.Cs': unknown layer 'dot'; did you mean 'dots'? layers so far: dots, matte"],
    );
    fault(
        system
            .group("g")
            .shader(&dots, "dots")
            .connect("dots", "Cout", "matte", "Cs")
            .shader(&matte, "matte"),
        &["unknown layer 'matte'", "layers are added before they are connected"],
    );
    fault(
        both().connect("dots", "cout", "matte", "Cs"),
        &["layer 'dots' (shader 'dots') has no 'cout'; did you mean 'Cout'? outputs: Cout"],
    );
    fault(
        both().connect("dots", "Cout", "matte", "Kd"),
        &["layer 'matte' (shader 'matte') has no 'Kd'", "inputs: Cs"],
    );
    fault(both().connect("matte", "Cs", "dots", "size"), &["layer 'dots' must follow layer 'matte'"]);
    let named =
        compiled(&system, "shader named (string name = \"\", output float x = 0) { x = strlen (name); }");
    fault(
        both().shader(&named, "named").connect("dots", "Cout", "named", "name"),
        &["'dots.Cout' to 'named.name': cannot connect a color (Cout) to a string (name)"],
    );
}

#[test]
fn live_parameters_that_could_not_be_set_are_rejected() {
    let system = ShadingSystem::new();
    let one = compiled(&system, "shader one (output float x = 1) { x = u; }");
    let two = compiled(&system, "shader two (float a = 1, output float y = 1) { y = a; }");
    let open = compiled(
        &system,
        "shader open (float a = 1 [[ int interpolated = 1 ]], output float z = 1) { z = a; }",
    );
    let group = |live: bool| {
        let made = system.group("g").shader(&one, "one");
        let made = if live { made.live_param("a", 2.0) } else { made.param("a", 2.0) };
        made.shader(&two, "two").connect("one", "x", "two", "a").output("y")
    };
    fault(group(true), &["layer 'two': live parameter 'a' is connected"]);
    assert!(group(false).build().is_ok());
    fault(
        system.group("g").shader(&open, "open").live_param("a", 2.0).shader(&two, "two"),
        &["layer 'two': live parameter 'a' has the name of an interpolated parameter of layer 'open'"],
    );
    // The last of several values counts.
    let twice = system.group("g").live_param("a", 2.0).live_param("a", 3.0).shader(&two, "two").output("y");
    let shaded = twice.build().expect("a group").run(&Empty, &[Point::default()]);
    assert_eq!(shaded.output("y").expect("kept").values, [3.0]);
}

#[test]
fn layers_that_never_run_are_warned_of() {
    let system = ShadingSystem::new();
    let dots = compiled(&system, "shader dots (output color Cout = 0) { Cout = mod (P, 1); }");
    let matte = compiled(&system, "surface matte (color Cs = 0.5) { Ci = Cs * diffuse (N); }");
    let wrong = system.group("g").shader(&matte, "matte").shader(&dots, "dots").build().expect("a group");
    assert!(wrong.run(&Empty, &[Point::default()]).lobes(0).is_empty());
    let [warning] = wrong.warnings() else { panic!("{:?}", wrong.warnings()) };
    assert!(warning.starts_with("layer 'matte' never runs"), "{warning}");
    let both = || system.group("g").shader(&dots, "dots").shader(&matte, "matte");
    let right = both().connect("dots", "Cout", "matte", "Cs").build().expect("a group");
    assert_eq!(right.warnings(), [""; 0]);
    assert_eq!(both().output("dots.Cout").build().expect("a group").warnings(), [""; 0]);
    assert_eq!(both().build().expect("a group").warnings().len(), 1);
}

#[test]
fn mistakes_at_run_time_name_file_line_and_layer() {
    let system = ShadingSystem::new();
    let shader = compiled(
        &system,
        "shader s (output point q = 0)\n{\n    q = transform (\"object\", P);\n    q += transformc (\"odd\", color (u));\n}\n",
    );
    for system in [ShadingSystem::new(), ShadingSystem::new().interpreted()] {
        let group = system.group("g").shader(&shader, "moved").output("q").build().expect("a group");
        group.wait_for_code();
        let events = group.run(&Empty, &vec![Point::default(); 20]).events;
        assert_eq!(events.len(), 40);
        for (line, what) in [(3, "Unknown transformation \"object\""), (4, "odd")] {
            let place = format!("at test.osl:{line} in layer \"moved\" (shader \"s\")");
            let is_that = |event: &Event| matches!(event, Event::Error(text) if text.contains(what) && text.ends_with(&place));
            assert_eq!(events.iter().filter(|(_, event)| is_that(event)).count(), 20, "{events:?}");
        }
    }
}

#[test]
fn folders_that_do_not_exist_are_named() {
    let system = ShadingSystem::new().include("absent/folder");
    let shader = system.compile("a.osl", "shader a () { }").expect("a shader");
    assert_eq!(shader.warnings.concat(), "absent/folder: missing folder of include\n");
    let Err(Error::Compile(messages)) = system.compile("a.osl", "#include \"b.h\"\nshader a () { }") else {
        panic!("there is no b.h")
    };
    assert!(messages.concat().contains("absent/folder"), "{messages:?}");
    let system = ShadingSystem::new().include(env!("CARGO_MANIFEST_DIR"));
    assert!(system.compile("a.osl", "shader a () { }").expect("a shader").warnings.is_empty());
}

#[test]
fn one_mistake_is_one_message() {
    let wrong = ShadingSystem::new().compile("a.osl", "surface a () {\n    Ci = diffuse (N, 1, 2);\n}\n");
    let Err(Error::Compile(messages)) = wrong else { panic!("no such function") };
    assert!(messages.len() == 1 && messages[0].contains("No matching function"), "{messages:?}");
}

#[test]
#[should_panic(expected = "there is no point 3: the group ran for 2 points")]
fn points_beyond_the_last_are_a_bug_of_the_caller() {
    let system = ShadingSystem::new();
    let shader = compiled(&system, "surface s () { Ci = diffuse (N); }");
    let group = system.group("g").shader(&shader, "s").build().expect("a group");
    let _ = group.run(&Empty, &[Point::default(), Point::default()]).lobes(3);
}
