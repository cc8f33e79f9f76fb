// SPDX-License-Identifier: GPL-3.0-or-later
//! Exceptions of C++ programs and plugins: those of a program's own function come to its own handler, those of plugins
//! become errors.
#![cfg(all(target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64")))]

mod common;

use std::process::Command;

use common::{Workshop, source};

#[test]
fn programs_see_their_own_and_plugins_become_errors() {
    let workshop = Workshop::new();
    for (name, flags) in [("throwing.so", &[][..]), ("throwing_module.so", &["-DMODULE_THROWS"])] {
        let output = Command::new("c++")
            .args(["-std=c++11", "-pedantic", "-Wall", "-Wextra", "-Werror", "-O2", "-shared", "-fPIC"])
            .args(flags)
            .arg("-I")
            .arg(source("include"))
            .arg(source("tests/plugins/throwing.cpp"))
            .arg("-o")
            .arg(workshop.path(name))
            .output()
            .expect("c++ must be there to build plugins");
        assert!(output.status.success(), "{name}:\n{}", String::from_utf8_lossy(&output.stderr));
    }
    let binary = workshop.build("c++", "c++11", &source("tests/c/exceptions.cpp"));
    let output = Command::new(&binary).current_dir(workshop.path("")).output().expect("it runs");
    let [message, reported] = [&output.stdout, &output.stderr].map(|text| String::from_utf8_lossy(text));
    assert!(output.status.success(), "{}\n{message}{reported}", output.status);
    assert!(reported.contains("an exception left its fini"), "nobody else is told:\n{reported}");
}
