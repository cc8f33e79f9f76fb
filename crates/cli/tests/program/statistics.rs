// SPDX-License-Identifier: GPL-3.0-or-later
//! `--stats`: JSON alone on standard output, a table on standard error.

use super::harness::Folder;

#[test]
fn json_stands_alone() {
    let folder = Folder::new();
    let run =
        folder.gnurt("render builtin:cornell -r 20x10 --spp 3 -t 2 --seed 5 -o p.png --stats=json").success();
    let json: serde_json::Value = serde_json::from_str(&run.stdout).expect("JSON and nothing else");
    for (name, value) in
        [("width", 20), ("height", 10), ("spp", 3), ("seed", 5), ("threads", 2), ("samples", 600)]
    {
        assert_eq!(json[name], value, "{name}: {json}");
    }
    assert_eq!(json["rays"]["camera"], 600, "one ray per sample: {json}");
    assert_eq!(json["complete"], true, "all samples were taken");
    assert!(json["seconds"]["render"].as_f64().is_some_and(|s| s > 0.0), "a time: {json}");
    assert!(!run.stdout.contains("NaN") && !run.stdout.contains("inf"), "numbers only");
    assert!(
        run.stderr.lines().all(|line| line.starts_with("note: ")),
        "nothing but notes beside it: {}",
        run.stderr
    );
}

#[test]
fn the_table_is_for_people() {
    let folder = Folder::new();
    let run = folder.gnurt("render builtin:cornell -r 8x8 --spp 1 -q --stats -o p.png").success();
    assert_eq!(run.stdout, "", "standard output is free");
    for row in ["triangles", "camera rays", "render", "threads"] {
        assert!(run.stderr.contains(row), "{row} is in the table: {}", run.stderr);
    }
}

#[test]
fn time_ends_a_rendering() {
    let folder = Folder::new();
    let line = "render builtin:cornell -r 64x64 --spp 100000000 --time 300ms -o p.png --stats=json";
    let run = folder.gnurt(line).success();
    let json: serde_json::Value = serde_json::from_str(&run.stdout).expect("JSON");
    assert_eq!(json["complete"], false, "not all samples were taken");
    assert!(
        json["seconds"]["render"].as_f64().is_some_and(|s| s < 5.0),
        "about the time that was given: {json}"
    );
    assert!(run.stderr.contains("the time is up"), "and says so: {}", run.stderr);
}
