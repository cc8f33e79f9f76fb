// SPDX-License-Identifier: GPL-3.0-or-later
//! The tree over instances, with Embree's for comparison, as a table. Run: `EMBREE4_LIB=FILE cargo run
//! --release -p gnurt-bench --example top -- [INSTANCES] [ROUNDS]`
#![allow(clippy::print_stdout, reason = "printing is what it is for")]

use std::error::Error;
use std::path::Path;

use gnurt_bench::{EmbreeLibrary, top};

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1).map(|count| count.parse::<usize>());
    let count = arguments.next().unwrap_or(Ok(100_000))?;
    let rounds = arguments.next().unwrap_or(Ok(9))?;
    let file = std::env::var_os("EMBREE4_LIB");
    let library = file.map(|file| EmbreeLibrary::open(Path::new(&file))).transpose()?;
    println!("| {count} instances | engine | threads | CPU ms | wall ms | Mrays/s |");
    println!("|---|---|---|---|---|---|");
    for row in top::run(count, rounds, library.as_ref(), &gnurt::thread_pool(2)?)? {
        println!(
            "| {} | {} | {} | {:.2} | {:.2} | {:.3} |",
            row.what, row.engine, row.threads, row.cpu_ms, row.wall_ms, row.mrays_cpu
        );
    }
    Ok(())
}
