// SPDX-License-Identifier: GPL-3.0-or-later
//! Builds a tree over the meshes of PLY files and traces camera-like rays: the numbers of docs/explanation/kernels.md.
//! Run: `cargo run --release -p gnurt-accel --example measure -- 0,0,5 0,0,0 0,1,0 40 mesh.ply...`
//! (eye, target, up, vertical field of view in degrees; binary little-endian PLY of triangles, float positions first).
#![allow(clippy::print_stdout, reason = "printing is what it is for")]

use std::time::Instant;

use gnurt_accel::{
    BuildOptions, Coherence, HitBatch, Level, ObjectTree, Query, Ray, RayBatch, Record, Threads,
    TriangleTest, Triangles,
};

struct Mesh {
    positions: Vec<[f32; 3]>,
    indices: Vec<[u32; 3]>,
}

/// Reads only the layout of the benchmark scenes, and reports the expected layout for other files.
fn read_ply(path: &str) -> Result<Mesh, String> {
    let bytes = std::fs::read(path).map_err(|error| format!("{path}: {error}"))?;
    let end = bytes.windows(11).position(|w| w == b"end_header\n").ok_or("no end of header")? + 11;
    let header = String::from_utf8_lossy(&bytes[..end]).into_owned();
    let count = |what: &str| -> Result<usize, String> {
        let line = header.lines().find(|line| line.starts_with(&format!("element {what} ")));
        line.and_then(|line| line.rsplit(' ').next()?.parse().ok()).ok_or(format!("{path}: no {what} count"))
    };
    let before_faces = header.split("element face").next().unwrap_or("");
    let floats = before_faces.lines().filter(|line| line.starts_with("property float")).count();
    let (vertices, faces) = (count("vertex")?, count("face")?);
    let number =
        |at: usize| bytes.get(at..at + 4).map(|b| [b[0], b[1], b[2], b[3]]).ok_or(format!("{path}: short"));
    let mut mesh = Mesh { positions: Vec::with_capacity(vertices), indices: Vec::with_capacity(faces) };
    for i in 0..vertices {
        let at = end + i * floats * 4;
        let float = |k: usize| number(at + 4 * k).map(f32::from_le_bytes);
        mesh.positions.push([float(0)?, float(1)?, float(2)?]);
    }
    let mut at = end + vertices * floats * 4;
    for _ in 0..faces {
        let corners = *bytes.get(at).ok_or("short")? as usize;
        let corner = |k: usize| number(at + 1 + 4 * k).map(u32::from_le_bytes);
        for k in 2..corners {
            mesh.indices.push([corner(0)?, corner(k - 1)?, corner(k)?]);
        }
        at += 1 + 4 * corners;
    }
    Ok(mesh)
}

fn vector(text: &str) -> Result<[f32; 3], String> {
    let numbers: Vec<f32> = text.split(',').filter_map(|x| x.parse().ok()).collect();
    numbers.try_into().map_err(|_| format!("'{text}' is not x,y,z"))
}

/// Rays through the pixels of a square picture, in blocks of 4 x 2.
fn camera_rays([eye, target, up]: [[f32; 3]; 3], fov: f32, size: u32) -> RayBatch {
    let minus = |a: [f32; 3], b: [f32; 3]| [0, 1, 2].map(|k| a[k] - b[k]);
    let cross = |a: [f32; 3], b: [f32; 3]| {
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    };
    let unit = |a: [f32; 3]| a.map(|x| x / a.iter().map(|x| x * x).sum::<f32>().sqrt());
    let forward = unit(minus(target, eye));
    let right = unit(cross(forward, up));
    let above = cross(right, forward);
    let half = (fov.to_radians() / 2.0).tan();
    let mut rays = RayBatch::with_capacity((size * size) as usize);
    for block in 0..size * size / 8 {
        let (bx, by) = (4 * (block % (size / 4)), 2 * (block / (size / 4)));
        for lane in 0..8 {
            let (x, y) = (bx + lane % 4, by + lane / 4);
            let sx = half * (2.0 * (x as f32 + 0.5) / size as f32 - 1.0);
            let sy = half * (1.0 - 2.0 * (y as f32 + 0.5) / size as f32);
            rays.push(Ray::new(eye, [0, 1, 2].map(|k| forward[k] + sx * right[k] + sy * above[k])));
        }
    }
    rays
}

/// Processor seconds of this thread and peak memory of the process, if known.
fn cpu_and_peak() -> (f64, f64) {
    let stat = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    let nanoseconds = stat.split(' ').next().and_then(|n| n.parse::<f64>().ok()).unwrap_or(0.0);
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let peak =
        status.lines().find_map(|line| line.strip_prefix("VmHWM:")?.trim().split(' ').next()?.parse().ok());
    (nanoseconds / 1e9, peak.unwrap_or(0.0) / 1024.0)
}

/// Processor seconds of all threads of the process, in steps of a hundredth; other processes are excluded.
fn process_cpu() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let after_name = stat.rsplit(')').next().unwrap_or("");
    after_name.split_whitespace().skip(11).take(2).filter_map(|ticks| ticks.parse::<f64>().ok()).sum::<f64>()
        / 100.0
}

fn main() -> Result<(), String> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [eye, target, up, fov, files @ ..] = &arguments[..] else {
        return Err("arguments: eye target up fov file.ply...".into());
    };
    let view = [vector(eye)?, vector(target)?, vector(up)?];
    let fov = fov.parse().map_err(|_| "the field of view is a number")?;
    let meshes: Vec<Mesh> = files.iter().map(|file| read_ply(file)).collect::<Result<_, _>>()?;
    let triangles: Vec<Triangles> =
        meshes.iter().map(|m| Triangles { positions: &m.positions, indices: &m.indices }).collect();
    let arrays: usize = meshes.iter().map(|m| 12 * (m.positions.len() + m.indices.len())).sum();
    let rays = camera_rays(view, fov, 512);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().map_err(|error| error.to_string())?;

    let costs: Vec<f32> = match std::env::var("TRIANGLE_COSTS") {
        Ok(list) => list.split(',').filter_map(|c| c.parse().ok()).collect(),
        Err(_) => vec![BuildOptions::default().triangle_cost],
    };
    println!("arrays {:.1} MB, process before the build {:.1} MB", arrays as f64 / 1e6, cpu_and_peak().1);
    for triangle_test in [TriangleTest::Watertight, TriangleTest::Projected] {
        for &triangle_cost in &costs {
            let options = BuildOptions { triangle_test, triangle_cost, ..BuildOptions::default() };
            let (start, cpu) = (Instant::now(), process_cpu());
            let object = ObjectTree::build(&triangles, &options, Threads::Pool(&pool));
            let (wall, cpu) = (start.elapsed().as_secs_f64(), process_cpu() - cpu);
            let stats = object.stats();
            println!(
                "\n{triangle_test:?}, triangle cost {triangle_cost}: {wall:.2} s by 2 threads, {cpu:.2} s of CPU time, peak {:.0} MB",
                cpu_and_peak().1
            );
            println!("  {stats:?}");
            let single = Query { level: Level::Scalar, ..Query::default() };
            let packets = Level::available().into_iter().map(|level| Query {
                level,
                coherence: Coherence::Coherent,
                ..Query::default()
            });
            for query in std::iter::once(single).chain(packets) {
                let (mut hits, mut record) = (HitBatch::default(), Record::default());
                let mut seconds = f64::INFINITY;
                for _ in 0..3 {
                    record = Record::default();
                    let start = cpu_and_peak().0;
                    object.intersect_batch(&query, &rays, &mut hits, &mut record);
                    seconds = seconds.min(cpu_and_peak().0 - start);
                }
                let n = rays.len() as f64;
                let name = if query.coherence == Coherence::Coherent { query.level.name() } else { "single" };
                let found = (0..hits.len()).filter(|&i| hits.get(i).is_some()).count();
                println!(
                    "  {name:8} {:6.2} Mrays/s of CPU time, {found} hits, {:.1} nodes and {:.1} triangles per ray",
                    n / seconds / 1e6,
                    record.counters.nodes as f64 / n,
                    record.counters.triangles as f64 / n
                );
            }
        }
    }
    Ok(())
}
