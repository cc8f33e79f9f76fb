// SPDX-License-Identifier: GPL-3.0-or-later
//! The static library: one object with everything that the calls of OpenRT reach, and only those calls as
//! symbols. By GNU binutils. Rustc's archive would carry all of the standard library and of every crate (and
//! their code for LLVM), ten times as large, and its symbols would clash with those of another Rust library
//! in the same program.

use std::path::Path;
use std::process::Command;

use super::files;
use crate::command;
use crate::failure::Failure;

/// Its name in the build folder.
pub(super) const NAME: &str = "libOpenRT-static.a";

/// One section of each kind: their thousands of names are a quarter of the file.
const SECTIONS: &str = "SECTIONS
{
  .text 0 : { *(.text .text.*) }
  .rodata 0 : { *(.rodata .rodata.*) }
  .data.rel.ro 0 : { *(.data.rel.ro .data.rel.ro.*) }
  .data 0 : { *(.data .data.*) }
  .tdata 0 : { *(.tdata .tdata.*) }
  .tbss 0 : { *(.tbss .tbss.*) }
  .bss 0 : { *(.bss .bss.*) }
  .gcc_except_table 0 : { *(.gcc_except_table .gcc_except_table.*) }
  .init_array 0 : { KEEP(*(.init_array .init_array.*)) }
  .eh_frame 0 : { KEEP(*(.eh_frame)) }
  .note.GNU-stack 0 : { *(.note.GNU-stack) }
  /DISCARD/ : { *(.llvmbc .llvmcmd .comment) }
}
";

/// Makes the static library in `built`, a folder where cargo has built the package openrt.
pub(super) fn build(built: &Path) -> Result<(), Failure> {
    if !cfg!(target_os = "linux") {
        return Err("--static: the static library can be made on Linux only".into());
    }
    let [whole, object] = ["libOpenRT-whole.a", "libOpenRT-static.o"].map(|name| built.join(name));
    collect(built, &whole)?;
    // The calls of the header are where everything is reached from.
    let header = files::read(&command::root().join("bindings/openrt/include/openrt/rt.h"))?;
    let calls = calls(&header);
    let script = built.join("libOpenRT-static.ld");
    files::write(&script, SECTIONS)?;
    let mut link = Command::new("ld");
    // Groups would be shared with those of another Rust library, whose symbols are not ours.
    link.args(["-r", "--gc-sections", "--force-group-allocation", "-T"]).arg(&script).arg("-o").arg(&object);
    link.args(calls.iter().map(|call| format!("--undefined={call}"))).arg(&whole);
    quietly(&mut link)?;
    let mut hide = Command::new("objcopy");
    hide.arg("--strip-unneeded");
    hide.args(calls.iter().map(|call| format!("--keep-global-symbol={call}")));
    quietly(hide.arg(&object))?;
    let archive = built.join(NAME);
    let _ = std::fs::remove_file(&archive);
    quietly(Command::new("ar").arg("rcsD").arg(&archive).arg(&object))?;
    for file in [whole, object, script] {
        files::remove(&file)?;
    }
    Ok(())
}

/// The archive of everything: a crate that contains only openrt, as it was built. `cargo rustc` would choose
/// the features of libraries for openrt only, which are fewer than those for the program, too, and compile
/// half of the dependencies again.
fn collect(built: &Path, whole: &Path) -> Result<(), Failure> {
    let source = built.join("libOpenRT-whole.rs");
    files::write(&source, "extern crate OpenRT as _;\n")?;
    let dependencies = built.join("deps");
    let openrt = dependencies.join("libOpenRT.rlib");
    let mut rustc = Command::new(std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into()));
    // There the toolchain is chosen that cargo has used.
    rustc.current_dir(command::root());
    rustc.args(["--crate-type=staticlib", "--crate-name=openrt_whole", "--edition=2024", "-Copt-level=2"]);
    rustc.arg("-L").arg(format!("dependency={}", dependencies.display()));
    rustc.arg("--extern").arg(format!("OpenRT={}", openrt.display()));
    quietly(rustc.arg("-o").arg(whole).arg(&source))?;
    files::remove(&source)
}

/// The functions that a header declares.
fn calls(header: &str) -> Vec<String> {
    let name = |rest: &str| rest.split('(').next().unwrap_or_default().trim().to_owned();
    header.split("RTAPIENTRY ").skip(1).map(name).collect()
}

/// Runs a tool whose line would fill pages.
fn quietly(tool: &mut Command) -> Result<(), Failure> {
    let name = tool.get_program().to_string_lossy().into_owned();
    let output = tool.output().map_err(|error| {
        format!("{name} cannot be run: {error}; rustc comes with cargo, the others with binutils")
    })?;
    if output.status.success() {
        return Ok(());
    }
    let output_of = String::from_utf8_lossy(&output.stderr);
    Err(format!("{name} failed: {}", output_of.lines().next().unwrap_or_default()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn calls_are_found() {
        let header =
            "#define A RTAPIENTRY\nRTAPI void RTAPIENTRY rtInit(int *c);\nRTAPI RTuint RTAPIENTRY\nx";
        assert_eq!(calls(&header.replace("A RTAPIENTRY\n", "A\n")), ["rtInit"], "one");
    }
}
