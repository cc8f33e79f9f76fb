// SPDX-License-Identifier: GPL-3.0-or-later
//! Other crates on the rays of `gnurt bench rays`: obvhs, parry3d, bvh and tinybvh-rs, compared with ours.
//! Run in this folder: `cargo run --release -- scene.obj [--class primary,ao] [--json FILE]`.
//! One thread; one ray per call, which is all that these crates offer. Their triangle tests are not watertight, so one
//! ray in a thousand may differ before a run is refused.
#![allow(clippy::print_stdout, reason = "printing is what it is for")]

mod bvh;
mod obvhs;
mod one_by_one;
mod parry;
#[cfg(feature = "tinybvh")]
mod tinybvh;

use std::path::{Path, PathBuf};

use clap::Parser;
use gnurt_bench::rays::{BenchEvent, Options};
use gnurt_bench::{Class, Contestant, EmbreeLibrary, Filter, Subject, rays, table, to_json};

#[derive(Parser)]
#[command(about = "Other crates on the rays of `gnurt bench rays`")]
struct Arguments {
    /// Scene files, or builtin:NAME
    #[arg(required = true)]
    scenes: Vec<String>,
    /// Classes of rays; all if none is named
    #[arg(long, value_delimiter = ',')]
    class: Vec<String>,
    /// Parts of names of our modes and Embree's
    #[arg(long, value_delimiter = ',', default_value = "bvh-medium,bvh-high,robust-1")]
    mode: Vec<String>,
    /// Columns and rows of primary rays
    #[arg(long, default_value_t = 1024)]
    size: u32,
    /// Runs of each
    #[arg(long, default_value_t = 5)]
    rounds: usize,
    /// Where the numbers go
    #[arg(long)]
    json: Option<PathBuf>,
}

/// All crates, built over one scene.
fn contestants(subject: &Subject) -> Vec<Contestant<'static>> {
    let mut all = vec![parry::contestant(subject), bvh::contestant(subject)];
    all.extend(obvhs::contestants(subject));
    #[cfg(feature = "tinybvh")]
    all.extend(tinybvh::contestants(subject));
    all
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments = Arguments::parse();
    let mut classes = Vec::new();
    for name in &arguments.class {
        let known = Class::ALL.into_iter().find(|class| class.name() == name);
        classes.push(known.ok_or_else(|| format!("unknown class of rays '{name}'"))?);
    }
    let options = Options {
        classes: if classes.is_empty() { Class::ALL.to_vec() } else { classes },
        filter: Filter { engines: Vec::new(), modes: arguments.mode },
        size: arguments.size,
        rounds: arguments.rounds,
        tolerance: 1e-3,
        ..Options::default()
    };
    let embree = match std::env::var_os("EMBREE4_LIB") {
        Some(file) => Some(EmbreeLibrary::open(Path::new(&file))?),
        None => None,
    };
    let pool = gnurt::thread_pool(0)?;
    let mut rows = Vec::new();
    for scene in &arguments.scenes {
        let name = Path::new(scene).file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let subject = Subject::new(name.trim_start_matches("builtin:"), &gnurt::load_scene(scene)?.scene);
        let mut tell = |news: BenchEvent| match news {
            BenchEvent::Built(_) => {}
            BenchEvent::Differs(what) => eprintln!("note: {what}"),
            BenchEvent::Class(rows) => println!("{}", table::of_class(rows)),
        };
        let others = contestants(&subject);
        rows.extend(rays::run(&subject, &options, embree.as_ref(), others, &pool, &mut tell)?);
    }
    if let Some(file) = arguments.json {
        std::fs::write(file, to_json(&rows).to_string())?;
    }
    println!("{}", table::summary(&rows));
    Ok(())
}
