// SPDX-License-Identifier: GPL-3.0-or-later
//! `bench`: small runs without a rival, which check their answers as large ones do.

use super::harness::Folder;

const CLASSES: [&str; 5] = ["primary", "shadow", "ao", "diffuse", "shuffled"];

#[test]
fn rays_are_measured_and_their_answers_agree() {
    let folder = Folder::new();
    let run = folder
        .gnurt("bench rays builtin:cornell --size 32 --rounds 2 --json rays.json --svg rays.svg --record record.json")
        .success();
    assert!(run.lines("note: ").iter().any(|line| line.contains("EMBREE4_LIB")), "{}", run.stderr);
    assert_eq!(run.lines("note: ").len(), 1, "our own trees agree in every ray: {}", run.stderr);
    assert!(folder.read("rays.svg").starts_with(b"<svg"), "a picture of bars");
    let record: serde_json::Value = serde_json::from_slice(&folder.read("record.json")).expect("JSON");
    assert!(
        record["rows"].as_array().is_some_and(|rows| rows.iter().all(|row| row["rates"].is_array())),
        "{record}"
    );
    assert_eq!((&record["rounds"], &record["threads"]), (&2.into(), &1.into()), "{record}");
    let rows: serde_json::Value = serde_json::from_slice(&folder.read("rays.json")).expect("JSON");
    let rows = rows.as_array().expect("an array");
    for class in CLASSES {
        let of_class: Vec<_> = rows.iter().filter(|row| row["class"] == class).collect();
        assert!(of_class.len() >= 9, "each mode of {class}: {}", of_class.len());
        assert!(of_class.iter().all(|row| row["hits"] == of_class[0]["hits"]), "one answer: {of_class:?}");
        assert!(of_class.iter().all(|row| row["mrays_cpu"].as_f64().is_some_and(|rate| rate > 0.0)), "rates");
        assert!(run.stdout.contains(&format!("cornell {class}: ")), "a table of {class}: {}", run.stdout);
    }
}

#[test]
fn jobs_are_chosen() {
    let folder = Folder::new();
    let line = "bench rays builtin:cornell --size 16 --rounds 1 --class primary,ao --mode kd-medium -q -t 2";
    let run = folder.gnurt(line).success();
    assert_eq!(run.stderr, "", "quiet");
    let modes = run.stdout.lines().filter(|line| line.trim_start().starts_with("gnurt"));
    assert_eq!(modes.count(), 2 * 4, "four modes of two classes: {}", run.stdout);
}

#[test]
fn builds_are_measured() {
    let folder = Folder::new();
    let run = folder.gnurt("bench build builtin:cornell --rounds 1 -t 2 --json build.json").success();
    assert!(run.stdout.contains("cornell: ") && run.stdout.contains("bvh-medium"), "{}", run.stdout);
    let rows: serde_json::Value = serde_json::from_slice(&folder.read("build.json")).expect("JSON");
    let rows = rows.as_array().expect("an array");
    assert!(rows.iter().any(|row| row["threads"] == 2 && row["mode"] == "kd-medium"), "{rows:?}");
    assert!(rows.iter().all(|row| row["bytes"].as_u64().is_some_and(|bytes| bytes > 0)), "{rows:?}");
}

#[test]
fn what_moves_is_measured() {
    let folder = Folder::new();
    let line = "bench dynamic builtin:cornell --case refit,rebuild,top --frames 2 --rounds 1 --size 16 --instances 500 -t 2 \
                --json moving.json --svg moving.svg";
    let run = folder.gnurt(line).success();
    assert!(run.stdout.contains("frame ms") && run.stdout.contains("move-1000"), "{}", run.stdout);
    assert!(folder.read("moving.svg").starts_with(b"<svg"), "bars");
    let rows: serde_json::Value = serde_json::from_slice(&folder.read("moving.json")).expect("JSON");
    let rows = rows.as_array().expect("an array");
    let keys =
        "bytes case engine hits instances scene strategy threads trace_mrays_cpu triangles update_ms_cpu";
    for row in rows {
        let mut found: Vec<&str> = row.as_object().expect("an object").keys().map(String::as_str).collect();
        found.sort_unstable();
        assert_eq!(found.join(" "), keys, "{row}");
    }
    let has = |case: &str, strategy: &str| {
        rows.iter().any(|row| row["case"] == case && row["strategy"] == strategy)
    };
    assert!(has("refit", "auto") && has("rebuild", "fast") && has("top", "build"), "{rows:?}");
    folder.gnurt("bench dynamic --case tops").fails(2, "did you mean 'top'?");
    folder.gnurt("bench dynamic --instances 0").fails(2, "from 1 to 10000000");
}

#[test]
fn the_papers_tables_are_made() {
    let folder = Folder::new();
    let run = folder.gnurt("bench paper builtin:cornell --size 32 --rounds 1 --json paper.json").success();
    for expected_text in ["Table 1", "Table 2", "cornell"] {
        assert!(run.stdout.contains(expected_text), "{expected_text}: {}", run.stdout);
    }
    let rows: serde_json::Value = serde_json::from_slice(&folder.read("paper.json")).expect("JSON");
    assert!(rows[0]["scalar_mrays"].as_f64().is_some_and(|rate| rate > 0.0), "{rows}");
}

#[test]
fn bad_words_are_explained() {
    let folder = Folder::new();
    for (line, status, expected) in [
        ("bench", 2, "valid are: rays, build, dynamic, paper"),
        ("bench paper", 2, "<SCENE>"),
        ("bench build --mode compakt", 2, "no mode matches"),
        ("bench build --size 8", 2, "unknown option '--size'"),
        ("bench beams", 2, "unknown command 'beams'"),
        ("bench rays --class primry", 2, "did you mean 'primary'?"),
        ("bench rays --engine embree", 2, "did you mean 'embree4'?"),
        ("bench rays --mode qbvh", 2, "no mode matches"),
        ("bench rays --siz 8", 2, "did you mean '--size'?"),
        ("bench rays --size 4", 2, "from 8 to 8192"),
        ("bench rays --rounds 0", 2, "from 1 to 1000"),
        ("bench rays no.obj", 1, "no such file"),
        ("bench rays --json no/folder/a.json", 1, "no/folder/a.json"),
    ] {
        println!("gnurt {line}");
        folder.gnurt(line).fails(status, expected);
    }
}

#[test]
fn a_library_that_is_no_embree_is_refused() {
    let folder = Folder::new();
    folder.write("no.so", "this is no library");
    let mut command = folder.command(&["bench", "rays", "builtin:cornell", "--size", "8", "-q"]);
    command.env("EMBREE4_LIB", folder.at("no.so"));
    super::harness::finish(command).fails(1, "no.so");
}

#[test]
fn light_is_measured_against_a_truth_that_is_kept() {
    let folder = Folder::new();
    let line = "bench light builtin:cornell -r 8x6 --integrator ir,bir --vpls 16 --max-depth 3 --rounds 1 --time 0.05s \
                --truth-spp 2 --truth truth.exr --csv light.csv --svg light.svg --environment 0.3,0.3,0.3";
    let run = folder.gnurt(line).success();
    assert!(run.stdout.contains("ir") && run.stdout.contains("bir"), "a table: {}", run.stdout);
    let points = String::from_utf8(folder.read("light.csv")).expect("text");
    assert!(points.lines().count() >= 3, "a head, and points of both: {points}");
    assert!(folder.read("light.svg").starts_with(b"<svg"), "curves");
    let truth = [folder.read("truth.exr"), folder.read("truth2.exr")];
    folder.gnurt(line).success();
    // Integrator, seed, samples and error of a first sample, which do not depend on the clock; some pixels
    // see only the sky.
    let first = |points: &str| -> Vec<String> {
        let row = points.lines().nth(1).expect("a point").split(',').map(str::to_owned);
        row.enumerate().filter(|(k, _)| *k != 4).map(|(_, value)| value).collect()
    };
    let again = String::from_utf8(folder.read("light.csv")).expect("text");
    assert_eq!(first(&points), first(&again), "errors against the files are those against what was rendered");
    assert_eq!(
        truth,
        [folder.read("truth.exr"), folder.read("truth2.exr")],
        "what is kept is not made again"
    );
    folder.gnurt("bench light builtin:cornell -r 9x6 --truth truth.exr").fails(1, "must be 9x6");
}
