// SPDX-License-Identifier: GPL-3.0-or-later
//! OSL's tools in one small program: called by a link named `oslc`, `oslinfo` or `testshade`, or with that as first word.

use gnurt_sl_shading::StoredTextures;
use gnurt_sl_tools::{Console, tool};
use std::io::{BufWriter, stderr, stdout};

fn main() {
    let mut args: Vec<String> = std::env::args().collect();
    let called = std::path::Path::new(&args[0])
        .file_stem()
        .map_or(String::new(), |s| s.to_string_lossy().into_owned());
    args.remove(0);
    let mut name = called;
    if tool(&name).is_none() && !args.is_empty() {
        name = args.remove(0);
    }
    let (mut out, mut err) = (BufWriter::new(stdout()), stderr());
    let mut console = Console::new(&mut out, &mut err, true);
    console.engine = Some(gnurt_jit::engine);
    let textures = StoredTextures::default();
    console.textures = Some(&textures);
    let status = match tool(&name) {
        Some(run) => run(&args, &mut console),
        None => {
            console.complain("usage: osl oslc|oslinfo|testshade ...\n");
            2
        }
    };
    console.flush();
    drop(out);
    std::process::exit(status);
}
