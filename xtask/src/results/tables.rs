// SPDX-License-Identifier: GPL-3.0-or-later
//! Tables in Markdown, made from the JSON of results. Tests: below, with numbers whose means are known.

use std::fmt::Write;

use serde_json::Value;

/// All tables that the document has rows for, under one line about the machine.
pub(super) fn all(document: &Value, file: &str) -> String {
    let machine = &document["machine"];
    let text = |name: &str| machine[name].as_str().unwrap_or("unknown").to_owned();
    let flags = text("flags");
    let sets = ["sse4_2", "avx2", "avx512f"]
        .map(|set| if flags.split(' ').any(|flag| flag == set) { set } else { "" });
    let sets = sets.iter().filter(|set| !set.is_empty()).copied().collect::<Vec<_>>().join(", ");
    let changed = if machine["changed"] == true { ", with changes" } else { "" };
    let load = machine["load_before"].as_f64().map_or("unknown".into(), |load| format!("{load:.2}"));
    let mut page = format!(
        "{}, commit {}{changed}, {}; {} threads; {sets}; {}; load {load} before. All numbers: [{file}](../../bench/record/{file}).\n",
        text("date"),
        text("commit"),
        text("cpu"),
        machine["threads"],
        text("rustc"),
    );
    let makers: [(&str, &str, Maker); 7] = [
        ("rays", "Rays beside Embree, one thread, speed of ours over theirs", rays),
        ("builds", "Builds beside Embree, one thread", builds),
        ("moving", "Moving meshes, one thread", moving),
        ("paper", "The paper's tables", paper),
        ("pictures", "Whole pictures", pictures),
        ("denoise", "Denoisers", lines),
        ("compile", "Compile time, cold", compile),
    ];
    for (name, title, maker) in makers {
        let row = &document["rows"][name];
        if let (Some(numbers), Some(command)) = (row["numbers"].as_array(), row["command"].as_str()) {
            let _ = write!(page, "\n### {title}\n\n```sh\n{command}\n```\n\n{}", maker(numbers));
        }
    }
    page
}

/// Writes the table of a row's numbers.
type Maker = fn(&[Value]) -> String;

fn number(row: &Value, name: &str) -> f64 {
    row[name].as_f64().unwrap_or(f64::NAN)
}

/// Different values of a field, in their order.
fn values<'a>(rows: &'a [Value], name: &str) -> Vec<&'a str> {
    let mut found = Vec::new();
    for value in rows.iter().filter_map(|row| row[name].as_str()) {
        if !found.contains(&value) {
            found.push(value);
        }
    }
    found
}

/// Geometric mean and least of ratios; "-" without any.
fn mean(ratios: &[f64]) -> String {
    if ratios.is_empty() {
        return "-".into();
    }
    let mean = (ratios.iter().map(|x| x.ln()).sum::<f64>() / ratios.len() as f64).exp();
    let least = ratios.iter().copied().fold(f64::INFINITY, f64::min);
    format!("{mean:.2} ({least:.2})")
}

fn rays(rows: &[Value]) -> String {
    let mut table = String::from(
        "Geometric means, the least scene in brackets. Embree's fastest mode is not watertight.\n\n",
    );
    table += "| class | fastest over fastest | fastest over robust |\n|---|---|---|\n";
    for class in values(rows, "class") {
        let best = |scene: &str, engine: &str, part: &str| {
            let of = rows
                .iter()
                .filter(|row| row["class"] == class && row["scene"] == scene && row["engine"] == engine);
            let of = of.filter(|row| row["mode"].as_str().is_some_and(|mode| mode.contains(part)));
            of.map(|row| number(row, "mrays_cpu")).reduce(f64::max)
        };
        let ratios = |part: &str| -> Vec<f64> {
            let of = |scene| Some(best(scene, "gnurt", "")? / best(scene, "embree4", part)?);
            values(rows, "scene").into_iter().filter_map(of).collect()
        };
        let _ = writeln!(table, "| {class} | {} | {} |", mean(&ratios("")), mean(&ratios("robust")));
    }
    table
}

fn builds(rows: &[Value]) -> String {
    let mut table = String::from("Geometric means, the least scene in brackets.\n\n");
    table += "| quality | Embree's time over ours | Embree's memory over ours |\n|---|---|---|\n";
    for (ours, theirs) in [("bvh-medium", "medium"), ("bvh-high", "high")] {
        let ratios = |name: &str| -> Vec<f64> {
            let of = |scene: &str, engine: &str, mode: &str| {
                let row = rows
                    .iter()
                    .find(|r| r["scene"] == scene && r["engine"] == engine && r["mode"] == mode)?;
                row[name].as_f64().filter(|&x| x > 0.0)
            };
            let ratio = |scene| Some(of(scene, "embree4", theirs)? / of(scene, "gnurt", ours)?);
            values(rows, "scene").into_iter().filter_map(ratio).collect()
        };
        let _ = writeln!(table, "| {theirs} | {} | {} |", mean(&ratios("cpu_s")), mean(&ratios("bytes")));
    }
    table
}

fn moving(rows: &[Value]) -> String {
    let mut table = String::from(
        "| scene | engine | strategy | update, ms | million rays per second | MB |\n|---|---|---|---|---|---|\n",
    );
    for row in rows {
        let [scene, engine, strategy] =
            ["scene", "engine", "strategy"].map(|name| row[name].as_str().unwrap_or("-"));
        let memory = row["bytes"].as_f64().map_or("-".into(), |bytes| format!("{:.1}", bytes / 1e6));
        let [update, rate] = ["update_ms_cpu", "trace_mrays_cpu"].map(|name| number(row, name));
        let _ = writeln!(table, "| {scene} | {engine} | {strategy} | {update:.2} | {rate:.2} | {memory} |");
    }
    table
}

fn paper(rows: &[Value]) -> String {
    let mut table = String::from(
        "kd-trees of [SIP06](../papers.bib): seconds per build; million camera rays per second, one thread.\n\n\
         | scene (the paper's) | build, paper | build, here | SSE, paper | SSE4.2, here | plain, paper | plain, here | best here |\n\
         |---|---|---|---|---|---|---|---|\n",
    );
    for row in rows {
        let theirs = &row["paper"];
        let name = |row: &Value| row["scene"].as_str().unwrap_or("-").to_owned();
        let cells = [
            (theirs, "build_s"),
            (row, "build_cpu_s"),
            (theirs, "simd_mrays"),
            (row, "sse42_mrays"),
            (theirs, "scalar_mrays"),
            (row, "scalar_mrays"),
            (row, "best_mrays"),
        ];
        let cells = cells
            .map(|(from, name)| from[name].as_f64().map_or("-".into(), |x| format!("{x:.3}")))
            .join(" | ");
        let _ = writeln!(table, "| {} ({}) | {cells} |", name(row), name(theirs));
    }
    table
}

fn pictures(rows: &[Value]) -> String {
    let mut table = String::from(
        "| scene | all, seconds | render alone, seconds | million rays per second | MB of geometry and trees |\n|---|---|---|---|---|\n",
    );
    for row in rows {
        let memory = number(&row["world"], "array_bytes") + number(&row["world"], "tree_bytes");
        let [all, alone] = ["total", "render"].map(|name| number(&row["seconds"], name));
        let _ = writeln!(
            table,
            "| `{}` | {all:.1} | {alone:.1} | {:.2} | {:.1} |",
            row["scene"].as_str().unwrap_or("-"),
            number(&row["rays"], "per_second") / 1e6,
            memory / 1e6,
        );
    }
    table
}

fn compile(rows: &[Value]) -> String {
    let seconds = rows.first().map_or(f64::NAN, |row| number(row, "seconds"));
    format!("{seconds:.0} s, the picture included; dependencies were downloaded before.\n")
}

fn lines(rows: &[Value]) -> String {
    let text: Vec<_> = rows.iter().filter_map(Value::as_str).collect();
    format!(
        "Relative mean square error (without the worst thousandth; worst tile).\n\n```text\n{}\n```\n",
        text.join("\n")
    )
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::{all, mean};

    #[test]
    fn ratios_have_the_geometric_mean_and_the_least() {
        assert_eq!(mean(&[2.0, 8.0]), "4.00 (2.00)");
        assert_eq!(mean(&[]), "-");
    }

    #[test]
    fn fastest_modes_are_compared_scene_by_scene() {
        let row = |scene: &str, engine: &str, mode: &str, rate: f64| json!({ "class": "ao", "scene": scene, "engine": engine, "mode": mode, "mrays_cpu": rate });
        let numbers = [
            row("a", "gnurt", "bvh-medium", 3.0),
            row("a", "gnurt", "bvh-high", 4.0),
            row("a", "embree4", "medium", 2.0),
            row("a", "embree4", "robust", 1.0),
            row("b", "gnurt", "bvh-high", 8.0),
            row("b", "embree4", "robust-16", 1.0),
        ];
        let document =
            json!({ "machine": {}, "rows": { "rays": { "command": "bench", "numbers": numbers } } });
        let page = all(&document, "x.json");
        assert!(page.contains("| ao | 4.00 (2.00) | 5.66 (4.00) |"), "{page}");
        assert!(!page.contains("### Builds"));
    }
}
