// SPDX-License-Identifier: GPL-3.0-or-later
//! Code as a program for batches, kept and made by a thread of its own; files that mean harm.

use super::chance::{Dice, mutated};
use super::world::{World, compare, points, rows, shader, single_group};
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
    Arc::new(Plan::new(&single_group(TEXT), &options).expect("a plan"))
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
    assert_eq!(job.retained(), interpreted.retained(), "what is kept");
    for count in [16, 5, 16] {
        let batch = rows(&points(count));
        let (mut expected, mut found) = (Results::default(), Results::default());
        interpreted.run(&world, &batch, &mut expected);
        job.run(&world, &batch, &mut found);
        let cut =
            |results: &Results| results.rows.iter().map(|row| row[..count].to_vec()).collect::<Vec<_>>();
        assert_eq!(cut(&found), cut(&expected), "{count} points");
        assert_eq!(found.events, expected.events, "what is said");
        for lane in 0..count {
            assert_eq!(parts_of(&found, lane), parts_of(&expected, lane), "point {lane}");
            assert_eq!(
                parts_of(&found, lane).len(),
                usize::from(lane > 0),
                "a closure at point {lane}, where u is not 0"
            );
        }
    }
}

/// The numbers of a point's closures, which are the same in every engine.
fn parts_of(results: &Results, lane: usize) -> Vec<([f32; 3], u32, [u32; 3])> {
    let parts = results.closures.parts(results.ci[lane], lane).into_iter();
    parts.map(|(w, part)| (w, part.kind, [0, 1, 2].map(|i| part.cells(i).at(lane)))).collect()
}

#[test]
fn two_batches_at_once_are_two_batches() {
    let level = Level::best();
    if !has_code() {
        return;
    }
    let (cache, world) = (Cache::default(), World::default());
    let (interpreted, job) = (plan(), cache.start(plan(), level));
    let code = Compiled::pair(plan(), level).expect("code");
    job.wait().expect("code");
    let all = points(32);
    let (mut expected, mut found) = (<[Results; 2]>::default(), <[Results; 2]>::default());
    // The job gets code for pairs in the middle of it.
    for turn in 0..80 {
        let second = [16, 3, 0, 9][turn % 4];
        let batches = [rows(&all[..16]), rows(&all[16..16 + second])];
        interpreted.run_pair(&world, &batches, &mut expected);
        let programs: [&dyn Program; 2] = [&job, &code];
        for program in programs {
            program.run_pair(&world, &batches, &mut found);
            for (half, (found, expected)) in found.iter().zip(&expected).enumerate() {
                let count = batches[half].count;
                let how = format!("turn {turn}, batch {half}");
                let cut = |r: &Results| r.rows.iter().map(|row| row[..count].to_vec()).collect::<Vec<_>>();
                assert_eq!(cut(found), cut(expected), "{how}");
                assert_eq!(found.events, expected.events, "{how}: what is said");
                for lane in 0..count {
                    assert_eq!(parts_of(found, lane), parts_of(expected, lane), "{how}, point {lane}");
                }
            }
        }
        let start = std::time::Instant::now();
        while turn == 40 && Compiled::pairs_pay(level) && !job.is_pair_ready() {
            assert!(start.elapsed().as_secs() < 60, "pairs that have come get no code");
            std::thread::sleep(std::time::Duration::from_millis(5));
        }
    }
    assert_eq!(job.is_pair_ready(), Compiled::pairs_pay(level), "code for pairs");
    assert!(parts_of(&expected[0], 3).len() == 1, "there are closures");
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
        let options = PlanOptions { iterations: 500, ..PlanOptions::default() };
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
        (
            "w = point (\"object\", u, v, 1); r = normal (\"object\", u * u, 2, v) + vector (\"object\", 0, k, u); f = Dx (w[1]) + Dy (r[0]);",
            0,
        ),
        (
            "if (u > 0.4) w = point (\"object\", u * v, 1, 2); d = Dx (w); w += point (\"common\", u, 2, v);",
            0,
        ),
        (
            "c = blackbody (1900) + blackbody (u * 5000); if (v > 0.4) c = blackbody (k); d = wavelength_color (500 + 100 * v);",
            0,
        ),
        // These are asked one by one.
        ("w = point (\"own\", u, v, 1); r = vector (u > 0.5 ? \"own\" : \"object\", u, 0, 1);", 0),
        ("w = point (\"nowhere\", u, v, 1);", 0),
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
        let found = compare(&single_group(&text), &text);
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
    let large =
        single_group("surface test(int k = 0) { float a[20000]; a[k] = u; Ci = a[k + 1] * diffuse (N); }");
    let (cache, world) = (Cache::default(), World::default());
    for (group, limit) in [(layers, "more than 1000 layers"), (large, "more than 16384 numbers")] {
        let plan = Plan::new(&group, &PlanOptions::default()).expect("a plan");
        let job = cache.start(Arc::new(plan), level);
        let why = job.wait().err();
        assert!(matches!(&why, Some(NoCode::OfGroup(why)) if why.contains(limit)), "{limit}: {why:?}");
        let mut results = Results::default();
        let mut messages = |job: &dyn Program| {
            job.run(&world, &rows(&points(3)), &mut results);
            std::mem::take(&mut results.events)
        };
        let first = messages(&job);
        assert!(
            matches!(&first[..], [(0, Event::Warning(text))] if text.contains(limit)),
            "{limit}: {first:?}"
        );
        assert_eq!(messages(&job), [], "{limit}: once");
    }
}

/// The results of both for points that are run one batch after the other in the same memory; also the code's
/// own properties.
fn agree(text: &str, iterations: u64) -> Result<(), NoCode> {
    let level = Level::best();
    let outputs = vec!["f".into()];
    let options = PlanOptions { outputs, iterations, ..PlanOptions::default() };
    let plan = || Arc::new(Plan::new(&single_group(text), &options).expect("a plan"));
    let (cache, world, interpreted) = (Cache::default(), World::default(), plan());
    let job = cache.start(plan(), level);
    job.wait()?;
    let (mut expected, mut found) = (Results::default(), Results::default());
    for turn in 0..3 {
        let batch = rows(&points(16));
        interpreted.run(&world, &batch, &mut expected);
        job.run(&world, &batch, &mut found);
        assert_eq!(found.rows, expected.rows, "batch {turn}: {text}");
        assert_eq!(found.events, expected.events, "batch {turn}: what is said: {text}");
    }
    Ok(())
}

/// Whether there is code to test.
fn has_code() -> bool {
    let has = Compiled::can(Level::best());
    if !has {
        eprintln!("SKIPPED: there is no machine code for {}", Level::best());
    }
    has
}

#[test]
fn arrays_that_get_shorter_ones_keep_nothing_of_the_batch_before() {
    let text = "shader test (output float f = 0) { float a[4]; float b[2] = {u, v}; a = b; printf (\"\"); f = a[3]; a[3] = 7; printf (\"\"); }";
    if has_code() {
        agree(text, 1000).expect("code");
    }
}

/// Each turn of the outer loop, one point goes on alone.
#[test]
fn points_have_turns_of_their_own() {
    let text = "shader test (output float f = 0) { for (int k = 0; k < 16; ++k) if ((int) (u * 13 + 0.5) == k) for (int i = 0; i < 200; ++i) f += 1; }";
    if has_code() {
        agree(text, 500).expect("code");
    }
}

#[test]
fn loops_in_loops_take_no_time_to_look_at() {
    let head: String = (0..40).map(|i| format!("for (int i{i} = 0; i{i} < 1; ++i{i}) ")).collect();
    let inner = "{ if (u > 0.5 && f > 3) break; f += u; }";
    let start = std::time::Instant::now();
    if has_code() {
        agree(&format!("shader test (output float f = 0) {{ {head} {inner} }}"), 1000).expect("code");
    }
    assert!(start.elapsed().as_secs() < 20, "{:?}", start.elapsed());
}

/// Varying variables are found one per pass.
#[test]
fn long_ways_around_loops_mean_the_same() {
    let count = 150;
    let names: Vec<String> = (0..=count).map(|i| format!("a{i}")).collect();
    let moves: String = names.windows(2).map(|pair| format!("{} = {}; ", pair[0], pair[1])).collect();
    let text = format!(
        "shader test (output float f = 0) {{ float {} = 0; for (int i = 0; i < 160; ++i) {{ {moves} a{count} = i + u; }} if (a0 > 3) f = a0; }}",
        names.join(" = 0, ")
    );
    if has_code() {
        agree(&text, 1000).expect("code");
    }
}

#[test]
fn code_has_an_end() {
    let lines: String = (0..3500).map(|i| format!("f += Dx (noise (P * {i}, u)); ")).collect();
    let text = &format!("shader test (output float f = 0) {{ {lines} }}");
    if has_code() {
        let why = agree(text, 1000).expect_err("too large");
        assert!(matches!(&why, NoCode::OfGroup(why) if why.contains("operations")), "{why}");
    }
}

/// How many threads of this process make code.
#[cfg(target_os = "linux")]
fn threads() -> usize {
    let list = std::fs::read_dir("/proc/self/task").expect("this process").flatten();
    let names = list.filter_map(|task| std::fs::read_to_string(task.path().join("comm")).ok());
    names.filter(|name| name.trim() == "shader code").count()
}

#[cfg(target_os = "linux")]
#[test]
fn many_groups_take_few_threads() {
    if !has_code() {
        return;
    }
    let cache = Cache::default();
    let before = threads();
    let jobs: Vec<_> = (0..64)
        .map(|i| {
            let lines: String = (0..12).map(|k| format!("f += noise (P * {i}, {k}); ")).collect();
            let text = format!("shader test (output float f = 0) {{ {lines} }}");
            let plan = Plan::new(&single_group(&text), &PlanOptions::default()).expect("a plan");
            cache.start(Arc::new(plan), Level::best())
        })
        .collect();
    // Those of tests beside this one are counted, too.
    assert!(threads() <= before + 24, "{} threads", threads());
    assert!(jobs.iter().all(|job| job.wait().is_ok()), "code of all");
}
