// SPDX-License-Identifier: GPL-3.0-or-later
//! Texts that mean harm: nothing panics, hangs or takes memory that a text does not account for.

use crate::common::{Empty, body, compiled};
use gnurt_sl::exec::{Machine, Plan, PlanOptions, Point, unknown_operation};
use gnurt_sl::group::{Group, read_group, write_group};
use gnurt_sl::ir::{SymbolKind, read, write};
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

/// What a shader gives and says at a point, stopped soon.
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
    let Ok(plan) = Plan::new(&group, &PlanOptions { turns: 200, ..PlanOptions::default() }) else {
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
        let mut words: Vec<&str> = line.split(' ').collect();
        while let Some(last) = words.iter().rposition(|word| !word.contains(['%', '\t'])) {
            words.remove(last);
            let shorter = words.join(" ");
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
