// SPDX-License-Identifier: GPL-3.0-or-later
//! The rows of results and the commands that measure them; each returns the command and the JSON that it wrote.
//! Tests: `cargo xtask results SCENES --quick --busy` runs all of them in about two minutes.

use std::path::PathBuf;
use std::process::Command;
use std::time::Instant;

use serde_json::{Value, json};

use crate::command;
use crate::failure::Failure;

/// Where programs and files are.
pub(super) struct Setting {
    pub(super) program: PathBuf,
    pub(super) scenes: PathBuf,
    pub(super) work: PathBuf,
    pub(super) quick: bool,
}

/// One table of results.
pub(super) struct Row {
    pub(super) name: &'static str,
    /// Only with --all.
    pub(super) long: bool,
    pub(super) measure: fn(&Setting) -> Result<Value, Failure>,
}

pub(super) const ROWS: [Row; 7] = [
    Row { name: "rays", long: false, measure: rays },
    Row { name: "builds", long: false, measure: builds },
    Row { name: "moving", long: false, measure: moving },
    Row { name: "paper", long: false, measure: paper },
    Row { name: "pictures", long: false, measure: pictures },
    Row { name: "denoise", long: true, measure: denoise },
    Row { name: "compile", long: true, measure: compile },
];

fn rays(setting: &Setting) -> Result<Value, Failure> {
    embree()?;
    let (size, rounds) = if setting.quick { ("64", "1") } else { ("256", "3") };
    let options = ["rays", "-t", "1", "--size", size, "--rounds", rounds];
    setting.bench(&options, &["conference", "dragon", "sponza", "office", "soda", "buddha-100k"])
}

fn builds(setting: &Setting) -> Result<Value, Failure> {
    embree()?;
    let rounds = if setting.quick { "1" } else { "3" };
    let options = ["build", "-t", "1", "--mode", "bvh-medium,bvh-high,medium,high", "--rounds", rounds];
    setting.bench(&options, &["conference", "dragon", "sponza", "buddha-100k"])
}

fn moving(setting: &Setting) -> Result<Value, Failure> {
    if let Err(reason) = embree() {
        eprintln!("WARNING: Embree is left out: {reason}");
    }
    let frames = if setting.quick { "3" } else { "20" };
    let options =
        ["dynamic", "-t", "1", "--case", "refit", "--frames", frames, "--size", "256", "--rounds", "3"];
    setting.bench(&options, &["conference", "buddha-100k"])
}

fn paper(setting: &Setting) -> Result<Value, Failure> {
    let (size, rounds) = if setting.quick { ("128", "1") } else { ("1024", "3") };
    setting.bench(&["paper", "--size", size, "--rounds", rounds], &["office", "soda", "conference", "dragon"])
}

/// Whole pictures, from the start of the program to the file.
fn pictures(setting: &Setting) -> Result<Value, Failure> {
    let size = if setting.quick { "160x90" } else { "1280x720" };
    let options = ["render", "-q", "-r", size, "--spp", "16", "--stats=json", "-o"];
    let output = setting.work.join("picture.png");
    let mut numbers = Vec::new();
    for scene in ["builtin:cornell", "builtin:spheres", "builtin:island"] {
        let mut render = Command::new(&setting.program);
        let found = render.args(options).arg(&output).arg(scene).output();
        let found = found.map_err(|error| format!("gnurt cannot be run: {error}"))?;
        if !found.status.success() {
            return Err(String::from_utf8_lossy(&found.stderr).trim().to_owned());
        }
        numbers.push(
            serde_json::from_slice::<Value>(&found.stdout).map_err(|error| format!("--stats: {error}"))?,
        );
    }
    Ok(json!({ "command": format!("gnurt {} FILE SCENE", options.join(" ")), "numbers": numbers }))
}

/// The two denoisers, by relative error.
fn denoise(setting: &Setting) -> Result<Value, Failure> {
    if std::env::var_os("OIDN_LIB").is_none() {
        return Err("OIDN_LIB does not name a library of Open Image Denoise".into());
    }
    command::output_of("python3", &["-c", "import numpy, OpenEXR"])?;
    let path = |path: &PathBuf| path.display().to_string();
    let mut arguments = vec!["bench/renderers/denoise.py".to_owned()];
    arguments.extend([path(&setting.program), path(&setting.scenes), path(&setting.work.join("denoise"))]);
    if setting.quick {
        arguments.push("cornell-box".into());
    }
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let text = command::output_of("python3", &arguments)?;
    Ok(json!({
        "command": "bench/renderers/denoise.py gnurt SCENES WORK",
        "numbers": text.lines().collect::<Vec<_>>(),
    }))
}

/// The first command of the README without anything compiled before.
fn compile(setting: &Setting) -> Result<Value, Failure> {
    let folder = setting.work.join("cold");
    if folder.exists() {
        std::fs::remove_dir_all(&folder).map_err(|error| format!("'{}': {error}", folder.display()))?;
    }
    command::run(command::cargo().arg("fetch"))?;
    let arguments = ["run", "--release", "--no-default-features", "--", "render", "builtin:island", "-o"];
    let begin = Instant::now();
    let mut build = command::cargo();
    build.args(arguments).arg(setting.work.join("island.png")).env("CARGO_TARGET_DIR", &folder);
    command::run(&mut build)?;
    let seconds = begin.elapsed().as_secs_f64();
    std::fs::remove_dir_all(&folder).map_err(|error| format!("'{}': {error}", folder.display()))?;
    let command = format!("cargo {} island.png", arguments.join(" "));
    Ok(json!({ "command": command, "numbers": [{ "seconds": seconds }] }))
}

fn embree() -> Result<(), Failure> {
    match std::env::var_os("EMBREE4_LIB") {
        Some(file) if PathBuf::from(&file).is_file() => Ok(()),
        Some(file) => Err(format!("EMBREE4_LIB: no file '{}'", file.display())),
        None => Err("EMBREE4_LIB does not name a library of Embree 4".into()),
    }
}

impl Setting {
    /// Runs `gnurt bench` on scenes of the folder.
    fn bench(&self, options: &[&str], scenes: &[&str]) -> Result<Value, Failure> {
        let name = options.first().copied().unwrap_or("bench");
        let file = self.work.join(format!("{name}.json"));
        let mut bench = Command::new(&self.program);
        bench.arg("bench").args(options).arg("--json").arg(&file);
        for &scene in scenes {
            let path = ["obj", "ply"].map(|kind| self.scenes.join(scene).join(format!("{scene}.{kind}")));
            let path = path.iter().find(|path| path.is_file());
            bench.arg(path.ok_or_else(|| format!("no '{scene}/{scene}.obj' or .ply in SCENES"))?);
        }
        command::run(&mut bench)?;
        let text =
            std::fs::read_to_string(&file).map_err(|error| format!("'{}': {error}", file.display()))?;
        let numbers: Value =
            serde_json::from_str(&text).map_err(|error| format!("'{}': {error}", file.display()))?;
        let command = format!("gnurt bench {} {}", options.join(" "), scenes.join(" "));
        Ok(json!({ "command": command, "numbers": numbers }))
    }
}
