// SPDX-License-Identifier: GPL-3.0-or-later
//! Texts that mean harm: nothing panics, hangs or takes memory that a text does not account for.

use crate::common::{body, compiled};
use gnurt_sl::group::read_group;
use gnurt_sl::ir::{read, write};

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

#[test]
fn changed_texts_are_refused_or_run() {
    let mut dice = Dice(0x1234_5678);
    for _ in 0..150 {
        let text = mutated(SHADER, &mut dice);
        let compiled = compiled(&text);
        let said = compiled
            .diagnostics
            .list
            .iter()
            .filter(|d| d.message.contains("the compiler made a mistake"))
            .count();
        assert_eq!(said, 0, "what is lowered is whole: {text}");
    }
}

#[test]
fn changed_files_are_refused_or_read() {
    let shader = crate::common::shader(SHADER);
    let text = write(&shader, "");
    let back = read(&text).expect("what is written is read");
    assert_eq!(write(&back, ""), text, "and written again the same");
    let mut dice = Dice(99);
    for _ in 0..300 {
        let _ = read(&mutated(&text, &mut dice));
        let group = mutated(
            "param float[2] a 1 2 [[int interpolated=1]] ; shader s l ; connect l.a l.b[1][2] ;",
            &mut dice,
        );
        let _ = read_group("g", &group, &mut |_| None, &mut Vec::new());
    }
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
    let out = body(
        "string s = \"abcdefgh\"; for (int i = 0; i < 60; ++i) s = concat(s, s); printf(\"%d\", strlen(s) < 2000000);",
    );
    assert_eq!(out, "1", "texts stop growing");
}
