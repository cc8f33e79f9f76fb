// SPDX-License-Identifier: GPL-3.0-or-later
//! Shader plugins in C, C++ and Rust: built by their compilers, found, loaded, refused, shading, failing. Programs run in the
//! folder that the plugins are in.

mod common;

use std::path::{Path, PathBuf};
use std::process::Command;

use common::{Workshop, source};

fn must(command: &mut Command) -> String {
    let output = command.output().unwrap_or_else(|error| panic!("{command:?} must be there: {error}"));
    let [out, err] = [&output.stdout, &output.stderr].map(|text| String::from_utf8_lossy(text).into_owned());
    assert!(output.status.success(), "{command:?}: {}\n{out}{err}", output.status);
    out + &err
}

/// Builds a plugin in the workshop, with warnings as errors.
fn plugin(workshop: &Workshop, from: &str, name: &str, flags: &[&str]) -> PathBuf {
    let file = workshop.path(name);
    let (compiler, standard) =
        if from.ends_with(".cpp") { ("c++", "-std=c++11") } else { ("cc", "-std=c99") };
    must(
        Command::new(compiler)
            .args([standard, "-pedantic", "-Wall", "-Wextra", "-Werror", "-O3", "-shared", "-fPIC"])
            .args(flags)
            .arg("-I")
            .arg(source("include"))
            .arg(source(from))
            .args(["-lm", "-o"])
            .arg(&file),
    );
    file
}

/// Builds the example in Rust as its README does, without cargo: it has no dependencies.
fn rust_plugin(workshop: &Workshop) {
    let rustc = std::env::var("RUSTC").unwrap_or_else(|_| "rustc".to_owned());
    must(
        Command::new(rustc)
            .args(["--edition=2024", "--crate-type=cdylib", "--crate-name=stripes", "-O", "-Cpanic=abort"])
            .arg(source("../../examples/plugins/rust/src/lib.rs"))
            .arg("-o")
            .arg(workshop.path("stripes.so")),
    );
}

fn program(workshop: &Workshop, name: &str) -> PathBuf {
    workshop.build("cc", "c99", &source("tests/c").join(name))
}

/// A program of the workshop, to be run in it.
fn in_workshop(workshop: &Workshop, binary: &Path) -> Command {
    let mut command = Command::new(binary);
    command.current_dir(workshop.path("")).env_remove("OPENRT_SHADER_PATH");
    command
}

/// Figure 1 of [SIP06] loads shader.so from the working directory and draws the same as the built-in class,
/// bit for bit.
#[test]
fn figure1_loads_its_shader() {
    let workshop = Workshop::new();
    plugin(&workshop, "../../examples/plugins/c/shader.c", "shader.so", &[]);
    let built_in = program(&workshop, "figure1.c");
    must(in_workshop(&workshop, &built_in).args(["7", "built_in.ppm"]));
    let source_text = std::fs::read_to_string(source("tests/c/figure1.c")).expect("the program");
    let with_plugin = workshop.path("figure1_plugin.c");
    let text = source_text.replace("#define SHADER_FILE NULL", "#define SHADER_FILE \"shader.so\"");
    std::fs::write(&with_plugin, text).expect("the workshop can be written");
    std::fs::copy(source("tests/c/check.h"), workshop.path("check.h")).expect("the header is there");
    let binary = workshop.build("cc", "c99", &with_plugin);
    must(in_workshop(&workshop, &binary).args(["7", "plugin.ppm"]));
    let [a, b] =
        ["built_in.ppm", "plugin.ppm"].map(|name| std::fs::read(workshop.path(name)).expect("a picture"));
    assert!(a == b, "the plugin's picture is the built-in class's");
}

/// The search path of files, and the messages for missing ones.
#[test]
fn search() {
    let workshop = Workshop::new();
    let binary = program(&workshop, "plugin_load.c");
    let load = |arguments: &[&str], path: &str| {
        must(in_workshop(&workshop, &binary).args(arguments).env("OPENRT_SHADER_PATH", path));
    };
    for part in ["\"missing.so\"", "./missing.so", "system's loader", "/nowhere/missing.so"] {
        load(&["broken", "missing.so", "value", part], "/nowhere");
    }
    load(&["broken", "/nowhere/x.so", "value", "/nowhere/x.so"], "");
    let folder = workshop.path("folder");
    std::fs::create_dir(&folder).expect("it is new");
    let path = folder.display().to_string();
    std::fs::rename(plugin(&workshop, "tests/plugins/broken.c", "x.so", &[]), folder.join("x.so"))
        .expect("one disk");
    load(&["broken", "x.so", "value", "cannot find"], "/nowhere");
    load(&["broken", "x.so", "none"], &format!("/nowhere:{path}"));
    load(&["broken", "folder/x.so", "none"], "");
    load(&["broken", &format!("{path}/x.so"), "none"], "");
    // A file that is no library is not passed over in favour of another.
    std::fs::write(workshop.path("y.so"), "no library").expect("the workshop can be written");
    std::fs::copy(folder.join("x.so"), folder.join("y.so")).expect("one disk");
    load(&["broken", "y.so", "none"], &path);
    load(&["broken", "y.so", "value", "./y.so"], "/nowhere");
    // The loader's own list comes before the working directory.
    must(
        in_workshop(&workshop, &binary)
            .args(["broken", "y.so", "none"])
            .env("LD_LIBRARY_PATH", format!("{path}:{}", workshop.path("").display())),
    );
}

/// Every rule that a module can break is noticed when it is loaded.
#[test]
fn broken_modules() {
    let workshop = Workshop::new();
    let binary = program(&workshop, "plugin_load.c");
    let cases: &[(u32, &str, &str)] = &[
        (0, "none", ""),
        (1, "operation", "parameter 0: it has no name"),
        (2, "operation", "parameter 0: it has no name"),
        (3, "operation", "its type 0x1407"),
        (4, "operation", "its type 0x4d"),
        (5, "operation", "its count is 0"),
        (6, "operation", "it ends at byte 8 of a block of 4"),
        (7, "operation", "its rate 0x503"),
        (8, "operation", "`illuminate` is NULL"),
        (9, "operation", "it ends at byte 4294967299"),
        (10, "operation", "there are two \"first\""),
        (11, "operation", "texts are per shader only"),
        (12, "operation", "struct_size 40"),
        (13, "operation", "RT_RENDERING_OBJECT"),
        (14, "operation", "its kind 0x5"),
        (15, "operation", "its flags are 0x1"),
        (16, "operation", "too large"),
        (17, "operation", "shader_align is 24"),
        (18, "operation", "shader_align is 8192"),
        (19, "operation", "4294967295 parameters"),
        (20, "operation", "2 parameters"),
        (21, "operation", "`shade` is NULL"),
        (22, "value", "exports no function rts_module"),
        (23, "operation", "RTSmodule has struct_size 8"),
        (24, "operation", "version 2.0"),
        (25, "none", ""),
        (26, "value", "it has no classes"),
        (27, "value", "it has no classes"),
        (28, "operation", "does not work with version 1.1"),
    ];
    for (case, outcome, part) in cases {
        let name = format!("./broken{case}.so");
        plugin(&workshop, "tests/plugins/broken.c", &name[2..], &["-O1", &format!("-DCASE={case}")]);
        must(in_workshop(&workshop, &binary).args(["broken", &name, outcome, part]));
        if *outcome == "operation" && *case < 22 {
            // The other class of the library has nothing to do with it.
            must(in_workshop(&workshop, &binary).args(["sound", &name, "none"]));
        }
    }
    must(in_workshop(&workshop, &binary).args([
        "borken",
        "./broken0.so",
        "value",
        "did you mean \"broken\"?",
    ]));
}

/// `prepare` that fails or crashes, results that are none: the frame goes on.
#[test]
fn faults() {
    let workshop = Workshop::new();
    plugin(&workshop, "tests/plugins/tricky.c", "tricky.so", &[]);
    let message = must(&mut in_workshop(&workshop, &program(&workshop, "plugin_faults.c")));
    let lines =
        message.lines().filter(|line| line.contains("32 results not written, NaN or infinite")).count();
    assert!(lines > 0, "what is wrong is printed:\n{message}");
}

/// The standard error output is closed and its signal is ignored: no call ends the program.
#[test]
fn a_closed_error_output_ends_nothing() {
    let workshop = Workshop::new();
    plugin(&workshop, "tests/plugins/tricky.c", "tricky.so", &[]);
    program(&workshop, "quiet.c");
    // The shell ignores the signal for itself and for the program; `true` ends, and the pipe breaks.
    let script = "trap '' PIPE; { sleep 0.2; ./quiet 2>&1 >said; echo status $? >status; } | true";
    let mut shell = Command::new("sh");
    shell.args(["-c", script]).current_dir(workshop.path("")).env("OPENRT_DEBUG", "1");
    must(&mut shell);
    let read = |name: &str| std::fs::read_to_string(workshop.path(name)).expect("the program has ended");
    let (status, message) = (read("status"), read("said"));
    assert_eq!(status, "status 0\n", "no panic, no abort, and its checks hold:\n{message}");
    // The same without any standard error output at all.
    must(
        in_workshop(&workshop, Path::new("/bin/sh"))
            .args(["-c", "exec 2>&-; ./quiet"])
            .env("OPENRT_DEBUG", "1"),
    );
}

/// Shaders that take much of the stack for themselves, in a hall of mirrors: rays end with words, not with a crash.
#[test]
fn deep_shaders_are_stopped() {
    let workshop = Workshop::new();
    plugin(&workshop, "tests/plugins/deep.c", "deep.so", &[]);
    must(&mut in_workshop(&workshop, &program(&workshop, "plugin_deep.c")));
}

/// Cameras get places on their lens; those of version 1.0 of the interface work as before.
#[test]
fn cameras_with_a_lens() {
    let workshop = Workshop::new();
    plugin(&workshop, "tests/plugins/lens.c", "lens.so", &[]);
    must(&mut in_workshop(&workshop, &program(&workshop, "plugin_lens.c")));
}

/// The third and the fourth texture coordinate reach shaders.
#[test]
fn texture_coordinates() {
    let workshop = Workshop::new();
    plugin(&workshop, "tests/plugins/texcoords.c", "texcoords.so", &[]);
    must(&mut in_workshop(&workshop, &program(&workshop, "plugin_texcoords.c")));
}

/// Batches, parameters of all types and rates, and services are as the header says.
#[test]
fn probe() {
    let workshop = Workshop::new();
    plugin(&workshop, "tests/plugins/tricky.c", "tricky.so", &[]);
    must(&mut in_workshop(&workshop, &program(&workshop, "plugin_probe.c")));
}

/// The threads that run a plugin's functions, and the services' rejections.
#[test]
fn calls() {
    let workshop = Workshop::new();
    plugin(&workshop, "tests/plugins/calls.c", "calls.so", &["-pthread"]);
    must(&mut in_workshop(&workshop, &program(&workshop, "plugin_calls.c")));
}

/// Plugins in three languages beside built-in classes: the same pictures.
#[test]
fn languages() {
    let workshop = Workshop::new();
    for (from, name) in
        [("c/diffuse.c", "diffuse.so"), ("c/studio.c", "studio.so"), ("cpp/chrome.cpp", "chrome.so")]
    {
        plugin(&workshop, &format!("../../examples/plugins/{from}"), name, &[]);
    }
    rust_plugin(&workshop);
    let binary = program(&workshop, "plugin_languages.c");
    must(&mut in_workshop(&workshop, &binary));
}

/// A program with plugins in three languages, and one that makes every error, leave no memory behind. Memory
/// of a pool's thread that ends shortly after the program is "possibly lost" to valgrind and does not count.
#[test]
#[ignore = "wants valgrind and a minute"]
fn nothing_leaks() {
    if Command::new("valgrind").arg("--version").output().is_err() {
        eprintln!("SKIPPED: valgrind is missing");
        return;
    }
    let workshop = Workshop::new();
    for (from, name) in
        [("c/diffuse.c", "diffuse.so"), ("c/studio.c", "studio.so"), ("cpp/chrome.cpp", "chrome.so")]
    {
        plugin(&workshop, &format!("../../examples/plugins/{from}"), name, &[]);
    }
    rust_plugin(&workshop);
    for name in ["plugin_languages.c", "errors.c"] {
        let binary = program(&workshop, name);
        let kinds = "--errors-for-leak-kinds=definite,indirect";
        must(
            Command::new("valgrind")
                .current_dir(workshop.path(""))
                .args(["-q", "--leak-check=full", "--show-leak-kinds=definite,indirect", kinds])
                .arg("--error-exitcode=9")
                .arg(&binary),
        );
    }
}

/// Rendering objects choose integrator and samples.
#[test]
fn rendering_objects() {
    let workshop = Workshop::new();
    must(&mut in_workshop(&workshop, &program(&workshop, "rendering_objects.c")));
}

/// Shaders that loop over lights meet virtual ones among them: the picture is that of a material.
#[test]
fn virtual_lights() {
    let workshop = Workshop::new();
    plugin(&workshop, "../../examples/plugins/c/diffuse.c", "diffuse.so", &[]);
    must(&mut in_workshop(&workshop, &program(&workshop, "virtual_lights.c")));
}

/// The header compiles in every dialect that may include it, alone; its structures have the layout that we read.
#[test]
fn dialects() {
    let workshop = Workshop::new();
    let layout = source("tests/plugins/layout.c");
    for standard in ["c99", "c11", "c17"] {
        let binary = workshop.build("cc", standard, &layout);
        workshop.run(&binary, &[]);
    }
    let as_cpp = workshop.path("layout.cpp");
    std::fs::copy(&layout, &as_cpp).expect("the workshop can be written");
    for standard in ["c++11", "c++14", "c++17", "c++20"] {
        let binary = workshop.build("c++", standard, &as_cpp);
        workshop.run(&binary, &[]);
    }
}
