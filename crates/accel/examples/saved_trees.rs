// SPDX-License-Identifier: GPL-3.0-or-later
//! Writes saved trees of every kind, for `fuzz/` to start `accel_tree` from.
//! Run: `cargo run -p gnurt-accel --example saved_trees -- FOLDER`.
//! Each holds few triangles, so that most changes meet something that counts.

use gnurt_accel::{
    BuildOptions, Geometry, Memory, ObjectTree, Quads, Quality, Spheres, Structure, Threads, TriangleTest,
    Triangles,
};
use gnurt_testkit::{Soup, closed};

fn main() -> std::io::Result<()> {
    let folder =
        std::env::args().nth(1).ok_or_else(|| std::io::Error::other("which folder are they for?"))?;
    std::fs::create_dir_all(&folder)?;
    let bvh = |quality, memory| BuildOptions {
        structure: Structure::Bvh,
        quality,
        memory,
        ..BuildOptions::default()
    };
    let kd =
        |triangle_test| BuildOptions { structure: Structure::Kd, triangle_test, ..BuildOptions::default() };
    let kinds = [
        ("bvh", bvh(Quality::Medium, Memory::Fast)),
        ("bvh-high", bvh(Quality::High, Memory::Fast)),
        ("compact", bvh(Quality::Medium, Memory::Compact)),
        ("compact-high", bvh(Quality::High, Memory::Compact)),
        ("kd", kd(TriangleTest::Watertight)),
        ("kd-projected", kd(TriangleTest::Projected)),
    ];
    let meshes = [("cube", closed::cube(1)), ("torus", closed::torus(5)), ("soup", Soup::degenerate(2, 60))];
    for (kind, options) in kinds {
        let write = |name: &str, geometries: &[Geometry]| {
            let tree = ObjectTree::build_from(geometries, &options, Threads::Single);
            let mut file = Vec::new();
            tree.save(&mut file)?;
            std::fs::write(format!("{folder}/{kind}-{name}"), file)
        };
        for (name, mesh) in &meshes {
            write(name, &[Triangles { positions: &mesh.positions, indices: &mesh.indices }.into()])?;
        }
        let corners = [[-1.0, -1.0, 0.5], [1.0, -1.0, 0.5], [1.0, 1.0, 0.5], [-1.0, 1.0, 0.5]];
        let quads = Quads { positions: &corners, indices: &[[0, 1, 2, 3]] };
        let centers: Vec<[f32; 3]> = (0..12).map(|i| [i, i % 3, i % 5].map(|x| 0.25 * x as f32)).collect();
        let spheres = Spheres { centers: &centers, radii: &[0.125; 12] };
        write("mixed", &[quads.into(), spheres.into()])?;
        write("empty", &[])?;
    }
    Ok(())
}
