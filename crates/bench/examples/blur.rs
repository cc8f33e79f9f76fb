// SPDX-License-Identifier: GPL-3.0-or-later
//! Rays with times, with Embree's motion blur for comparison, as a table. Run: `EMBREE4_LIB=FILE cargo run
//! --release -p gnurt-bench --example blur -- SCENE [KEYS] [SHARE] [SIZE] [ROUNDS]`; with `instances` for
//! SCENE, KEYS x 1000 instances that rotate by SHARE and move.
#![allow(clippy::print_stdout, reason = "printing is what it is for")]

use std::error::Error;
use std::path::Path;

use gnurt_bench::{EmbreeLibrary, Subject, blur, blur_top};

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let name = arguments.first().map_or("builtin:materials", String::as_str);
    let number = |i: usize, default: f32| arguments.get(i).map_or(Ok(default), |text| text.parse::<f32>());
    let (keys, share, size, rounds) = (number(1, 2.0)?, number(2, 0.1)?, number(3, 512.0)?, number(4, 5.0)?);
    let file = std::env::var_os("EMBREE4_LIB");
    let library = file.map(|file| EmbreeLibrary::open(Path::new(&file))).transpose()?;
    if name == "instances" {
        let count = (1000.0 * number(1, 10.0)?) as usize;
        let rows = blur_top::run(count, number(2, 0.5)?, rounds as usize, library.as_ref())?;
        print(&format!("{count} instances, turned by {}", number(2, 0.5)?), &rows);
        return Ok(());
    }
    let stem = Path::new(name).file_stem().map_or_else(|| name.into(), |stem| stem.to_string_lossy());
    let subject = Subject::new(&stem, &gnurt::load_scene(name)?.scene);
    let rows = blur::run(&subject, keys as usize, share, size as u32, rounds as usize, library.as_ref())?;
    print(&format!("{stem}, {keys} keys, {share}"), &rows);
    Ok(())
}

fn print(what: &str, rows: &[blur::BlurRow]) {
    println!("| {what} | engine | Mrays/s | build s | MB | hits |");
    println!("|---|---|---|---|---|---|");
    for row in rows {
        let bytes = row.bytes.map_or_else(|| "-".into(), |bytes| format!("{:.1}", bytes as f64 / 1e6));
        println!(
            "| {} | {} | {:.3} | {:.3} | {bytes} | {} |",
            row.class, row.engine, row.mrays_cpu, row.build_seconds, row.hits
        );
    }
}
