// SPDX-License-Identifier: GPL-3.0-or-later
//! Runs the programs and checks their output.

use std::process::Command;

fn run(program: &str, arguments: &[&str]) -> String {
    let folder = tempfile::tempdir().expect("a folder for pictures");
    let output =
        Command::new(program).args(arguments).current_dir(folder.path()).output().expect("it starts");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{program} fails: {errors}");
    for picture in arguments.iter().filter(|argument| argument.ends_with(".png")) {
        let picture = gnurt::image::read(&folder.path().join(picture)).expect("the picture is readable");
        let mean = picture.color.iter().map(|c| c[0]).sum::<f32>() / picture.color.len() as f32;
        assert!((0.01..0.95).contains(&mean), "{program}: mean of the red channel {mean}");
    }
    String::from_utf8(output.stdout).expect("text")
}

#[test]
fn pictures_are_written() {
    run(env!("CARGO_BIN_EXE_first_picture"), &["builtin:cornell", "first.png"]);
    run(env!("CARGO_BIN_EXE_own_material"), &["material.png"]);
    run(env!("CARGO_BIN_EXE_own_integrator"), &["integrator.png"]);
}

#[test]
fn ray_queries_print_hits() {
    let expected = "closest hit: t 1.5, geometry 1, primitive 0
blocked within 1.4: false
all hits: [1.5, 2.5, 3.0]
ray 0: t 1.5, instance 0
ray 1: t 3, instance 0
ray 2: t 3, instance 0
ray 3: t 3, instance 1
ray 4: t 1.5, instance 1
ray 5: t 3, instance 1
ray 6: t 3, instance 1
ray 7: miss
";
    assert_eq!(run(env!("CARGO_BIN_EXE_ray_queries"), &[]), expected);
}
