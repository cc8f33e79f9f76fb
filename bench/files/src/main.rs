// SPDX-License-Identifier: GPL-3.0-or-later
//! `gnurt-bench-files READER FILE COUNT`: the seconds of each reading of a file, and the number of triangles.
//! READER is `gnurt` or `tobj`; `convert FILE OUT` converts instead. `compare.py` runs it beside other readers.

use std::error::Error;
use std::time::Instant;

use gnurt_scene::io::{FORMATS, Formats, LoadOptions};

const ALL: Formats = FORMATS.with(&[&gnurt_usd::FORMAT]);

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [reader, file, count] = &arguments[..] else { return Err("READER FILE COUNT".into()) };
    if reader == "convert" {
        ALL.save(&ALL.load(file, &LoadOptions::default())?.scene, count)?;
        return Ok(());
    }
    for _ in 0..count.parse::<u32>()? {
        let begin = Instant::now();
        let triangles = match &reader[..] {
            "gnurt" => {
                let loaded = ALL.load(file, &LoadOptions::default())?;
                loaded.scene.meshes().iter().map(|mesh| mesh.primitive_count()).sum::<usize>()
            }
            "tobj" => {
                let (models, _) = tobj::load_obj(file, &tobj::GPU_LOAD_OPTIONS)?;
                models.iter().map(|model| model.mesh.indices.len() / 3).sum()
            }
            _ => return Err("unknown reader".into()),
        };
        println!("{:.6} {triangles}", begin.elapsed().as_secs_f64());
    }
    Ok(())
}
