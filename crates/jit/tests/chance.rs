// SPDX-License-Identifier: GPL-3.0-or-later
//! Random programs: the interpreter and machine code agree.

use gnurt_sl::group::Group;

use super::world::{Codes, compare, compare_with, shader};

/// Small numbers that look random.
pub(crate) struct Dice(u64);

impl Dice {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1)
    }

    pub(crate) fn roll(&mut self, sides: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as usize % sides.max(1)
    }

    fn of<'t>(&mut self, list: &[&'t str]) -> &'t str {
        list[self.roll(list.len())]
    }
}

const INTS: &[&str] = &["i", "j", "k", "s.n"];
const FLOATS: &[&str] = &["f", "g", "h", "s.x", "t.x"];
const COLORS: &[&str] = &["o", "c", "d", "s.c", "t.c"];
const TEXTS: &[&str] = &["q", "r", "s.q", "\"pine\"", "\"oak\""];

struct Maker {
    dice: Dice,
    /// Loops around.
    loops: usize,
    text: String,
}

impl Maker {
    fn int(&mut self, depth: usize) -> String {
        let d = depth + 1;
        match self.dice.roll(if depth > 3 { 3 } else { 16 }) {
            0 => self.dice.roll(9).to_string(),
            1 | 2 => self.dice.of(INTS).into(),
            3 => format!(
                "({} {} {})",
                self.int(d),
                self.dice.of(&["+", "-", "*", "/", "%", "&", "|", "^"]),
                self.int(d)
            ),
            4 => format!(
                "({} {} {})",
                self.float(d),
                self.dice.of(&["<", ">", "<=", ">=", "==", "!="]),
                self.float(d)
            ),
            5 => format!(
                "({} {} {})",
                self.int(d),
                self.dice.of(&["<", ">", "==", "!=", "&&", "||"]),
                self.int(d)
            ),
            6 => format!("((int) {})", self.float(d)),
            7 => format!("({} << {})", self.int(d), self.dice.roll(6)),
            8 => format!("(-{})", self.int(d)),
            9 => format!("({} == {})", self.color(d), self.color(d)),
            10 => format!("(!{})", self.int(d)),
            11 => format!("({} {} {})", self.text(d), self.dice.of(&["==", "!="]), self.text(d)),
            12 => format!("strlen({})", self.text(d)),
            13 => format!("{}({}, {})", self.dice.of(&["min", "max"]), self.int(d), self.int(d)),
            14 => format!("ks[{}]", self.int(d)),
            _ => format!("({} ? {} : {})", self.int(d), self.int(d), self.int(d)),
        }
    }

    fn float(&mut self, depth: usize) -> String {
        let d = depth + 1;
        match self.dice.roll(if depth > 3 { 4 } else { 19 }) {
            0 => format!("{}.{}", self.dice.roll(4), self.dice.roll(100)),
            1 => self.dice.of(FLOATS).into(),
            2 => self.dice.of(&["u", "v", "P[0]", "I[2]", "time"]).into(),
            3 => format!("{}[{}]", self.dice.of(COLORS), self.dice.roll(3)),
            4 | 5 => format!("({} {} {})", self.float(d), self.dice.of(&["+", "-", "*", "/"]), self.float(d)),
            6 => format!(
                "{}({})",
                self.dice.of(&["sin", "floor", "sqrt", "abs", "exp", "noise", "-", "cellnoise", "log"]),
                self.float(d)
            ),
            7 => format!(
                "{}({}, {})",
                self.dice.of(&["min", "max", "pow", "fmod", "step", "atan2"]),
                self.float(d),
                self.float(d)
            ),
            8 => format!(
                "{}({}, {}, {})",
                self.dice.of(&["mix", "clamp", "smoothstep"]),
                self.float(d),
                self.float(d),
                self.float(d)
            ),
            9 => format!("dot({}, {})", self.vector(d), self.vector(d)),
            10 => format!("length({})", self.vector(d)),
            11 => format!("{}({})", self.dice.of(&["Dx", "Dy", "filterwidth"]), self.float(d)),
            12 => format!("a[{}]", self.int(d)),
            13 => format!("s.l[{}]", self.int(d)),
            14 => format!("m[{}][{}]", self.dice.roll(4), self.int(d)),
            15 => format!("cs[{}][{}]", self.int(d), self.dice.roll(3)),
            16 => format!("spline(\"linear\", (float) ({}), a)", self.float(d)),
            17 => format!(
                "(float) noise(\"{}\", {})",
                self.dice.of(&["simplex", "cell", "perlin"]),
                self.float(d)
            ),
            _ => format!("((float) {})", self.int(d)),
        }
    }

    fn text(&mut self, depth: usize) -> String {
        let d = depth + 1;
        match self.dice.roll(if depth > 3 { 2 } else { 5 }) {
            2 => format!("concat({}, {})", self.text(d), self.text(d)),
            3 => format!("substr({}, {}, 2)", self.text(d), self.int(d)),
            4 => format!("format(\"%d\", {})", self.int(d)),
            _ => self.dice.of(TEXTS).into(),
        }
    }

    fn vector(&mut self, depth: usize) -> String {
        format!("((vector) {})", self.color(depth))
    }

    fn color(&mut self, depth: usize) -> String {
        let d = depth + 1;
        match self.dice.roll(if depth > 3 { 2 } else { 10 }) {
            0 | 1 => self.dice.of(COLORS).into(),
            2 => format!("color({}, {}, {})", self.float(d), self.float(d), self.float(d)),
            3 => format!("({} {} {})", self.color(d), self.dice.of(&["+", "-", "*", "/"]), self.color(d)),
            4 => format!("({} * {})", self.color(d), self.float(d)),
            5 => format!("((color) normalize({}))", self.vector(d)),
            6 => format!("cs[{}]", self.int(d)),
            7 => format!("((color) transform(m, {}))", self.vector(d)),
            8 => format!("((color) cross({}, {}))", self.vector(d), self.vector(d)),
            _ => format!("mix({}, {}, {})", self.color(d), self.color(d), self.float(d)),
        }
    }

    fn statement(&mut self, depth: usize) {
        match self.dice.roll(if depth > 3 { 5 } else { 10 }) {
            0 => {
                let line = format!("{} = {};\n", self.dice.of(INTS), self.int(0));
                self.text += &line;
            }
            1 | 2 => {
                let line = format!(
                    "{} {} {};\n",
                    self.dice.of(FLOATS),
                    self.dice.of(&["=", "+=", "*=", "-="]),
                    self.float(0)
                );
                self.text += &line;
            }
            3 => {
                let line = format!("{} = {};\n", self.dice.of(COLORS), self.color(0));
                self.text += &line;
            }
            4 => {
                let line = match self.dice.roll(14) {
                    3 => format!("{} = b;\n", self.dice.of(&["a", "w"])),
                    4 => {
                        let at = self.int(1);
                        format!("f = w[{at}]; w[{}] = {};\n", self.dice.roll(4), self.float(1))
                    }
                    0 => format!("{}[{}] = {};\n", self.dice.of(COLORS), self.dice.roll(3), self.float(0)),
                    1 => format!("a[{}] = {};\n", self.int(1), self.float(0)),
                    5 => self.dice.of(&["s = t;\n", "t = s;\n", "cs = ds;\n", "w = a;\n"]).into(),
                    6 => format!("s.l[{}] = {};\n", self.int(1), self.float(0)),
                    7 => format!("{} = {};\n", self.dice.of(&["q", "r", "s.q"]), self.text(0)),
                    8 => format!("m[{}][{}] = {};\n", self.dice.roll(4), self.int(1), self.float(1)),
                    9 => format!("cs[{}] = {};\n", self.int(1), self.color(1)),
                    10 => format!(
                        "m = {};\n",
                        self.dice.of(&["m * 2", "m * matrix(u)", "m / f", "transpose(m)"])
                    ),
                    11 => format!("change({}, s, a);\n", self.float(1)),
                    12 => format!("ks[{}] = {};\n", self.int(1), self.int(1)),
                    _ => format!("f = call({}, {});\n", self.float(1), self.dice.of(INTS)),
                };
                self.text += &line;
            }
            5 | 6 => {
                let condition = self.int(0);
                self.text += &format!("if ({condition}) {{\n");
                self.statements(depth + 1);
                self.text += "}";
                if self.dice.roll(2) == 0 {
                    self.text += " else {\n";
                    self.statements(depth + 1);
                    self.text += "}";
                }
                self.text += "\n";
            }
            7 | 8 => {
                let name = format!("n{depth}{}", self.text.len());
                let (iterations, more) = (self.dice.roll(5), self.int(2));
                let head = match self.dice.roll(3) {
                    0 => format!("for (int {name} = 0; {name} < {iterations}; ++{name}) {{\n"),
                    1 => format!("int {name} = 0; while ({name}++ < {iterations} && ({more})) {{\n"),
                    _ => format!("int {name} = 0; do {{ {name} += 1;\n"),
                };
                let tail = if head.contains("do {") {
                    format!("}} while ({name} < {iterations} && ({more}));\n")
                } else {
                    "}\n".into()
                };
                self.text += &head;
                self.loops += 1;
                self.statements(depth + 1);
                self.loops -= 1;
                self.text += &tail;
            }
            _ => {
                let choice = match self.dice.roll(6) {
                    0 if depth > 0 => "exit();",
                    1 if depth > 0 => "return;",
                    _ if self.loops == 0 => "j += 1;",
                    2 | 3 => "continue;",
                    _ => "break;",
                };
                let condition = self.int(1);
                self.text += &format!("if ({condition}) {choice}\n");
            }
        }
    }

    fn statements(&mut self, depth: usize) {
        for _ in 0..=self.dice.roll(4) {
            self.statement(depth);
        }
    }
}

fn program(seed: u64) -> String {
    let mut maker = Maker { dice: Dice::new(seed), loops: 0, text: String::new() };
    for _ in 0..8 {
        maker.dice.roll(2);
    }
    maker.statements(0);
    maker.statements(0);
    let head = "struct Part { float x; color c; int n; string q; float l[2]; };
float call(float y, output int n) { float x = y; n = n + 1; if (x < 0) return -x; for (int q = 0; q < 3; ++q) { if (x < q) return q; x *= 0.5; } return x; }
void change(float y, output Part p, output float list[3]) { p.x = y; if (y > 0.5) return; p.n += 1; list[1] += p.c[2]; }";
    let inputs =
        "color in0 = 0.5, float in1 = 0.25, int in2 = 3, string in3 = \"elm\", float in4[3] = {1, 2, 3}";
    let locals = "int i = in2, j = (int) (v * 5); float g = v + in1, h = 2; color c = I, d = 1 + in0; float a[3]; a = in4; a[0] = u; float b[2] = {v, u}; float w[4]; \
        string q = in3, r = \"oak\"; int ks[3] = {1, 5, 2}; color cs[2] = {c, d}; color ds[2]; matrix m = matrix(v); \
        Part s = {u, P, 2, \"ash\", {1, v}}; Part t;";
    format!(
        "{head}\nshader test({inputs}, output color o = P, output float f = u, output int k = 1, output float z = 0, output string e = \"\", output float l[3] = {{0, 0, 0}}) {{\n{locals}\n{}\n\
        z = Dx(f) + g + h + i + j + a[0] + a[1] + a[2] + c[0] + d[1] + s.x + s.l[1] + t.c[1] + ks[1] + cs[1][2] + m[1][2]; e = concat(q, r); l = a; }}",
        maker.text
    )
}

/// One layer, or a few with random connections.
fn group(seed: u64) -> (Group, String) {
    let mut dice = Dice::new(seed ^ 0x5bd1);
    (0..6).for_each(|_| _ = dice.roll(2));
    let count = [1, 1, 2, 3][dice.roll(4)];
    let (mut group, mut all) = (Group::default(), String::new());
    for layer in 0..count {
        let text = program(seed + layer * 0x1_0000_0001);
        group.add(shader(&text), Some(&format!("layer{layer}")), &[], &mut Vec::new());
        all += &format!("// layer {layer}\n{text}\n");
    }
    for layer in 1..count {
        for _ in 0..dice.roll(6) {
            let above = dice.roll(layer as usize);
            let ends = [
                ("o", "in0"),
                ("f", "in1"),
                ("k", "in2"),
                ("e", "in3"),
                ("l", "in4"),
                ("z", "in1"),
                ("o[1]", "in1"),
                ("f", "in0"),
                ("z", "in4[1]"),
                ("k", "in1"),
            ];
            let (from, to) = ends[dice.roll(ends.len())];
            let (a, b) = (format!("layer{above}"), format!("layer{layer}"));
            if group.connect(&a, from, &b, to).is_ok() {
                all += &format!("// {a}.{from} to {b}.{to}\n");
            }
        }
    }
    (group, all)
}

#[test]
fn random_programs_mean_the_same() {
    let number = |name: &str, default: u64| {
        std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(default)
    };
    let (start, count) = (number("GNURT_SEED", 1), number("GNURT_PROGRAMS", 50));
    // Many programs in two to four of their twelve codes each.
    let some = std::env::var("GNURT_CODES").is_ok_and(|codes| codes == "some");
    for seed in start..start + count {
        let (group, text) = group(seed);
        let codes = if some { Codes::Some(seed) } else { Codes::All };
        compare_with(&group, codes, &format!("seed {seed}\n{text}"));
    }
}

/// A file with a word or a line of it changed.
pub(crate) fn mutated(text: &str, dice: &mut Dice) -> String {
    let mut lines: Vec<Vec<String>> =
        text.lines().map(|line| line.split('\t').map(str::to_owned).collect()).collect();
    for _ in 0..=dice.roll(3) {
        let (a, b) = (dice.roll(lines.len()), dice.roll(lines.len()));
        match dice.roll(4) {
            0 => drop(lines.remove(a)),
            1 => lines[a] = lines[b].clone(),
            _ => {
                let (i, k) = (dice.roll(lines[a].len()), dice.roll(lines[b].len()));
                lines[a][i] = lines[b][k].clone();
            }
        }
        if lines.is_empty() {
            break;
        }
    }
    lines.iter().map(|fields| fields.join("\t") + "\n").collect()
}

/// Small nodes as materials are made of, without messages.
const NODES: &[&str] = &[
    "shader n (color in0 = 0.5, float in1 = 2, output color o = 0, output float f = 1) { o = 0.25; f = 3; }",
    "shader n (color in0 = 0.5, float in1 = 2, output color o = 0, output float f = 1) { o = in0; f = in1; }",
    "shader n (color in0 = 0.5, float in1 = 2, output color o = 0, output float f = 1) { o = in0 * in1; f = in1 + 1; }",
    "shader n (color in0 = 0.5, float in1 = 2, output color o = 0, output float f = 1) { o = in0 + u; f = noise (in1 * P); }",
    "shader n (color in0 = 0.5, float in1 = 2, output color o = 0, output float f = 1) { if (in1 > 2) o = in0; else o = P; f = in0[1]; }",
    "shader n (color in0 = 0.5, float in1 = 2, output color o = 0.125, output float f = 7) { }",
    "shader n (color in0 = P, float in1 = v * 2, output color o = in0, output float f = in1) { if (isconnected (in0)) f += 1; }",
    "shader n (color in0 = 0.5, float in1 = 2, output color o = 0, output float f = 1) { o = mix (in0, color (u, v, 1), in1); f = Dx (in1) + sin (in1); }",
    "shader n (color in0 = 0.5, float in1 = 2, output color o = 0, output float f = 1) { f = 2; if (u > 0.3) return; o = 4; }",
    "shader n (color in0 = 0.5, float in1 = 2, output color o = 0, output float f = 1) { o = pow (in0, 2); for (int i = 0; i < in1; ++i) f *= 1.5; Ci = 0; }",
    "shader n (float in1 = 2, int in2 = 3, color in0 = 1, output color o = 0, output float f = 1) { o = color (\"hsv\", 0.5, 1, in1); f = in2; }",
];

#[test]
fn random_networks_mean_the_same() {
    let nodes: Vec<_> = NODES.iter().map(|text| shader(text)).collect();
    let last = shader(
        "shader last (color in0 = 0.5, float in1 = 2, output color o = 0, output float f = 0) { o = in0; f = in1 + Dy (in0[2]); }",
    );
    for seed in 0..300 {
        let mut dice = Dice::new(seed + 77);
        (0..6).for_each(|_| _ = dice.roll(2));
        let (mut group, mut text) = (Group::default(), format!("network {seed}\n"));
        let count = 2 + dice.roll(12);
        for number in 0..=count {
            let node = dice.roll(nodes.len());
            let made = if number == count { &last } else { &nodes[node] };
            group.add(made.clone(), Some(&format!("n{number}")), &[], &mut Vec::new());
            text += &format!("n{number}: {}\n", if number == count { "last" } else { NODES[node] });
            for to in ["in0", "in1"] {
                if number == 0 || dice.roll(4) == 0 {
                    continue;
                }
                let (above, from) = (dice.roll(number), dice.of(&["o", "f", "o[2]"]));
                if group.connect(&format!("n{above}"), from, &format!("n{number}"), to).is_ok() {
                    text += &format!("n{above}.{from} to n{number}.{to}\n");
                }
            }
        }
        compare(&group, &text);
    }
}
