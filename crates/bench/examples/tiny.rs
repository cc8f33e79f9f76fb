// SPDX-License-Identifier: GPL-3.0-or-later
//! Rays through many instances of a triangle and of a box, with Embree's packets for comparison, as a table.
//! Run: `EMBREE4_LIB=FILE cargo run --release -p gnurt-bench --example tiny -- [INSTANCES] [SIZE] [ROUNDS]`
#![allow(clippy::print_stdout, reason = "printing is what it is for")]

use std::error::Error;
use std::path::Path;

use gnurt_bench::{Class, EmbreeLibrary, tiny};

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1).map(|count| count.parse::<usize>());
    let count = arguments.next().unwrap_or(Ok(50_000))?;
    let size = arguments.next().unwrap_or(Ok(256))? as u32;
    let rounds = arguments.next().unwrap_or(Ok(9))?;
    let file = std::env::var_os("EMBREE4_LIB");
    let library = file.map(|file| EmbreeLibrary::open(Path::new(&file))).transpose()?;
    println!("| {count} instances of | rays | engine | mode | Mrays/s |");
    println!("|---|---|---|---|---|");
    for triangles in [1, 12] {
        let rows = tiny::run(&tiny::Options { count, triangles, size, rounds }, library.as_ref())?;
        for row in &rows {
            println!(
                "| {triangles} | {} | {} | {} | {:.3} |",
                row.class, row.engine, row.mode, row.mrays_cpu
            );
        }
        for class in [Class::Primary, Class::Shadow, Class::Diffuse] {
            let best = |engine: &str| {
                let those = rows
                    .iter()
                    .filter(|row| row.class == class && row.engine == engine && row.mode != "mesh");
                those.map(|row| row.mrays_cpu).fold(0.0, f64::max)
            };
            let mesh = rows
                .iter()
                .find(|row| row.class == class && row.mode == "mesh")
                .map_or(0.0, |row| row.mrays_cpu);
            println!(
                "{triangles} triangles, {class}: {:.2} of Embree's best, one mesh is {:.2} times as fast",
                best("gnurt") / best("embree4").max(1e-9),
                mesh / best("gnurt").max(1e-9)
            );
        }
    }
    Ok(())
}
