// SPDX-License-Identifier: GPL-3.0-or-later
//! Texts that mean harm: nothing panics, hangs or takes memory that a text does not account for.

use crate::common::{Empty, body, compiled};
use gnurt_sl::exec::{
    ClosureDecl, ClosureParam, Event, Host, Machine, Plan, PlanOptions, Point, unknown_operation,
};
use gnurt_sl::group::{Group, read_group, write_group};
use gnurt_sl::ir::{SymbolKind, read, write};
use gnurt_sl::types::Type;
use gnurt_sl_lib::color::ColorSystem;
use std::sync::Arc;

const SHADER: &str = r#"
#define TWICE(x) ((x) * 2)
struct A { float x; color c[2]; };
float f(A a, output int k) { k = 1; for (int i = 0; i < 3; ++i) { if (i == 1) continue; k += i; } return a.x ? TWICE(a.c[1].r) : noise(P); }
surface test [[ string help = "a\"b" ]] (float Kd = 1.0 / 3 [[ float min = 0 ]], string n[] = {"x", "y"}, output color o = color("hsv", 1, 2, 3))
{
    A a = { 1, { 2, color(3) } };
    int k;
    o = f(a, k) + length(Dx(P)) * (vector) color(k, u, v);
    string s = format("%d %s", k, n[1]);
    if (startswith(s, "a") || regex_search(s, "[a-z]+")) { printf("%s\n", s); }
    Ci += Kd * diffuse(N, "label", s) + 0.5 * emission();
    getattribute("camera:fov", a.x);
}
"#;

/// Small numbers that look random.
struct Dice(u32);

impl Dice {
    fn roll(&mut self, sides: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 17;
        self.0 ^= self.0 << 5;
        self.0 as usize % sides.max(1)
    }
}

fn mutated(text: &str, dice: &mut Dice) -> String {
    let mut bytes = text.as_bytes().to_vec();
    for _ in 0..=dice.roll(4) {
        let at = dice.roll(bytes.len());
        let signs = b"(){}[];,.+-*/=<>!&|^~?:\"#%\\ \n0159aPe_";
        match dice.roll(4) {
            0 => drop(bytes.remove(at)),
            1 => bytes.insert(at, signs[dice.roll(signs.len())]),
            2 => bytes[at] = signs[dice.roll(signs.len())],
            _ => {
                let end = (at + dice.roll(40)).min(bytes.len());
                let part = bytes[at..end].to_vec();
                let to = dice.roll(bytes.len());
                bytes.splice(to..to, part);
            }
        }
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

/// The results and output of a shader at a point, stopped soon.
fn given(shader: gnurt_sl::ir::Shader) -> String {
    if unknown_operation(&shader).is_some() {
        return "refused".into();
    }
    let outputs: Vec<String> = shader
        .params()
        .filter(|(_, s)| s.kind == SymbolKind::OutputParam && s.ty.struct_id().is_none())
        .map(|(_, s)| s.name.to_string())
        .collect();
    let mut group = Group::default();
    group.add(Arc::new(shader), None, &[], &mut Vec::new());
    let Ok(plan) = Plan::new(&group, &PlanOptions { iterations: 200, ..PlanOptions::default() }) else {
        return "refused".into();
    };
    let world = Empty::default();
    let mut machine = Machine::new(&plan, &world);
    machine.run(&Point { p: [0.5, 2.0, -1.0].into(), u: 0.25.into(), v: 0.75.into(), ..Point::default() });
    let values: Vec<_> = outputs.iter().map(|name| machine.output(Some(0), name)).collect();
    format!("{:?} {values:?}", machine.events)
}

/// Texts of all kinds changed by chance for `GNURT_MUTATE` seconds: those of the shader library, whole or two of them spliced, compiled, run, written, read and
/// run again; files of compiled shaders; groups. Without the variable, a hundred turns.
#[test]
fn changed_texts_are_refused_or_run() {
    let seconds: Option<f64> = std::env::var("GNURT_MUTATE").ok().and_then(|text| text.parse().ok());
    let seed = std::env::var("GNURT_SEED").ok().and_then(|text| text.parse().ok()).unwrap_or(7);
    let mut texts = vec![SHADER.to_owned()];
    for kind in ["surfaces", "lights", "skies", "cameras", "pixels"] {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../shaders/").to_owned() + kind;
        let files = std::fs::read_dir(folder).expect("the shader library").flatten();
        texts.extend(files.filter_map(|file| std::fs::read_to_string(file.path()).ok()));
    }
    texts[1..].sort();
    let files: Vec<String> =
        texts.iter().filter_map(|text| Some(write(&compiled(text).shader?, ""))).collect();
    let groups = "param float[2] a 1 2 [[int interpolated=1]] ; param string s \"x\" ; shader a l ; shader a m ; connect l.a m.b[1] ; connect l.o m.Kd ;";
    let (mut dice, start) = (Dice(seed), std::time::Instant::now());
    let mut counts = [0_u64; 4];
    let known: Option<Arc<gnurt_sl::ir::Shader>> = compiled(SHADER).shader.map(Arc::new);
    while seconds.map_or(counts[0] < 100, |seconds| start.elapsed().as_secs_f64() < seconds) {
        let of = |dice: &mut Dice, count: usize| if dice.roll(2) == 0 { 0 } else { dice.roll(count) };
        let mut text = mutated(&texts[of(&mut dice, texts.len())], &mut dice);
        if dice.roll(4) == 0 {
            let other = &texts[dice.roll(texts.len())];
            let cut = |text: &str, at: usize| String::from_utf8_lossy(&text.as_bytes()[..at]).into_owned();
            text = cut(&text, dice.roll(text.len())) + &cut(other, dice.roll(other.len()));
        }
        let made = compiled(&text);
        counts[0] += 1;
        let wrong = made.diagnostics.list.iter().any(|d| d.message.contains("the compiler made a mistake"));
        assert!(!wrong, "seed {seed}: what is lowered is whole: {text}");
        if let Some(shader) = made.shader {
            let file = write(&shader, "");
            let back = read(&file).unwrap_or_else(|why| panic!("seed {seed}: {why}\n{text}\n{file}"));
            assert_eq!(write(&back, ""), file, "seed {seed}: written again: {text}");
            assert_eq!(given(back), given(shader), "seed {seed}: read back it does the same: {text}");
            counts[1] += 1;
        }
        if let Ok(shader) = read(&mutated(&files[of(&mut dice, files.len())], &mut dice)) {
            given(shader);
            counts[2] += 1;
        }
        let mut find = |_: &str| known.clone();
        if let Ok(group) = read_group("g", &mutated(groups, &mut dice), &mut find, &mut Vec::new()) {
            let again = read_group("g", &write_group(&group), &mut find, &mut Vec::new());
            assert!(again.is_ok(), "seed {seed}: {again:?}");
            counts[3] += 1;
        }
    }
    eprintln!(
        "{} texts, of which {} compile; {} files and {} groups that are read",
        counts[0], counts[1], counts[2], counts[3]
    );
}

/// One of each operation that takes a fixed number of operands.
const OPERATIONS: &str = r#"
shader test (output color o = 0, output string s = "a", output matrix m = 1)
{
    int k = getchar("abc", u > 0) + strlen(s) + startswith(s, "a") + endswith(s, "b") + stoi(s) + raytype("camera");
    k += hash(P, u) + backfacing() + isconnected(o) + isconstant(s) + lightcount() + regex_search(s, "b") + (k % 3);
    float x = stof(s) + dot(N, P) + length(P) + distance(P, N) + area(P) + determinant(m) + luminance(o) + surfacearea();
    float knots[4] = { 0, 1, 2, 3 };
    x += spline("linear", u, knots) + splineinverse("linear", u, knots) + transformu("mm", "m", u);
    x += mix(u, v, x) + step(u, v) + clamp(x, u, v) + atan2(u, v) + sin(u) + smoothstep(u, v, x) + filterwidth(u) + Dx(u);
    float y[2] = { sin(x), cos(x) };
    float si, co; sincos(u, si, co);
    x += noise(P) + noise("perlin", u, v) + cellnoise(P) + snoise(u) + pnoise(u, 2) + random() + y[k] + o[k] + m[k][1];
    s = concat(substr(s, 1, 2), format("%g", x), "z");
    string parts[2]; split(s, parts, "b");
    vector n = cross(N, P) + normalize(P) + calculatenormal(P) + transform("world", P) + vector("world", u, v, x);
    m = transpose(m) * matrix("common", "world") * matrix(u);
    getattribute("a", x); setmessage("b", x); getmessage("b", x);
    float d; dict_value(dict_find(s, "q"), "a", d); trace(P, N); printf("%g", x);
    color t = texture("x", u, v) + environment("x", N) + blackbody(x) + wavelength_color(x) + transformc("hsv", "rgb", o);
    int size[2]; gettextureinfo("x", "resolution", size);
    o = n + x + k + co + d + t + color("hsv", u, v, x);
    Ci = u * diffuse(N) + emission();
}
"#;

#[test]
fn operations_may_lack_operands() {
    let file = write(&compiled(OPERATIONS).shader.expect("it compiles"), "");
    let lines: Vec<&str> = file.lines().collect();
    let code = lines.iter().position(|line| line.starts_with("code")).expect("it has code");
    let mut refused = 0;
    for (i, line) in lines.iter().enumerate().skip(code + 1) {
        let mut pieces: Vec<&str> = line.split(' ').collect();
        while let Some(last) = pieces.iter().rposition(|piece| !piece.contains(['%', '\t'])) {
            pieces.remove(last);
            let shorter = pieces.join(" ");
            let text = [&lines[..i], &[&*shorter], &lines[i + 1..]].concat().join("\n");
            refused +=
                u32::from(read(&text).is_err() || given(read(&text).expect("it was read")) == "refused");
        }
    }
    assert!(refused > 100, "{refused} are refused");
}

#[test]
fn nesting_has_an_end() {
    for open in ["(", "-", "!", "{", "f(", "a[", "if (1) ", "for (;;) ", "1 + (", "a = ", "1 ? ", "(float)"] {
        let text = format!("shader test() {{ float a = {} }}", open.repeat(100_000));
        assert!(compiled(&text).shader.is_none(), "{open}");
        let text = format!("shader test() {{ {} }}", open.repeat(100_000));
        assert!(compiled(&text).shader.is_none(), "{open}");
    }
    let sum = format!("shader test() {{ float a = {}1; }}", "u + ".repeat(100_000));
    assert!(
        compiled(&sum).diagnostics.list[0].message.contains("nested more than"),
        "a long sum is deep as well"
    );
}

#[test]
fn macros_have_an_end() {
    let bomb: String = (0..40).map(|i| format!("#define A{} A{i} A{i} A{i}\n", i + 1)).collect();
    let text = format!("#define A0 1 +\n{bomb}shader test() {{ float a = A40 1; }}");
    assert!(compiled(&text).shader.is_none(), "too many tokens");
    assert!(
        compiled("#define A B\n#define B A\nshader A() {}").shader.is_some(),
        "a macro is not expanded in itself"
    );
}

#[test]
fn functions_in_functions_have_an_end() {
    let chain: String =
        (0..40).map(|i| format!("float f{}(float x) {{ return f{i}(x) + f{i}(x + 1); }}\n", i + 1)).collect();
    let text = format!("float f0(float x) {{ return x; }}\n{chain}shader test() {{ float a = f40(u); }}");
    let compiled = compiled(&text);
    assert!(compiled.diagnostics.list[0].message.contains("too large"), "{:?}", compiled.diagnostics.list[0]);
}

#[test]
fn endless_loops_are_stopped() {
    let out = body("int i = 0; while (1) { i = i * 3 + 1; } printf(\"never\");");
    assert!(out.starts_with("ERROR stopped: a loop at test.osl:1 did not end"), "{out}");
    assert!(!out.contains("never"), "{out}");
}

#[test]
fn huge_arrays_and_texts_are_refused() {
    assert!(
        compiled("shader test() { float a[2000000000]; }").shader.is_none(),
        "an array of two thousand million"
    );
    let many = "shader test() { float a[9000000]; float b[9000000]; a[1] = u; b[1] = u; printf(\"%g\", a[2] + b[2]); }";
    let many = compiled(many).shader.expect("a shader");
    let mut group = Group::default();
    group.add(Arc::new(many), None, &[], &mut Vec::new());
    let why = Plan::new(&group, &PlanOptions::default()).err().expect("too much together");
    assert!(why.contains("shader test: 'b' (float[9000000]): with it the group has more than"), "{why}");
    let out = body(
        "string s = \"abcdefgh\"; for (int i = 0; i < 60; ++i) s = concat(s, s); printf(\"%d\", strlen(s) < 2000000);",
    );
    assert_eq!(out, "1", "texts stop growing");
}

/// A constant where a function writes: the fuzzer's.
#[test]
fn constants_are_not_written() {
    let text = "float f(output int k) { k += 1; return k; } shader test(output float a = 0) { a = f(5) + 10 * f(5); }";
    let made = compiled(text);
    let wrong: Vec<_> = made.diagnostics.list.iter().map(|d| d.message.clone()).collect();
    let shader = made.shader.unwrap_or_else(|| panic!("{wrong:?}"));
    assert!(write(&shader, "").contains("shader test"), "it is written");
}

/// Runs something on a thread with the stack that threads of renderers have.
fn on_a_small_stack<T: Send + 'static>(work: impl FnOnce() -> T + Send + 'static) -> T {
    let thread = std::thread::Builder::new().stack_size(2 << 20).spawn(work).expect("a thread");
    thread.join().expect("it ends")
}

/// Blocks in blocks times functions in functions.
#[test]
fn inlined_blocks_have_an_end() {
    for (blocks, functions) in [(390, 40), (390, 2), (100, 60), (12, 55), (1, 500)] {
        let open = "if (u > 0) ".repeat(blocks);
        let function = |i: usize| match i {
            0 => format!("void f0 (output float k) {{ {open} k += 1; }}\n"),
            i => format!("void f{i} (output float k) {{ {open} f{} (k); }}\n", i - 1),
        };
        let functions_text: String = (0..functions).map(function).collect();
        let text = format!("{functions_text} shader t (output float k = 0) {{ f{} (k); }}", functions - 1);
        let diagnostics_of = on_a_small_stack(move || {
            let made = compiled(&text);
            let diagnostics_of: Vec<String> =
                made.diagnostics.list.iter().map(|d| d.message.clone()).collect();
            if let Some(shader) = made.shader {
                given(shader);
            }
            diagnostics_of.join("; ")
        });
        match (blocks + 2) * functions > 800 {
            true => {
                assert!(
                    diagnostics_of.contains("deep once functions are in place"),
                    "{blocks} {functions}: {diagnostics_of}"
                )
            }
            false => assert_eq!(diagnostics_of, "", "{blocks} {functions}"),
        }
    }
}

/// Deep expressions in deep blocks in functions.
#[test]
fn inlined_expressions_have_an_end() {
    let open = "if (u > 0) ".repeat(300);
    let terms = "u + ".repeat(390);
    let function = |i: usize| match i {
        0 => "float f0 () { return u; }\n".to_owned(),
        i => format!("float f{i} () {{ float k = 0; {open} k = f{} () + {terms} 1; return k; }}\n", i - 1),
    };
    let functions: String = (0..60).map(function).collect();
    let text = format!("{functions} shader t (output float k = 0) {{ k = f59 (); }}");
    let diagnostics_of =
        on_a_small_stack(move || compiled(&text).diagnostics.list.first().map(|d| d.message.clone()));
    assert!(
        diagnostics_of
            .as_ref()
            .is_some_and(|diagnostics_of| diagnostics_of.contains("deep once functions are in place")),
        "{diagnostics_of:?}"
    );
}

/// A chain of layers each of which reads the one before below so many blocks.
fn chain(layers: usize, blocks: usize) -> Group {
    let open = "if (u > -1) ".repeat(blocks);
    let text = format!("shader t (float a = 0, output float b = 0) {{ {open} b = a + 1; }}");
    let shader = Arc::new(compiled(&text).shader.expect("a shader"));
    let last = compiled("shader t (float a = 0) { printf (\"%g\", a); }").shader.expect("a shader");
    let mut group = Group::default();
    for i in 0..layers {
        let name = format!("l{i}");
        group.add(shader.clone(), Some(&name), &[], &mut Vec::new());
        if i > 0 {
            group.connect(&format!("l{}", i - 1), "b", &name, "a").expect("they fit");
        }
    }
    group.add(Arc::new(last), Some("last"), &[], &mut Vec::new());
    group.connect(&format!("l{}", layers - 1), "b", "last", "a").expect("they fit");
    group
}

#[test]
fn long_chains_of_layers_run() {
    for (layers, blocks) in [(5000, 0), (300, 300), (3, 390)] {
        let diagnostics_of = on_a_small_stack(move || super::common::diagnostics_of(&chain(layers, blocks)));
        assert_eq!(diagnostics_of, [Event::Print(layers.to_string())], "{layers} layers, {blocks} blocks");
    }
}

/// A layer that is started by itself finds nothing done before it.
#[test]
fn long_chains_of_layers_started_at_their_end_are_stopped() {
    let diagnostics_of = on_a_small_stack(|| {
        let options = PlanOptions { entries: vec![5000], ..PlanOptions::default() };
        let plan = Plan::new(&chain(5000, 0), &options).expect("a plan");
        let world = Empty::default();
        let mut machine = Machine::new(&plan, &world);
        machine.begin(&Point::default());
        machine.run_layer(5000);
        std::mem::take(&mut machine.events)
    });
    let text = format!("{diagnostics_of:?}");
    assert!(text.contains("layers wait for each other") && diagnostics_of.len() <= 2, "{text}");
}

/// A world with closures that take closures.
struct Coats(Empty, Vec<ClosureDecl>);

impl Default for Coats {
    fn default() -> Self {
        let param = |ty: Type| ClosureParam::new("", ty);
        let decl =
            |name: &str, params: Vec<ClosureParam>| ClosureDecl { name: name.into(), params: params.into() };
        let layer = decl("layer", vec![param(Type::CLOSURE), param(Type::CLOSURE)]);
        Self(Empty::default(), vec![decl("diffuse", vec![param(Type::NORMAL)]), layer])
    }
}

impl Host for Coats {
    fn color_system(&self) -> &ColorSystem {
        self.0.color_system()
    }

    fn closures(&self) -> &[ClosureDecl] {
        &self.1
    }
}

#[test]
fn closures_as_texts_have_an_end() {
    for (grow, iterations) in [
        ("layer (c, diffuse (N))", 100_000),
        ("layer (c, c)", 40),
        ("c + c", 40),
        ("c + diffuse (N)", 100_000),
    ] {
        let text = format!(
            "shader t () {{ closure color c = diffuse (N); for (int i = 0; i < {iterations}; ++i) c = {grow}; string s = format (\"%s\", c); printf (\"%d\", strlen (s)); Ci = c; }}"
        );
        let shader = compiled(&text).shader.expect("a shader");
        let (diagnostics_of, parts) = on_a_small_stack(move || {
            let mut group = Group::default();
            group.add(Arc::new(shader), None, &[], &mut Vec::new());
            let plan = Plan::new(&group, &PlanOptions::default()).expect("a plan");
            let world = Coats::default();
            let mut machine = Machine::new(&plan, &world);
            machine.run(&Point::default());
            let parts = machine.components(machine.ci()).len();
            (std::mem::take(&mut machine.events), parts)
        });
        let [Event::Print(length)] = &diagnostics_of[..] else { panic!("{grow}: {diagnostics_of:?}") };
        let length: usize = length.parse().expect("a number");
        assert!((100..2 << 20).contains(&length), "{grow}: a text of {length} bytes");
        assert!(parts <= 100_000, "{grow}: {parts} components");
    }
}

/// A closure's number that no closure has yet: a connection that should not be, or a file that was made by hand.
#[test]
fn closures_do_not_name_themselves() {
    let file = "OpenShadingLanguage 1.00\nsurface t\nlocal closure color c\nlocal int k\nconst int one 1\nconst float half 0.5\nglobal closure color Ci\ncode ___main___\nassign k one %argrw{\"wr\"}\nassign c k %argrw{\"wr\"}\nmul Ci half c %argrw{\"wrr\"}\nend\n";
    let shader = read(file).expect("it is read");
    let mut group = Group::default();
    group.add(Arc::new(shader), None, &[], &mut Vec::new());
    let plan = Plan::new(&group, &PlanOptions::default()).expect("a plan");
    let world = Coats::default();
    let mut machine = Machine::new(&plan, &world);
    machine.run(&Point::default());
    assert_eq!(machine.closure_text(machine.ci()), "", "nothing");
}

#[test]
fn structs_are_connected_by_their_types() {
    let from = "struct A { float a; string b; }; shader t (output A s = { 0.5, \"x\" }) { }";
    let to = |fields: &str| {
        format!(
            "struct B {{ {fields} }}; shader t (B s = {{ {} }}) {{ }}",
            if fields.starts_with("float") { "0, \"\"" } else { "\"\", 0" }
        )
    };
    for (fields, fits) in [("float c; string d;", true), ("string a; float b;", false)] {
        let mut group = Group::default();
        group.add(Arc::new(compiled(from).shader.expect("a shader")), Some("a"), &[], &mut Vec::new());
        let second = compiled(&to(fields)).shader.expect("a shader");
        group.add(Arc::new(second), Some("b"), &[], &mut Vec::new());
        let made = group.connect("a", "s", "b", "s");
        assert_eq!(made.is_ok(), fits, "{fields} {made:?}");
    }
}

/// Files may declare any types of their symbols: no access leaves a symbol.
#[test]
fn operations_of_wrong_types_stay_within_their_symbols() {
    let file = "OpenShadingLanguage 1.00\nsurface t\nglobal normal N\nlocal float y\nlocal float x\ncode ___main___\nOPERATION\nend\n";
    for operation in [
        "cross x N N %argrw{\"wrr\"}",
        "cross y N N %argrw{\"wrr\"}",
        "normalize x N %argrw{\"wr\"}",
        "color x y y y %argrw{\"wrrr\"}",
        "compassign x y y %argrw{\"wrr\"}",
        "getmatrix x y y %argrw{\"wrr\"}",
        "transpose x x %argrw{\"wr\"}",
        "mxcompassign x y y y %argrw{\"wrrr\"}",
        "mxcompref x x y y %argrw{\"wrrr\"}",
        "dot x x x %argrw{\"wrr\"}",
        "dict_value y x x x %argrw{\"wrrw\"}",
        "pointcloud_search y x x x x x x x %argrw{\"wrrrrrrw\"}",
        "spline x x x x x %argrw{\"wrrrr\"}",
        "gettextureinfo y x x x %argrw{\"wrrw\"}",
        "texture x x x x %argrw{\"wrrr\"}",
        "regex_search y x x x %argrw{\"wrrw\"}",
        "split y x x x x %argrw{\"wrrrr\"}",
        "sincos x x N %argrw{\"rww\"}",
        "setmessage x x %argrw{\"rr\"}",
        "getmessage y x x %argrw{\"wrw\"}",
        "noise x N N N N %argrw{\"wrrrr\"}",
    ] {
        let Ok(shader) = read(&file.replace("OPERATION", operation)) else { continue };
        given(shader);
    }
}

/// Seconds of work of this thread, or elapsed seconds if unknown.
fn worked(start: std::time::Instant) -> f64 {
    let reported = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
    let nanoseconds =
        reported.as_deref().and_then(|reported| reported.split(' ').next()?.parse::<f64>().ok());
    nanoseconds.map_or(start.elapsed().as_secs_f64(), |ns| ns * 1e-9)
}

/// Fails if something takes as long as texts do whose time grows with the square of their length.
fn soon<T>(what: &str, work: impl FnOnce() -> T) -> T {
    let start = std::time::Instant::now();
    let before = worked(start);
    let made = work();
    let took = worked(start) - before;
    assert!(took < 4.0, "{what}: {took} seconds");
    made
}

#[test]
fn quotes_without_an_end_are_read_once() {
    let text = format!("shader t () {{ string s = \"{}", "\\\"".repeat(300_000));
    soon("quotes", || assert!(compiled(&text).shader.is_none(), "no end"));
}

#[test]
fn headers_that_include_themselves_have_an_end() {
    let bomb = format!("#include \"bomb.h\"\n#include \"bomb.h\"\n{}", "// nothing\n".repeat(20_000));
    let load = |_: &std::path::Path| Some(bomb.clone());
    let made = soon("includes", || {
        gnurt_sl::compile(
            "t.osl",
            "#include \"bomb.h\"\nshader t () {}",
            &gnurt_sl::Options::default(),
            &load,
        )
    });
    let diagnostics_of: Vec<_> = made.diagnostics.list.iter().map(|d| &*d.message).collect();
    assert!(
        diagnostics_of.iter().any(|diagnostics_of| diagnostics_of.contains("as often as it is included")),
        "{diagnostics_of:?}"
    );
    let bytes: usize = made.sources.files().iter().map(|file| file.text.len()).sum();
    assert!(bytes < 64 << 20, "{bytes} bytes are kept");
}

#[test]
fn wrong_names_are_not_all_compared() {
    let known: String = (0..10_000).map(|i| format!("float known_name_{i} = 0;\n")).collect();
    let wrong: String = (0..10_000).map(|i| format!("unknown_name_{i};\n")).collect();
    soon("names", || assert!(compiled(&format!("shader t () {{ {known}{wrong} }}")).shader.is_none()));
}

#[test]
fn functions_of_one_name_are_looked_at_once() {
    let structs: String = (0..1200)
        .map(|i| format!("struct S{i} {{ float x; }}; float f (S{i} s) {{ return {i}; }}\n"))
        .collect();
    let calls: String = (0..1200).map(|i| format!("S{i} s{i}; s{i}.x = u; k += f (s{i});\n")).collect();
    let text = format!("{structs} shader t (output float k = 0) {{ {calls} }}");
    soon("overloads", || assert!(compiled(&text).shader.is_some()));
}

/// A chain that ends in nothing is left out as a whole.
#[test]
fn dead_chains_go_at_once() {
    let chain: String = (1..20_000).map(|i| format!("float a{i} = a{} * 2 + 1;\n", i - 1)).collect();
    let shader =
        compiled(&format!("shader t (output float k = 0) {{ float a0 = u; {chain} k = u; }}")).shader;
    let mut group = Group::default();
    group.add(Arc::new(shader.expect("a shader")), None, &[], &mut Vec::new());
    let plan = soon("a chain", || Plan::new(&group, &PlanOptions::default()).expect("a plan"));
    assert!(plan.layers[0].code.len() < 3, "{} operations are left", plan.layers[0].code.len());
}

#[test]
fn files_of_shaders_name_many_files() {
    let lines: String =
        (0..60_000).map(|i| format!("assign x y %filename{{\"f{i}.osl\"}} %argrw{{\"wr\"}}\n")).collect();
    let text = format!(
        "OpenShadingLanguage 1.00\nsurface t\nlocal float y\nlocal float x\ncode ___main___\n{lines}end\n"
    );
    soon("files", || assert!(read(&text).is_ok()));
}

/// Error messages of a loop are kept up to a limit.
#[test]
fn mistakes_in_loops_are_not_all_kept() {
    let text =
        "shader t (output float f = 0) { float a[2] = {u, v}; for (int i = 0; i < 400000; ++i) f += a[i]; }";
    let mut group = Group::default();
    group.add(Arc::new(compiled(text).shader.expect("a shader")), None, &[], &mut Vec::new());
    let bytes: usize =
        super::common::diagnostics_of(&group).iter().map(|event| format!("{event:?}").len()).sum();
    assert!((1 << 20..20 << 20).contains(&bytes), "{bytes} bytes are kept");
}

fn first_message(text: &str) -> String {
    compiled(text).diagnostics.list.first().map_or_else(String::new, |d| d.message.clone())
}

/// Calls with many candidates: they are not all compared, nor listed in each message.
#[test]
fn overloads_times_calls_have_an_end() {
    let functions: String =
        (1..10_000).map(|i| format!("float g (float a[{i}]) {{ return 1; }}\n")).collect();
    let [wrong, right] = ["f = g (u, v);\n", "f = g (b);\n"].map(|call| call.repeat(20_000));
    let made =
        soon("wrong calls", || compiled(&format!("{functions} shader t (output float f = 0) {{ {wrong} }}")));
    let bytes: usize = made.diagnostics.list.iter().map(|d| d.message.len()).sum();
    assert!(bytes < 4 << 20, "{bytes} bytes of messages");
    let text = format!("{functions} shader t (output float f = 0) {{ float b[3]; {right} }}");
    let message = soon("right calls", || first_message(&text));
    assert!(message.contains("compared with calls more than"), "{message}");
}

#[test]
fn fields_are_not_compared_with_each_other() {
    let fields: String = (0..50_000).map(|i| format!("float a{i}; ")).collect();
    let text = format!("struct S {{ {fields} }}; shader t () {{ S s; s.a1 = 1; }}");
    soon("fields", || assert!(compiled(&text).shader.is_some()));
}

/// What one use of a macro makes is counted before it is made.
#[test]
fn single_macros_have_an_end() {
    let argument = "u ".repeat(100_000);
    for (definition, used) in [
        (format!("A {}", "a ## ".repeat(100_000)), "A".into()),
        (format!("A(x) {}", "x ".repeat(100_000)), format!("A({argument})")),
        (format!("A(x) {}", "#x ".repeat(100_000)), format!("A({argument})")),
        (format!("A(x) {} y", "x ## ".repeat(100_000)), format!("A({argument})")),
    ] {
        let text = format!("#define {definition}\nshader t () {{ {used}; }}");
        let message = soon("a macro", || first_message(&text));
        assert!(message.contains("macros make more than"), "{}: {message}", &definition[..20]);
    }
}

/// Work of a point is bounded without loops, and within an iteration.
#[test]
fn work_of_a_point_has_an_end() {
    let copies = "a = b; b = a; ".repeat(100_000);
    let noises = "f += noise (P * f, u);\n".repeat(1000);
    for (what, body) in [
        ("copies", format!("float a[4000]; float b[4000]; {copies}")),
        ("noises", format!("for (int i = 0; i < 10000000; ++i) {{ {noises} }}")),
    ] {
        let mut group = Group::default();
        let shader = compiled(&format!("shader t (output float f = 0) {{ {body} }}")).shader;
        group.add(Arc::new(shader.expect("a shader")), None, &[], &mut Vec::new());
        let options = PlanOptions { iterations: 1_000_000, ..PlanOptions::default() };
        let plan = Plan::new(&group, &options).expect("a plan");
        let world = Empty::default();
        let events = soon(what, || {
            let mut machine = Machine::new(&plan, &world);
            machine.run(&Point::default());
            machine.events
        });
        assert!(matches!(&*events, [Event::Error(text)] if text.contains("stopped")), "{what}: {events:?}");
    }
}
