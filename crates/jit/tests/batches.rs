// SPDX-License-Identifier: GPL-3.0-or-later
//! Code as a program for batches, kept and made by a thread of its own; files that mean harm.

use super::chance::{Dice, mutated};
use super::world::{World, alone, compare, points, rows, shader};
use gnurt_jit::{Cache, Compiled, Lanes, NoCode};
use gnurt_simd::Level;
use gnurt_sl::exec::{Event, Plan, PlanOptions, Program, Results};
use gnurt_sl::group::Group;
use gnurt_sl::ir::{read, write};
use std::sync::Arc;

const TEXT: &str = "surface test(float s = 7 [[int interpolated = 1]], output float f = 0, output color o = 0, output int k = 0) { f = s + u; o = noise(P) * f; for (k = 0; k < u * 9; ++k) f += v; printf(\"%d \", k); Ci = u * diffuse(N); }";

fn plan() -> Arc<Plan> {
    let outputs = vec!["f".into(), "o".into(), "k".into()];
    let options = PlanOptions { outputs, ..PlanOptions::default() };
    Arc::new(Plan::new(&alone(TEXT), &options).expect("a plan"))
}

#[test]
fn a_batch_by_code_is_a_batch_by_the_interpreter() {
    let level = Level::best();
    if !Compiled::can(level) {
        eprintln!("SKIPPED: there is no machine code for {level}");
        return;
    }
    let (cache, world) = (Cache::default(), World::default());
    let interpreted = plan();
    let job = cache.start(plan(), level);
    let again = cache.start(plan(), level);
    let code = job.wait().expect("code");
    assert!(std::ptr::eq(code, again.wait().expect("code")), "the same group has the same code");
    assert_eq!(job.kept(), interpreted.kept(), "what is kept");
    for count in [16, 5, 16] {
        let batch = rows(&points(count));
        let (mut wanted, mut found) = (Results::default(), Results::default());
        interpreted.run(&world, &batch, &mut wanted);
        job.run(&world, &batch, &mut found);
        let cut =
            |results: &Results| results.rows.iter().map(|row| row[..count].to_vec()).collect::<Vec<_>>();
        assert_eq!(cut(&found), cut(&wanted), "{count} points");
        assert_eq!(found.events, wanted.events, "what is said");
        for lane in 0..count {
            let components = |r: &Results| {
                let parts = r.closures.parts(r.ci[lane], lane).into_iter();
                let numbers =
                    parts.map(|(w, part)| (w, part.kind, [0, 1, 2].map(|i| part.cells(i).at(lane))));
                numbers.collect::<Vec<_>>()
            };
            assert_eq!(components(&found), components(&wanted), "point {lane}");
            assert_eq!(
                components(&found).len(),
                usize::from(lane > 0),
                "a closure at point {lane}, where u is not 0"
            );
        }
    }
}

#[test]
fn files_that_mean_harm_do_none() {
    let level = Level::best();
    let text = write(&shader(TEXT), "");
    let world = World::default();
    let mut dice = Dice::new(7);
    let mut ran = 0;
    for _ in 0..400 {
        let Ok(shader) = read(&mutated(&text, &mut dice)) else { continue };
        let mut group = Group::default();
        group.add(Arc::new(shader), None, &[], &mut Vec::new());
        let options = PlanOptions { turns: 500, ..PlanOptions::default() };
        let Ok(plan) = Plan::new(&group, &options) else { continue };
        if let Ok(code) = Compiled::new(Arc::new(plan), level) {
            Lanes::new(&code, &world).run(&rows(&points(16)));
            ran += 1;
        }
    }
    assert!(ran > 20 || !Compiled::can(level), "some of them run: {ran}");
}

#[test]
fn what_a_host_answers_for_all_points_is_what_it_answers_for_each() {
    let outputs = "output color c = 0, output float a = 0, output color d = 0, output float f = 0, output int k = 0, output vector w = 0, output vector r = 0";
    for (body, left) in [
        ("k = raytype (\"shadow\") + 2 * raytype (\"glossy\") + 4 * backfacing (); f = surfacearea ();", 0),
        ("f = raytype (\"camera\"); if (u > 0.4) f = backfacing (); k = surfacearea () > 3;", 0),
        ("c = texture (\"t.png\", u, v); d = Dx (c); f = texture (\"t.png\", 1, v, \"fill\", 3.0);", 0),
        (
            "c = texture (\"tt.png\", u, v, \"alpha\", a, \"width\", 2, \"twrap\", \"mirror\", \"firstchannel\", 1); d = Dy (a);",
            0,
        ),
        ("if (u > 0.3) c = texture (\"t.png\", u, v, Dx (u), 0.1, v, Dy (u), \"blur\", 0.5); d = Dx (c);", 0),
        ("w = calculatenormal (P * u); r = transform (\"object\", P); vector by = Dx (r); f = by[1];", 0),
        ("r = transform (\"object\", \"common\", vector (P)) + transform (\"common\", normal (u, v, 1));", 0),
        ("if (u > 0.3) r = transform (\"object\", normal (P)); w = Dy (r);", 0),
        // These are asked one by one.
        ("w = transform (\"own\", P); r = transform (u > 0.5 ? \"own\" : \"object\", \"object\", P);", 0),
        ("w = transform (\"nowhere\", P);", 0),
        (
            "c = texture (u > 0.5 ? \"t.png\" : \"tt.png\", u, v); d = texture (\"t.png\", u, v, \"blur\", u);",
            0,
        ),
        ("k = raytype (u > 0.5 ? \"camera\" : \"shadow\"); c = texture (\"alone.png\", u, v);", 0),
        ("string why = \"\"; c = texture (\"t.png\", u, v, \"errormessage\", why); printf (\"%s\", why);", 1),
        ("c = texture (\"missing.png\", u, v, \"alpha\", a); d = Dx (c);", 0),
        ("c = texture (\"missing.png\", u, v, \"missingcolor\", color (1, 2, 3), \"missingalpha\", 0.5);", 0),
        ("c = environment (\"t.png\", P);", 1),
    ] {
        let text = format!("surface test ({outputs}) {{ {body} }}");
        let found = compare(&alone(&text), &text);
        assert!(found == left || !Compiled::can(Level::best()), "{found} operations are left: {body}");
    }
}

#[test]
fn groups_beyond_a_limit_say_once_that_they_are_interpreted() {
    let level = Level::best();
    if !Compiled::can(level) {
        eprintln!("SKIPPED: there is no machine code for {level}");
        return;
    }
    let layer = shader("surface test(float x = 0) { Ci = x * diffuse (N); }");
    let mut layers = Group::default();
    for i in 0..1001 {
        layers.add(layer.clone(), Some(&format!("l{i}")), &[], &mut Vec::new());
    }
    let large = alone("surface test(int k = 0) { float a[20000]; a[k] = u; Ci = a[k + 1] * diffuse (N); }");
    let (cache, world) = (Cache::default(), World::default());
    for (group, limit) in [(layers, "more than 1000 layers"), (large, "more than 16384 numbers")] {
        let plan = Plan::new(&group, &PlanOptions::default()).expect("a plan");
        let job = cache.start(Arc::new(plan), level);
        let why = job.wait().err();
        assert!(matches!(&why, Some(NoCode::OfGroup(why)) if why.contains(limit)), "{limit}: {why:?}");
        let mut results = Results::default();
        let mut said = |job: &dyn Program| {
            job.run(&world, &rows(&points(3)), &mut results);
            std::mem::take(&mut results.events)
        };
        let first = said(&job);
        assert!(
            matches!(&first[..], [(0, Event::Warning(text))] if text.contains(limit)),
            "{limit}: {first:?}"
        );
        assert_eq!(said(&job), [], "{limit}: once");
    }
}
