// SPDX-License-Identifier: GPL-3.0-or-later
//! Texts of two megabytes that repeat one construct: each ends soon, with a shader or with one clear line.

use std::time::Instant;

/// Bytes of a text.
const LENGTH: usize = 2 << 20;
/// Seconds of a compilation.
const MOST_SECONDS: f64 = 5.0;

/// What a text repeats, and the text around it: `@` is the number of the repetition.
const TEXTS: [(&str, &str, &str); 41] = [
    ("shader t () { float x = ", "(", "; }"),
    ("shader t () { float x = ", "-", "1; }"),
    ("shader t () { int x = ", "!", "1; }"),
    ("shader t () { int x = ", "~", "1; }"),
    ("shader t () { float x = 0", " + u", "; }"),
    ("shader t () { float x = 0", " * u", "; }"),
    ("shader t () { int x = 0", " && 1", "; }"),
    ("shader t () { int x = 0", " || 1", "; }"),
    ("shader t () { float x; ", "x = ", "1; }"),
    ("shader t () { float x = ", "1 ? 2 : ", "3; }"),
    ("shader t () { float x = 0; ", "x += u; ", "}"),
    ("shader t () ", "{ ", "}"),
    ("shader t () { ", "if (u > 0) ", "; }"),
    ("shader t () { ", "if (u > 0) ; else ", "; }"),
    ("shader t () { ", "while (u > 0) ", "; }"),
    ("shader t () { ", "for (;;) ", "; }"),
    ("shader t () { ", "do ", "; while (0); }"),
    ("shader t () { float a[2] = {", "{", "1}; }"),
    ("shader t () { float a[] = {1", ", 1", "}; }"),
    ("shader t () { float x = a", "[0]", "; }"),
    ("shader t () { float x = a", ".b", "; }"),
    ("shader t () { color x = ", "color (", "1; }"),
    ("shader t () { float x = ", "sin (", "1; }"),
    ("shader t () { float x = ", "(float) ", "1; }"),
    ("shader t () { string x = ", "\"a\" ", "; }"),
    ("shader t () { string x = \"", "\\n", "\"; }"),
    ("shader t (", "float a@ = 1, ", "float z = 1) {}"),
    ("shader t () { ", "float a@ = u; ", "}"),
    ("shader t () { ", "a@ = u; ", "}"),
    ("", "float f@ (float x) { return x; } ", "shader t () {}"),
    ("", "float f (float x[@1]) { return 1; } ", "shader t () {}"),
    ("", "float f (float x) { return 1; } ", "shader t () {}"),
    ("", "struct S@ { float x; }; ", "shader t () {}"),
    ("struct S { ", "float a@; ", "}; shader t () { S s; }"),
    ("", "#define A@ A\n", "shader t () {}"),
    ("", "#if 1\n", "shader t () {}"),
    ("", "#include \"a@.h\"\n", "shader t () {}"),
    ("", "/* ", "shader t () {}"),
    ("", "@ ", "shader t () {}"),
    ("shader t [[ ", "int a@ = 1, ", "int z = 1 ]] () {}"),
    ("shader t () { printf (\"", "%d ", "\", 1); }"),
];

/// The text: the middle one repeated.
fn text((before, middle, after): (&str, &str, &str)) -> String {
    let mut text = before.to_owned();
    for number in 0.. {
        if text.len() + middle.len() + after.len() > LENGTH {
            break;
        }
        text.push_str(&middle.replace('@', &number.to_string()));
    }
    text + after
}

#[test]
fn texts_that_repeat_end_soon_with_one_line() {
    for of in TEXTS {
        let text = text(of);
        let what = format!("{:?} {:?} {:?}", of.0, of.1, of.2);
        let start = Instant::now();
        let made = gnurt_sl::compile("t.osl", &text, &gnurt_sl::Options::default(), &|_| None);
        let seconds = start.elapsed().as_secs_f64();
        // Builds without optimisation take longer.
        let most = if cfg!(debug_assertions) { 10.0 * MOST_SECONDS } else { MOST_SECONDS };
        assert!(seconds < most, "{what}: {seconds} s");
        match made.diagnostics.list.first() {
            Some(first) => {
                let line = first.message.lines().next().unwrap_or_default();
                let is_clear = !line.is_empty() && line.len() < 300 && first.message.len() < 4000;
                assert!(is_clear, "{what}: {}", first.message);
            }
            None => assert!(made.shader.is_some(), "{what}: neither shader nor message"),
        }
        let bytes: usize = made.diagnostics.list.iter().map(|d| d.message.len()).sum();
        assert!(bytes < 64 << 20, "{what}: {bytes} bytes of messages");
    }
}
