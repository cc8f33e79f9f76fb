// SPDX-License-Identifier: GPL-3.0-or-later
//! Measures shader files: nanoseconds a point by the interpreter, and as machine code for each level of the CPU, a batch at a time and two.
//!
//! `cargo run --release -p gnurt-jit --example files -- FILE.osl...`

mod common;

use std::io::Write as _;
use std::path::Path;
use std::sync::Arc;

use common::{batches, time};
use gnurt_jit::{Compiled, Lanes};
use gnurt_simd::Level;
use gnurt_sl::exec::{
    ClosureDecl, Host, Plan, PlanOptions, Point, Points, Program, Results, standard_closures,
};
use gnurt_sl::group::Group;
use gnurt_sl::{Options, compile};
use gnurt_sl_lib::Dual;
use gnurt_sl_lib::color::ColorSystem;

/// Points of a run.
const COUNT: usize = 256;

struct World(ColorSystem);

impl Host for World {
    fn color_system(&self) -> &ColorSystem {
        &self.0
    }

    fn closures(&self) -> &[ClosureDecl] {
        standard_closures()
    }

    fn common_from(&self, _: &str, _: &Point) -> Option<[[f32; 4]; 4]> {
        Some([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
    }

    fn is_same_space(&self, _: &str, _: u32, _: &[i32; 16]) -> bool {
        true
    }
}

/// Points of a wall of two units, seen from in front.
fn points() -> Vec<Points> {
    let x = |k: usize, s: f32| (k as f32 * s).fract();
    let point = |k: usize| {
        let (u, v) = (x(k, 0.618_034), x(k, 0.414_214));
        Point {
            p: Dual::from_components([
                Dual::new(2.0 * u - 1.0, 0.01, 0.0),
                Dual::new(2.0 * v - 1.0, 0.0, 0.01),
                Dual::from(0.25 * u),
            ]),
            i: [0.1, 0.2, -0.974_679_5].into(),
            n: [0.0, 0.6, 0.8],
            ng: [0.0, 0.6, 0.8],
            ps: [u, v, 0.5].into(),
            u: Dual::new(u, 0.005, 0.0),
            v: Dual::new(v, 0.0, 0.005),
            dpdu: [2.0, 0.0, 0.0],
            dpdv: [0.0, 2.0, 0.0],
            xi: [u, v],
            index: k as i32,
            ..Point::default()
        }
    };
    batches(&(0..COUNT).map(point).collect::<Vec<_>>(), 16)
}

fn plan(path: &str) -> Result<Arc<Plan>, String> {
    let text = std::fs::read_to_string(path).map_err(|why| why.to_string())?;
    let load = |path: &Path| std::fs::read_to_string(path).ok();
    let compiled = compile(path, &text, &Options::default(), &load);
    let Some(shader) = compiled.shader else {
        return Err(compiled.diagnostics.list.first().map_or_else(String::new, |d| d.message.clone()));
    };
    let mut group = Group::default();
    group.add(Arc::new(shader), None, &[], &mut Vec::new());
    Plan::new(&group, &PlanOptions { drops_outputs: true, ..PlanOptions::default() }).map(Arc::new)
}

fn main() -> Result<(), String> {
    let mut out = std::io::stdout().lock();
    let world = World(ColorSystem::named("Rec709").ok_or("no colours")?);
    let levels: Vec<Level> = Level::available().into_iter().filter(|&l| Compiled::can(l)).collect();
    let batches = points();
    for path in std::env::args().skip(1) {
        let plan = plan(&path).map_err(|why| format!("{path}: {why}"))?;
        let name =
            Path::new(&path).file_stem().map_or_else(String::new, |name| name.to_string_lossy().into());
        let mut results = Results::default();
        let interpreted =
            time(COUNT, || batches.iter().for_each(|points| plan.run(&world, points, &mut results)));
        let _ = write!(out, "{name:<40} interpreter {interpreted:.1}");
        for &level in &levels {
            match Compiled::new(plan.clone(), level)
                .and_then(|one| Ok((one, Compiled::pair(plan.clone(), level)?)))
            {
                Ok((one, two)) => {
                    let (mut a, mut b) = (Lanes::new(&one, &world), Lanes::new(&two, &world));
                    let each = time(COUNT, || batches.iter().for_each(|points| a.run(points)));
                    let in_pairs = time(COUNT, || batches.chunks(2).for_each(|points| b.run_all(points)));
                    let _ = write!(out, " {level} {each:.1} {in_pairs:.1}");
                }
                Err(why) => {
                    let _ = write!(out, " {level} {why}");
                }
            }
        }
        let _ = writeln!(out);
    }
    Ok(())
}
