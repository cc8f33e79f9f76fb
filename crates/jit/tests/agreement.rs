// SPDX-License-Identifier: GPL-3.0-or-later
//! One text for each thing that can go wrong.

use super::world::{compare, shader, single_group};
use gnurt_sl::group::Group;

/// Statements that write `o`, `f` and `k`; how many operations may be left to the interpreter.
fn body(left: usize, statements: &str) {
    let text =
        format!("shader test(output color o = 0, output float f = 0, output int k = 0) {{ {statements} }}");
    assert_eq!(
        compare(&single_group(&text), &text),
        left,
        "operations that are left to the interpreter\n{text}"
    );
}

#[test]
fn arithmetic() {
    body(0, "o = P * 2 - color(u, v, 1) / (P + 1); f = o[0] * o[1] + o[2]; k = (int) (f * 100) % 7;");
    body(
        0,
        "k = (int) (P[0] * 3); k = k / 2 + k % 3 - (k << 2) + (k >> 1) ^ 5 | k & 3; f = -k; o = color(k / -1, abs(k), ~k);",
    );
    body(0, "f = P[0] / (u - u); k = 7 / (int) (u - u); o = color(k % 0, 1 / 0.0, mod(P[1], 0.7));");
    body(
        0,
        "f = min(u, v) + max(P[0], P[1]); o = clamp(P, -1, 1); k = !k + (u < v) + (u <= v) * 2 + (u > v || v > 0.5 && u != 0);",
    );
    body(0, "o = normalize(P) + cross(P, I) * dot(P, I); f = length(P) + distance(P, I);");
    body(0, "k = (int) (P[0] * 1e12) + (int) (u * -1e20);");
    body(
        0,
        "float wide = (u - 0.5) * 1e11; float none = (v - v) / (u - u); k = (int) wide; o = color((int) none, (int) (wide * 1e30), (int) -2147483648.0);",
    );
    body(
        0,
        "int least = -2147483647 - 1; int by = (int) (u * 4) - 1; int n = (int) (P[0] * 99); k = n % by; o = color(n / by, least / by, least % by);",
    );
}

/// Choices between compared values are minima and maxima, and some operations are left out: zeros of both signs, NaN, the
/// infinite, and the smallest numbers.
#[test]
fn shorter_operations_have_the_same_bits() {
    let values = "float big = 1e38 * (u + 1) * 10, none = big - big, minus = -(u * 0), least = 1e-45 * (1 + (u > 0.5));
        float x = v < 0.2 ? none : v < 0.4 ? minus : v < 0.6 ? big : v < 0.8 ? least : u - 0.5;
        float y = u < 0.3 ? none : u < 0.5 ? 0 : u < 0.7 ? minus : v - 0.5;";
    for statements in [
        "o = color (min (x, 0), min (x, 1), min (x, -1)); f = min (x, y);",
        "o = color (min (0, x), min (1, x), min (-1, x)); f = min (y, x);",
        "o = color (max (x, 0), max (x, 1), max (x, -1)); f = max (x, y);",
        "o = color (max (0, x), max (1, x), max (-1, x)); f = max (y, x);",
        "o = color (clamp (x, 0, 1), clamp (x, -1, 2), clamp (x, y, 1)); f = clamp (x, -y, y);",
        "o = color (x < 2 ? x : 2, x < 2 ? 2 : x, x <= 2 ? x : 2); f = x <= 2 ? 2 : x;",
        "o = color (2 < x ? x : 2, 2 < x ? 2 : x, 2 <= x ? x : 2); f = 2 <= x ? 2 : x;",
        "o = color (x < y ? x : y, x < y ? y : x, x <= y ? x : y); f = x <= y ? y : x;",
        "o = color (!(x < y) ? x : y, !(x <= 2) ? 2 : x, !(x == y) ? x : 3); f = x > y ? x : y;",
        "o = color (x * 1, x / 1, x - 0); f = 1 * x; k = ((int) (u * 9) ^ 0) + 0 | 0 & 3;",
        "o = color (x / 2, x / -4, x / 1.17549435e-38); f = x / 3 + y / 1.70141183e38; k = (int) (v * 9) * 1;",
        "o = color (-(-x), abs (abs (x)), -abs (-x)); f = Dx (min (u * u, v)) + Dy (max (v * u, 0.5)); k = !!(int) (u * 2);",
    ] {
        body(0, &format!("{values} {statements}"));
    }
}

#[test]
fn functions() {
    for name in [
        "sin",
        "cos",
        "tan",
        "asin",
        "acos",
        "atan",
        "sinh",
        "cosh",
        "tanh",
        "exp",
        "exp2",
        "expm1",
        "log",
        "log2",
        "log10",
        "logb",
        "sqrt",
        "inversesqrt",
        "cbrt",
        "abs",
        "sign",
        "floor",
        "ceil",
        "round",
        "trunc",
    ] {
        body(0, &format!("f = {name}(P[0]); o = {name}(P * 0.3); f += Dx({name}(P[1]));"));
    }
    body(0, "f = erf(P[0]) + Dx(erfc(P[1]));");
    for name in ["atan2", "pow", "fmod", "step", "min", "max"] {
        body(0, &format!("f = {name}(P[0], v); o = {name}(P, P * 0.5 + v); f += Dy({name}(P[1], P[2]));"));
    }
    body(
        0,
        "o = mix(P, I, u) + smoothstep(0.2, 0.8, v); f = select(u, v, P[0] > 0); float s; sincos(P[0], f, s); o += s;",
    );
    body(
        0,
        "f = isnan(P[0]) + isinf(P[1]) * 2 + isfinite(P[2]) * 4; k = hash(P) + hash(u) + hash((int) (u * 10)) + hash(P, u);",
    );
}

#[test]
fn noises() {
    for name in ["noise", "snoise", "cellnoise", "hashnoise"] {
        body(
            0,
            &format!(
                "f = {name}(P[0]) + {name}(u, v) + {name}(P) + {name}(P, u); o = {name}(P * 2) + {name}(u);"
            ),
        );
    }
    body(
        0,
        "f = noise(\"simplex\", P) + noise(\"usimplex\", u, v); o = noise(\"perlin\", P, v); f += Dx(noise(P * 3));",
    );
    body(
        0,
        "f = pnoise(P, point(2, 3, 4)) + pnoise(u, 3.0) + psnoise(u, v, 2, 3); o = pnoise(\"cell\", P, point(3));",
    );
    body(1, "f = noise(\"gabor\", P);");
}

#[test]
fn derivatives() {
    body(
        0,
        "point q = P * P[0] + sin(P * 2) / (1 + length(P)); o = Dx(q) + Dy(q); f = filterwidth(q[0]) + area(q);",
    );
    body(0, "float a = u; if (v > 0.3) a = u * v; else { a += v; } f = Dx(a); o = filterwidth(P);");
}

#[test]
fn choices() {
    body(0, "if (u > 0.4) { f = 1; if (v > 0.1) f += 2; else k = 3; } else f = 4; o = f;");
    body(0, "float a; if (u > 0.4) a = 1; o = a; if (k == 0) f = 5; else f = 6;");
    body(0, "f = u > 0.5 ? P[0] : v; k = u > 0.2 && v > 0.2 ? 1 : 2;");
}

#[test]
fn loops() {
    body(0, "for (int i = 0; i < 5; ++i) { f += i * u; }");
    body(
        0,
        "int i = 0; while (i < P[0] * 4) { f += i; i += 1; if (i == 7) break; if (i % 2) continue; o += i; } k = i;",
    );
    body(
        0,
        "int i = 0; do { i += 1; f += u; } while (i < 3 + k); do { k += 1; if (u > 0.5) continue; o += 1; } while (k < 6 * u);",
    );
    body(
        0,
        "for (int i = 0; i < 4; ++i) for (int j = 0; j <= i; ++j) { if (j > u * 5) break; f += noise(P + i) * j; }",
    );
    body(0, "int i; for (i = 0; i < 10; i += 2) { if (v < 0.2 * i) { k = i; break; } o += v; } f = i;");
}

/// Variables change places, are kept by lanes that leave, and are more than registers.
#[test]
fn loops_keep_their_variables() {
    body(
        0,
        "float a = u, b = v, c = 1; int n = int (v * 9); for (int i = 0; i < n; ++i) { float t = a; a = b; b = c; c = t; f += a * i; if (f > 3) break; } o = color (a, b, c); k = n;",
    );
    body(
        0,
        "int i = 0; float last = 0; while (i < u * 7) { f = last; last = i * v; i += 1; } o = last; k = i;",
    );
    body(
        0,
        "int i = 5; int go = 1; do { go = i > int (u * 5); i -= go; f += v; if (f > 1.5) continue; o += i; } while (go); k = i;",
    );
    let names: Vec<String> = (0..20).map(|i| format!("a{i}")).collect();
    let start: String = names.iter().map(|a| format!("float {a} = u; ")).collect();
    let turn: String =
        names.iter().enumerate().map(|(i, a)| format!("{a} = {a} * 0.9 + a{} * v; ", (i + 1) % 20)).collect();
    body(
        0,
        &format!(
            "{start} for (int i = 0; i < u * 9; ++i) {{ {turn} if (a3 > 2) break; }} f = {};",
            names.join(" + ")
        ),
    );
}

#[test]
fn calls() {
    let function = "float g(float x, output int n) { n = 0; if (x < 0) return 1; for (int i = 0; i < 8; ++i) { n += 1; if (x < i) return x * i; } n += 10; return -x; }";
    let text = format!(
        "{function} shader test(output color o = 0, output float f = 0, output int k = 0) {{ f = g(P[0], k); int m; o = g(P[1] * 3, m) + m; if (u > 0.5) {{ exit(); }} o[1] = 5; }}"
    );
    assert_eq!(compare(&single_group(&text), &text), 0, "all is code");
}

#[test]
fn arrays_and_components() {
    body(0, "float a[4] = {1, 2, 3, 4}; a[2] = u; f = a[0] + a[2] + a[3]; o[1] = v; o[0] = P[2];");
    body(3, "float a[4] = {1, 2, 3, 4}; k = (int) (u * 3); a[k] = v; f = a[3 - k]; o = P[k];");
    body(1, "color c[3] = {P, I, 1}; o = c[(int) (P[0] * 2)];");
    body(
        0,
        "matrix m = 2; m[1][2] = u; m[3][0] = v; m = m * m * transpose(m) / 3; o = transform(m, P) + transform(m, (vector) I); f = m[0][1];",
    );
    body(1, "string s[2] = {\"a\", \"b\"}; string t = s[(int) (u * 1.9)]; k = t == \"b\";");
}

/// Values far away in memory: an instruction of ARM reaches 64 KiB, two reach 16 MiB.
#[test]
fn distances_may_be_large() {
    for count in [2_000, 300_000] {
        let text = format!(
            "shader test(output float a[{count}] = {{1, 2}}, output float f = 0, output int k = 0) {{ a[{count} - 1] = u; for (k = 0; k < 4 * v; ++k) a[{count} - 1] += v; f = a[{count} - 1] * 2 + a[1]; if (a[{count} - 1] > 1) k += 5; printf(\"%d \", k); }}"
        );
        compare(&single_group(&text), &text);
    }
}

#[test]
fn texts_and_messages() {
    body(2, "printf(\"%g %g\\n\", u, P); if (u > 0.5) printf(\"more %d\\n\", k); f = 1;");
    body(
        3,
        "string s = format(\"%d\", (int) (u * 10)); k = strlen(s) + (s == \"3\"); if (k > 1) s = concat(s, \"x\"); f = k;",
    );
    body(2, "if (u > 0.3) setmessage(\"m\", u); float x = 9; k = getmessage(\"m\", x); f = x;");
    body(1, "error(\"bad %g\", v); k = backfacing();");
}

#[test]
fn closures() {
    let text = "surface test(float s = 7 [[int interpolated = 1]], output float f = 0) { f = s; Ci = u * diffuse(N); if (v > 0.5) Ci += diffuse(Ng) * color(u, 0, 1); }";
    compare(&single_group(text), text);
    let all = [
        // Sums, weights that are nothing or all, in some points only, of numbers of other types.
        "closure color c = 0; int k = int (u * 9); for (int i = 0; i < k; ++i) { c += v * diffuse(N); if (i > 3) c = c + emission(); } Ci = c * k + 0 * c + 1 * emission() + color(0) * c;",
        // Layers of varying closures, and of closures within themselves.
        "closure color c = u * diffuse(N); if (v > 0.3) c = layer(emission(), c); for (int i = 0; i < 4 * u; ++i) c = layer(c, v * c); Ci = c + layer(0 * c, c);",
        // Keys, numbers for colours, texts and keys that differ.
        "string kind = u > 0.5 ? \"ggx\" : \"beckmann\"; Ci = microfacet(kind, N, u, 1, 2) + conductor_bsdf(N, vector(u, v, 1), u, 0.5, color(v), color(u), kind, \"thinfilm_ior\", 1.5, \"thinfilm_thickness\", 100 * u);",
        "string key = u > 0.5 ? \"thinfilm_ior\" : \"thinfilm_thickness\"; Ci = conductor_bsdf(N, vector(1), 0.5, 0.5, color(v), color(u), \"ggx\", key, 1.5 + v);",
        // A program that does not know a closure says so for each point; texts of closures are those of the point.
        "if (u > 0.5) Ci = u * phong(N, 3) + v * diffuse(N); printf(\"%s %s\", Ci, v * emission());",
    ];
    for code in all {
        let text = format!("surface test(output closure color o = 0) {{ {code} o = Ci * 0.5; }}");
        compare(&single_group(&text), &text);
    }
}

#[test]
fn layers() {
    let first = "shader first(float x = 2 * 3, output float a = 1, output color b = 0, output int n = 4) { a = x + u; b = noise(P); if (v > 0.9) return; n = 7; printf(\"here %g\\n\", u); }";
    let second = "shader second(float a = 0, color b = 1, int n = 2, output float f = 3) { if (u > 0.5) f = a; else if (u > 0.2) f = b[1]; f += Dx(b[0]); if (v > 0) f += n; }";
    let third = "shader third(float g = 0, color b = 0, output float f = 0, output color o = 0) { for (int i = 0; i < 3; ++i) { if (i > v * 3) f += g; } o = b; }";
    let mut group = Group::default();
    for (text, name) in [(first, "one"), (second, "two"), (third, "three")] {
        group.add(shader(text), Some(name), &[], &mut Vec::new());
    }
    for [a, b, c, d] in [
        ["one", "a", "two", "a"],
        ["one", "b", "two", "b"],
        ["one", "n", "two", "n"],
        ["two", "f", "three", "g"],
        ["one", "a", "three", "b[1]"],
    ] {
        group.connect(a, b, c, d).expect("they are connected");
    }
    compare(&group, "three layers");
}

#[test]
fn endless_loops_are_stopped() {
    // Machine code turns sooner than it takes to wait for the interpreter, which says the same.
    use gnurt_jit::{Compiled, Lanes};
    use gnurt_sl::exec::{Event, Plan, PlanOptions};
    let group =
        single_group("shader test(output float f = 0) { f = 1; if (u > 0.5) while (1) { f += 1; } f = 2; }");
    let plan = std::sync::Arc::new(Plan::new(&group, &PlanOptions::default()).expect("a plan"));
    let level = gnurt_simd::Level::best();
    if !Compiled::can(level) {
        eprintln!("SKIPPED: there is no machine code for {level}");
        return;
    }
    let code = Compiled::new(plan, level).expect("code");
    let world = super::world::World::default();
    let mut lanes = Lanes::new(&code, &world);
    let points = super::world::points(16);
    lanes.run(&super::world::rows(&points));
    let events = lanes.take_events();
    let stopped = points.iter().filter(|p| p.u.value > 0.5).count();
    assert_eq!(events.len(), stopped, "every point that turns is stopped, and only those");
    let Event::Error(text) = &events[0].1 else { panic!("an error: {events:?}") };
    assert!(text.starts_with("stopped: a loop at test.osl:1 did not end"), "{text}");
    let (_, first) = lanes.output(0, Some(0), "f").expect("an output");
    assert_eq!(first, gnurt_sl::hir::Data::Float(vec![2.0]), "the others go on");
}

/// Values that parameters are given are known when code is made: kinds of noise, indices.
#[test]
fn parameters_are_constants() {
    let text = "shader test(string kind = \"perlin\", int k = 1, float w[3] = {1, 2, 3}, color c = color (1, 2, 3), output float f = 0, output color o = 0) { f = noise (kind, P) + w[k] + c[k] + u; o[k] = f * c[2]; float s = 0; for (int i = 0; i < k; ++i) s += w[2]; f += s; }";
    assert_eq!(compare(&single_group(text), text), 0, "operations that are left to the interpreter");
    let text = "shader test(matrix m = matrix (1, 2, 0, 0, 0, 1, 3, 0, 0, 0, 2, 0, 4, 0, 0, 1), int k = 2, output point o = 0, output vector w = 0, output float f = 0) { o = transform (1 / m, P); w = transform (m * 2 / m, vector (P)); matrix a = k / m, b = u / m; f = a[0][1] + b[2][2]; }";
    assert_eq!(compare(&single_group(text), text), 1, "a quotient that varies is left");
}
