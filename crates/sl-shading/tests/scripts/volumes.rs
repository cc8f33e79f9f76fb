// SPDX-License-Identifier: GPL-3.0-or-later
//! `texture3d` on a file of OpenVDB's. Its grid "density" holds max (0, 1 - (x^2 + y^2 + z^2) / 90) where
//! |x|, |y| <= 9 and |z| <= 3, rounded to 11 bits; "ball" holds the distances around a ball in rotated and
//! sheared voxels.

use std::io::Read;
use std::path::Path;

use glam::Vec3;
use gnurt_sl::exec::{Subimage, TextureOptions};
use gnurt_sl::stored::Textures;
use gnurt_sl_lib::Dual;
use gnurt_sl_shading::{Access, Script, StoredTextures};

use super::floor::floor;
use super::kinds::emitted;

/// Writes the file, and says where.
fn file(folder: &Path) -> String {
    let packed = &include_bytes!("../../../image/tests/data/grids.vdb.gz")[..];
    let mut bytes = Vec::new();
    flate2::read::GzDecoder::new(packed).read_to_end(&mut bytes).expect("it was packed");
    std::fs::write(folder.join("grids.vdb"), bytes).expect("written");
    folder.join("grids.vdb").to_string_lossy().into_owned()
}

fn of(grid: &str, interpolation: &str, wrap: &str) -> TextureOptions {
    TextureOptions {
        channels: 4,
        subimage: Subimage::Name(grid.into()),
        interpolation: interpolation.into(),
        wrap: std::array::from_fn(|_| wrap.into()),
        ..TextureOptions::default()
    }
}

/// The voxels of "density".
fn fog(voxel: [i32; 3]) -> f32 {
    let [x, y, z] = voxel;
    let inside = x.abs() <= 9 && y.abs() <= 9 && z.abs() <= 3;
    if inside { (1.0 - (x * x + y * y + z * z) as f32 / 90.0).max(0.0) } else { 0.0 }
}

#[test]
fn places_lie_between_eight_voxels() {
    let folder = tempfile::tempdir().expect("a folder");
    let (file, textures) = (file(folder.path()), StoredTextures::default());
    let read = |p: [f32; 3], options: &TextureOptions| {
        textures.texture3d(&file, p.map(Dual::from), options).expect("a volume").map(|x| x.value)
    };
    for p in [[0.0, 0.0, 0.0], [0.25, -3.5, 1.75], [-8.5, 2.0, -2.9], [6.1, 5.2, 3.4], [-9.6, 9.3, 0.0]] {
        let low = p.map(f32::floor);
        let expected: f32 = (0..8)
            .map(|corner| {
                let up: [i32; 3] = std::array::from_fn(|k| corner >> k & 1);
                let along = |k: usize| if up[k] == 1 { p[k] - low[k] } else { 1.0 - p[k] + low[k] };
                along(0) * along(1) * along(2) * fog(std::array::from_fn(|k| low[k] as i32 + up[k]))
            })
            .sum();
        let [r, g, b, a] = read(p, &of("density", "", ""));
        assert!((r - expected).abs() < 1e-3, "{p:?}: {r} and {expected}");
        assert_eq!([g, b, a], [0.0; 3], "one number, and nothing is filled in: as the tools of OSL have it");
        let [closest, ..] = read(p, &of("density", "closest", ""));
        assert!((closest - fog(p.map(|x| (x + 0.5).floor() as i32))).abs() < 1e-3, "{p:?}");
    }
    // The leaves of voxels that are there reach from -16 to 15 and from -8 to 7.
    let filled = TextureOptions { first_channel: 1, fill: 0.5, ..of("density", "", "") };
    assert_eq!(read([2.0, 2.0, 7.0], &filled)[0], 0.5);
    assert_eq!(read([2.0, 2.0, 7.5], &filled)[0], 0.25, "black without");
    assert_eq!(read([2.0, 2.0, 9.0], &filled)[0], 0.0);
    let [inside, ..] = read([2.0, 2.0, 1.0], &of("density", "", ""));
    assert_eq!(read([2.0 + 32.0, 2.0, 1.0 - 16.0], &of("density", "", "periodic"))[0], inside);
    assert_eq!(read([2.0, 2.0, 14.0], &of("density", "", "mirror"))[0], inside, "7.5 - (14 - 7.5)");
    let [grey, color] =
        [[0.0, 0.0, 900.0], [-2049.0 / 4.0, 3.0, 9.0]].map(|p| read(p, &of("Cd", "", "clamp")));
    assert_eq!(color, [1.5, 2.5, 3.5, 0.0], "a tile of three numbers, voxels a quarter long");
    assert_eq!(grey, [0.5, 0.25, -1.0, 0.0], "the background");
}

#[test]
fn changes_are_those_of_values() {
    let folder = tempfile::tempdir().expect("a folder");
    let (file, textures) = (file(folder.path()), StoredTextures::default());
    let direction = Vec3::new(0.02, -0.013, 0.03);
    for p in [Vec3::new(5.78, -3.69, 10.21), Vec3::new(3.21, -3.31, 4.17)] {
        let read = |p: Vec3, direction: Vec3| {
            let at = std::array::from_fn(|k| Dual::new(p[k], direction[k], -2.0 * direction[k]));
            textures.texture3d(&file, at, &of("ball", "", "")).expect("a volume")[0]
        };
        let found = read(p, direction);
        let [before, after] = [p - 0.1 * direction, p + 0.1 * direction].map(|p| read(p, direction).value);
        let slope = (after - before) / 0.2;
        assert!(slope != 0.0 && (found.dx - slope).abs() < 0.02 * slope.abs(), "{} and {slope}", found.dx);
        assert!((found.dy + 2.0 * found.dx).abs() < 1e-5);
    }
}

#[test]
fn shaders_read_volumes_and_are_told_of_what_is_missing() {
    let folder = tempfile::tempdir().expect("a folder");
    file(folder.path());
    let light = |body: &str| {
        let at = folder.path().join("s.osl");
        std::fs::write(&at, format!("surface s () {{ {body} }}")).expect("a shader");
        let made = Script::open(&at, &Access::default()).expect("it compiles");
        let light = emitted(&*made.surface().expect("a surface"), &floor(10))[4];
        (light, made.faults())
    };
    let (shaded, _) = light(
        "Ci = (color) texture3d (\"grids.vdb\", P, \"subimage\", 3) * emission ()
            + color (0, texture3d (\"grids.vdb\", P + vector (0, 1, 0), \"subimage\", \"density\"), 0) * emission ();",
    );
    let (here, above) = (1.0 - 16.0 / 90.0, 1.0 - 17.0 / 90.0);
    assert!(shaded.abs_diff_eq(Vec3::new(here, here + above, here), 2e-3), "{shaded}");
    let (shaded, faults) =
        light("Ci = (color) texture3d (\"no.vdb\", P, \"missingcolor\", color (1, 2, 3)) * emission ();");
    assert_eq!(shaded, Vec3::new(1.0, 2.0, 3.0));
    assert!(faults.iter().any(|fault| fault.contains("no.vdb")), "{faults:?}");
    let (_, faults) =
        light("Ci = (color) texture3d (\"grids.vdb\", P, \"subimage\", \"smoke\") * emission ();");
    let reported =
        "Unknown subimage \"smoke\" in texture \"grids.vdb\"; it has ball, Cd, count, density, density, far";
    assert!(faults.iter().any(|fault| fault.contains(reported)), "{faults:?}");
}
