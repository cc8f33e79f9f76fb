// SPDX-License-Identifier: GPL-3.0-or-later
//! The layers of a picture, gathered from its tiles. Names of layers and channels as EXR files of the field have them.
//! Contents of the layers: see `aov`.

use gnurt_accel::INVALID_ID;
use gnurt_image::{BACKGROUND, Layer, Opacity, Picture};
use gnurt_shading::OutputKind;

use crate::aov::TileAovs;
use crate::expressions::LightLayer;
use crate::film::TileFilm;
use crate::first_hit::{FirstHit, NOTHING};
use crate::pixel_grid::PixelGrid;
use crate::seen::TileSeen;

/// One plane of a picture, gathered from the tiles.
fn gathered<T: Copy>(
    tiles: &[TileFilm],
    grid: PixelGrid,
    background: T,
    value: impl Fn(&TileFilm, &TileAovs, usize) -> T,
) -> Vec<T> {
    let mut plane = vec![background; grid.count()];
    for (tile, aovs) in tiles.iter().filter_map(|tile| Some((tile, tile.aovs.as_ref()?))) {
        for (i, pixel) in tile.pixels().enumerate() {
            plane[grid.at(pixel)] = value(tile, aovs, i);
        }
    }
    plane
}

/// Adds the layers of light and of shaders' outputs of all tiles to the picture.
pub(crate) fn add_light(
    picture: &mut Picture,
    tiles: &[TileFilm],
    grid: PixelGrid,
    layers: &[LightLayer],
    kinds: &[OutputKind],
) {
    for (number, layer) in layers.iter().enumerate() {
        let mut planes = [(); 3].map(|()| vec![0.0; grid.count()]);
        for tile in tiles {
            let scale = 1.0 / f64::from(tile.samples.max(1));
            for (i, pixel) in tile.pixels().enumerate() {
                let sum = tile.light.get(number, i);
                let at = grid.at(pixel);
                (0..3).for_each(|k| planes[k][at] = (sum[k] * scale) as f32);
            }
        }
        let [r, g, b] = planes;
        picture.layers.push(match kinds.get(number).unwrap_or(&OutputKind::Color) {
            OutputKind::Number => Layer::floats(&layer.name, [("Y", r)]),
            OutputKind::Vector => Layer::floats(&layer.name, [("X", r), ("Y", g), ("Z", b)]),
            OutputKind::Color => Layer::floats(&layer.name, [("R", r), ("G", g), ("B", b)]),
        });
    }
}

/// Adds the layers of all tiles to the picture, with those through mirrors and glass if `is_seen`. The visible background
/// is not opaque.
pub(crate) fn add_layers(picture: &mut Picture, tiles: &[TileFilm], grid: PixelGrid, is_seen: bool) {
    let plane = |value: &dyn Fn(&TileFilm, &TileAovs, usize) -> f32, background: f32| {
        gathered(tiles, grid, background, value)
    };
    let ids = |value: &dyn Fn(&FirstHit) -> u32| {
        gathered(tiles, grid, INVALID_ID, |_, aovs, i| value(&aovs.first[i]))
    };
    let mean = |sum: f64, tile: &TileFilm| (sum / f64::from(tile.samples.max(1))) as f32;
    let albedo = |c: usize| plane(&|tile, aovs, i| mean(aovs.albedo[i][c], tile), 0.0);
    let normal = |c: usize| plane(&|tile, aovs, i| mean(aovs.normal[i][c], tile), 0.0);
    let emission = |c: usize| plane(&|tile, aovs, i| mean(aovs.emission[i][c], tile), 0.0);
    let position = |c: usize| plane(&|_, aovs, i| aovs.first[i].position[c], 0.0);
    let variance = |c: usize| plane(&|tile, _, i| tile.variance(i)[c], 0.0);
    let background = |c: usize| plane(&|tile, aovs, i| mean(aovs.background(i)[c], tile), 0.0);
    let behind = [0, 1, 2, 3].map(background);
    let inside = plane(&|tile, _, _| if tile.samples > 0 { 1.0 } else { 0.0 }, 0.0);
    let depth = plane(&|_, aovs, i| aovs.first[i].depth, f32::INFINITY);
    let z = plane(&|_, aovs, i| aovs.first[i].z, f32::INFINITY);
    picture.opacity = Opacity::Associated;
    for ((pixel, share), inside) in picture.color.iter_mut().zip(&behind[3]).zip(inside) {
        pixel[3] = (inside - share).max(0.0);
    }
    let seen = |name: &str, channels: [&str; 3], value: &dyn Fn(&TileSeen, &TileFilm, usize) -> [f32; 3]| {
        let of = |tile: &TileFilm, aovs: &TileAovs, i: usize| {
            aovs.seen.as_ref().map_or([0.0; 3], |seen| value(seen, tile, i))
        };
        let values = gathered(tiles, grid, [0.0; 3], of);
        let plane = |k: usize| values.iter().map(|value| value[k]).collect();
        Layer::floats(name, [(channels[0], plane(0)), (channels[1], plane(1)), (channels[2], plane(2))])
    };
    let seen_hit = |aovs: &TileAovs, i: usize| aovs.seen.as_ref().map_or(NOTHING, |seen| seen.first[i]);
    let seen_ids = |value: &dyn Fn(&FirstHit) -> u32| {
        gathered(tiles, grid, INVALID_ID, |_, aovs, i| value(&seen_hit(aovs, i)))
    };
    let means = |sums: &[f64; 3], tile: &TileFilm| sums.map(|sum| mean(sum, tile));
    let (rgb, xyz) = (["R", "G", "B"], ["X", "Y", "Z"]);
    let seen = is_seen.then(|| {
        [
            seen("seen_albedo", rgb, &|seen, _, i| seen.mean(i, &seen.albedo)),
            seen("seen_N", xyz, &|seen, _, i| seen.mean(i, &seen.normal)),
            seen("seen_light", rgb, &|seen, tile, i| means(&seen.light[i], tile)),
            seen("seen_split", rgb, &|seen, _, i| seen.mean(i, &seen.split)),
            seen("seen_direct", rgb, &|seen, tile, i| means(&seen.direct()[i], tile)),
            seen("seen_direct_variance", rgb, &|seen, tile, i| seen.variances(i, tile.samples)[0]),
            seen("seen_indirect_variance", rgb, &|seen, tile, i| seen.variances(i, tile.samples)[1]),
            seen("seen_P", xyz, &|seen, _, i| seen.first[i].position.into()),
            Layer::floats("seen_depth", [("Z", plane(&|_, aovs, i| seen_hit(aovs, i).depth, f32::INFINITY))]),
            Layer::ids(
                "seen_id",
                [
                    ("object", seen_ids(&|hit| hit.object)),
                    ("instance", seen_ids(&|hit| hit.instance)),
                    ("prim", seen_ids(&|hit| hit.prim)),
                    ("material", seen_ids(&|hit| hit.material)),
                ],
            ),
        ]
    });
    let [r, g, b, a] = behind;
    picture.layers.extend([
        Layer::floats(BACKGROUND, [("R", r), ("G", g), ("B", b), ("A", a)]),
        Layer::floats("albedo", [("R", albedo(0)), ("G", albedo(1)), ("B", albedo(2))]),
        Layer::floats("variance", [("R", variance(0)), ("G", variance(1)), ("B", variance(2))]),
        Layer::floats("unscattered", [("R", emission(0)), ("G", emission(1)), ("B", emission(2))]),
        Layer::floats("N", [("X", normal(0)), ("Y", normal(1)), ("Z", normal(2))]),
        Layer::floats("P", [("X", position(0)), ("Y", position(1)), ("Z", position(2))]),
        Layer::floats("depth", [("Z", depth)]),
        Layer::floats("", [("Z", z)]),
        Layer::ids(
            "id",
            [
                ("object", ids(&|hit| hit.object)),
                ("instance", ids(&|hit| hit.instance)),
                ("prim", ids(&|hit| hit.prim)),
                ("material", ids(&|hit| hit.material)),
            ],
        ),
    ]);
    picture.layers.extend(seen.into_iter().flatten());
}
