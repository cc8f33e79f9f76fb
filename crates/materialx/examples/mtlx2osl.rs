// SPDX-License-Identifier: GPL-3.0-or-later
//! Writes a document's material or node in the shading language: `mtlx2osl FILE.mtlx [NODE]`.

use std::path::Path;
use std::process::ExitCode;

use gnurt_materialx::Document;

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1);
    let Some(file) = arguments.next() else {
        eprintln!("usage: mtlx2osl FILE.mtlx [NODE]");
        return ExitCode::from(2);
    };
    let mut load = |path: &Path| std::fs::read_to_string(path).map_err(|error| error.to_string());
    let made = Document::open(Path::new(&file), &mut load).and_then(|document| {
        let node = arguments.next();
        document.shader(node.as_deref())
    });
    match made {
        Ok(shader) => {
            shader.warnings.iter().for_each(|warning| eprintln!("{warning}"));
            #[allow(clippy::print_stdout, reason = "it is a program")]
            {
                print!("{}", shader.text);
            }
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}
