// SPDX-License-Identifier: GPL-3.0-or-later
//! Measures: one lane, sixteen, and two batches of sixteen at once, by kernels, and how long a group takes to compile. Prints a table.
//!
//! `cargo run --release -p gnurt-jit --example speed`

mod common;

use common::{batches, time};
use gnurt_jit::{Compiled, Lanes};
use gnurt_simd::Level;
use gnurt_sl::exec::{Host, Machine, Plan, PlanOptions, Point};
use gnurt_sl::group::Group;
use gnurt_sl::{Options, compile};
use gnurt_sl_lib::Dual;
use gnurt_sl_lib::color::ColorSystem;
use std::io::Write as _;
use std::sync::Arc;
use std::time::Instant;

struct World(ColorSystem);

impl Host for World {
    fn color_system(&self) -> &ColorSystem {
        &self.0
    }
}

/// Light in `channels` colours, and a loop that points leave at different times: the design's kernels.
fn divergent(channels: usize) -> String {
    let names = ["a", "b", "c"];
    let each = |f: &dyn Fn(&str) -> String| names[..channels].iter().map(|n| f(n)).collect::<String>();
    format!(
        "{} int n = (int) (u * 8.9); int i = 0; while (i < n) {{ {} i += 1; if (a > 2.5) break; }} f = {}0;",
        each(&|n| format!("float {n} = max(0, dot(N, I)) * v;")),
        each(&|n| format!("{n} = {n} * 1.01 + P[0] * {n} * 0.125 + 0.0625;")),
        each(&|n| format!("(u > 0.5 ? {n} : -{n}) + ")),
    )
}

fn kernels() -> Vec<(String, String)> {
    let turned = |body: &str| format!("for (int i = 0; i < 32; ++i) {{ {body} }}");
    let mut list = Vec::new();
    for name in [
        "sin",
        "cos",
        "tan",
        "asin",
        "acos",
        "atan",
        "exp",
        "exp2",
        "log",
        "log10",
        "sqrt",
        "inversesqrt",
        "cbrt",
        "erf",
        "floor",
        "abs",
        "cosh",
    ] {
        list.push((name.into(), turned(&format!("f += {name}(v + f * 0.25 + i);"))));
    }
    for (name, body) in [
        ("pow", "f += pow(u + i, v);"),
        ("atan2", "f += atan2(u + i, v + f);"),
        ("fmod", "f += fmod(u * i, v + 0.1);"),
        ("div", "f += u / (v + i);"),
        ("smoothstep", "f += smoothstep(0.1, 0.9, u * f + i * 0.01);"),
        ("mix", "o = mix(o, P, u);"),
        ("clamp", "o = clamp(o + P, -1, 1);"),
        ("dot", "f += dot(P, I + i);"),
        ("cross", "o = cross(o, P);"),
        ("normalize", "o += normalize(P + i);"),
        ("length", "f += length(P + f);"),
        ("transform", "o = transform(matrix(u, 0, v, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1, 2, 3, 1), o);"),
        ("noise 1D", "f += noise(u * 8 + i);"),
        ("noise 3D", "f += noise(P * 4 + i);"),
        ("noise 4D", "f += noise(P * 4, u + i);"),
        ("color noise 3D", "o += noise(P * 4 + i);"),
        ("noise 3D, derivatives", "f += Dx(noise(P * 4 + i));"),
        ("simplex 3D", "f += noise(\"simplex\", P * 4 + i);"),
        ("cellnoise 3D", "f += cellnoise(P * 4 + i);"),
        ("pnoise 2D", "f += pnoise(u * 8 + i, v * 8, 3, 4);"),
        ("if, varying", "if (noise(u * 9 + i) > 0.5) f += u * v + i; else o += P;"),
        ("int", "k = (k * 5 + i) ^ (k >> 3) & (int) (u * 100);"),
        ("compare", "k += (u + f < v) + (P == I) + (f >= i);"),
    ] {
        list.push((name.into(), turned(body)));
    }
    list.push(("nothing".into(), "f = u;".into()));
    list.push(("nothing, all".into(), "f = dot(N, I) * v + P[0] + u;".into()));
    list.push((
        "masked loop, long".into(),
        "int n = (int) (u * 300); for (int i = 0; i < n; ++i) { f = f * 0.99 + v; if (f > 90) break; }"
            .into(),
    ));
    list.push((
        "loop with a continue".into(),
        "for (int i = 0; i < 30; ++i) { if (fmod(u * i, 0.3) < 0.1) continue; f += v; }".into(),
    ));
    list.push((
        "unknown index".into(),
        "float a[4] = {u, v, 1, 2}; for (int i = 0; i < 32; ++i) f += a[i & 3];".into(),
    ));
    list.push(("varying index".into(), "color c = color (u, v, 1); f = c[(int) (v * 2.9)];".into()));
    list.push(("design, 1 channel".into(), divergent(1)));
    list.push(("design, 3 channels".into(), divergent(3)));
    list
}

fn group(text: &str) -> Group {
    let compiled = compile("speed.osl", text, &Options::default(), &|_| None);
    let mut group = Group::default();
    let shader =
        compiled.shader.unwrap_or_else(|| panic!("{:?}\n{text}", compiled.diagnostics.list[0].message));
    group.add(Arc::new(shader), None, &[], &mut Vec::new());
    group
}

fn plan(text: &str) -> Arc<Plan> {
    Arc::new(Plan::new(&group(text), &PlanOptions::default()).expect("a plan"))
}

fn points(count: usize) -> Vec<Point> {
    let x = |k: usize, s: f32| (k as f32 * s).fract();
    (0..count)
        .map(|k| Point {
            p: Dual::from_components([0.618, 0.414, 0.732].map(|s| Dual::new(x(k, s), 0.01, 0.02))),
            i: [0.1, 0.2, -0.9].into(),
            n: [0.0, 0.6, 0.8],
            u: Dual::new(x(k, 0.618_034), 0.1, 0.0),
            v: Dual::new(x(k, 0.414_214), 0.0, 0.1),
            ..Point::default()
        })
        .collect()
}

/// Lines such as materials have.
fn lines(count: usize) -> String {
    let mut text = String::new();
    for i in 0..count {
        text += &match i % 10 {
            0 => format!("float a{i} = noise(P * {i}.5 + o);\n"),
            1 => format!("color c{i} = mix(o, color(u, v, a{}), 0.3);\n", i - 1),
            2 => format!("if (a{} > 0.5) {{ o += c{} * {i}; }} else {{ o -= 0.1; }}\n", i - 2, i - 1),
            3 => format!("float b{i} = smoothstep(0.2, 0.8, a{}) * pow(u, {i});\n", i - 3),
            4 => format!("vector n{i} = normalize(N + b{} * (vector) o);\n", i - 1),
            5 => format!("f += dot(n{}, I) * b{};\n", i - 1, i - 2),
            6 => format!("for (int j = 0; j < 3; ++j) f += sin(a{} * j);\n", i - 6),
            7 => format!("o[1] = f * sqrt(abs(b{}));\n", i - 4),
            8 => format!("float d{i} = length(Dx(P)) * a{};\n", i - 8),
            _ => format!("o = clamp(o * d{}, 0, 1);\n", i - 1),
        };
    }
    text
}

fn main() {
    let mut out = std::io::stdout().lock();
    let world = World(ColorSystem::named("Rec709").expect("it is known"));
    let levels: Vec<Level> = Level::available().into_iter().filter(|&l| Compiled::can(l)).collect();
    let _ = writeln!(
        out,
        "ns a point; ratios are one lane over sixteen, and sixteen over two batches of sixteen at once, all machine code"
    );
    let _ = write!(out, "{:<24}{:>12}", "kernel", "interpreter");
    for level in &levels {
        for lanes in ["x1", "x16", "x32"] {
            let _ = write!(out, "{:>12}", format!("{level} {lanes}"));
        }
        let _ = write!(out, "{:>8}{:>8}", "16/1", "32/16");
    }
    let _ = writeln!(out);
    let all = points(256);
    let mut sums = vec![[0.0; 2]; levels.len()];
    let kernels = kernels();
    for (name, body) in &kernels {
        let text =
            format!("shader test(output float f = 0, output color o = 0, output int k = 0) {{ {body} }}");
        let plan = plan(&text);
        let mut machine = Machine::new(&plan, &world);
        let few = &all[..32];
        let slow = time(few.len(), || few.iter().for_each(|point| machine.run(point)));
        let _ = write!(out, "{name:<24}{slow:>12.1}");
        for (k, &level) in levels.iter().enumerate() {
            let one = Compiled::scalar(plan.clone(), level).expect("code");
            let many = Compiled::new(plan.clone(), level).expect("code");
            let pair = Compiled::pair(plan.clone(), level).expect("code");
            let (single, together) = (batches(&all, 1), batches(&all, 16));
            let [mut a, mut b, mut c] = [&one, &many, &pair].map(|code| Lanes::new(code, &world));
            let scalar = time(all.len(), || single.iter().for_each(|points| a.run(points)));
            let wide = time(all.len(), || together.iter().for_each(|points| b.run(points)));
            let both = time(all.len(), || together.chunks(2).for_each(|points| c.run_all(points)));
            let ratios = [scalar / wide, wide / both];
            sums[k].iter_mut().zip(ratios).for_each(|(sum, ratio)| *sum += ratio.ln());
            let _ = write!(out, "{scalar:>12.1}{wide:>12.1}{both:>12.1}{:>8.2}{:>8.2}", ratios[0], ratios[1]);
        }
        let _ = writeln!(out);
    }
    for (level, sum) in levels.iter().zip(&sums) {
        let [lanes, pairs] = sum.map(|sum| (sum / kernels.len() as f64).exp());
        let _ = writeln!(out, "{level}: geometric means of {} ratios {lanes:.2}, {pairs:.2}", kernels.len());
    }
    let _ =
        writeln!(out, "\ncompiling, ms: source to intermediate form, plan, machine code; and bytes of code");
    for count in [100, 1000] {
        let text = format!("shader test(output float f = 0, output color o = 0) {{ {} }}", lines(count));
        for &level in &levels {
            let mut best = [f64::INFINITY; 3];
            let mut size = 0;
            for _ in 0..7 {
                let ms = |start: Instant| start.elapsed().as_secs_f64() * 1e3;
                let start = Instant::now();
                let group = group(&text);
                let front = ms(start);
                let start = Instant::now();
                let plan = Arc::new(Plan::new(&group, &PlanOptions::default()).expect("a plan"));
                let middle = ms(start);
                let start = Instant::now();
                let code = Compiled::new(plan, level).expect("code");
                let back = ms(start);
                size = code.size();
                for (best, now) in best.iter_mut().zip([front, middle, back]) {
                    *best = best.min(now);
                }
            }
            let [front, middle, back] = best;
            let _ =
                writeln!(out, "{count} lines, {level}: {front:.2} + {middle:.2} + {back:.2}; {size} bytes");
        }
    }
}
