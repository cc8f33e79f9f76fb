// SPDX-License-Identifier: GPL-3.0-or-later
//! Outlines and depths of all geometries, beside closed forms.

use std::f32::consts::PI;

use anari_library_gnurt::types as t;

use crate::common::{Set, assert_close};

const SIZE: [u32; 2] = [200, 200];
/// Area of a pixel: the picture shows 2 x 2.
const PIXEL: f32 = 4.0 / 40_000.0;

fn geometry(set: &Set, subtype: &str, points: &[[f32; 3]], radii: &[f32]) -> usize {
    let geometry = set.client.object(t::GEOMETRY, subtype);
    let positions = set.client.floats(t::FLOAT32_VEC3, points.as_flattened());
    set.client.give(geometry, "vertex.position", t::ARRAY1D, positions);
    match radii {
        [one] => set.client.set_float(geometry, "radius", *one),
        _ => {
            let list = set.client.floats(t::FLOAT32, radii);
            set.client.give(geometry, "vertex.radius", t::ARRAY1D, list);
        }
    }
    geometry
}

/// Visible area of a geometry, and the distance of its nearest point.
fn seen(mut set: Set, geometry: usize) -> (f32, f32) {
    set.client.commit(geometry);
    let grey = set.matte([0.5; 3]);
    set.add(geometry, grey);
    let depths = set.channel(SIZE, "channel.depth", t::FLOAT32).floats();
    set.assert_quiet();
    let count = depths.iter().filter(|depth| depth.is_finite()).count();
    (count as f32 * PIXEL, depths.iter().copied().fold(f32::INFINITY, f32::min))
}

#[test]
fn spheres_are_round() {
    let set = Set::new("ao");
    let sphere = geometry(&set, "sphere", &[[0.0, 0.0, 1.0]], &[0.7]);
    let (area, nearest) = seen(set, sphere);
    assert_close(area, PI * 0.49, 5e-3, "a disc");
    assert_close(nearest, 5.0 - 1.7, 1e-3, "its nearest point");
}

#[test]
fn radii_of_vertices_count() {
    let set = Set::new("ao");
    let spheres = geometry(&set, "sphere", &[[-0.5, 0.0, 0.0], [0.5, 0.0, 0.0]], &[0.2, 0.4]);
    let index = set.client.numbers(t::UINT32, &[1, 0]);
    set.client.give(spheres, "primitive.index", t::ARRAY1D, index);
    let (area, nearest) = seen(set, spheres);
    assert_close(area, PI * (0.04 + 0.16), 0.01, "two discs");
    assert_close(nearest, 4.6, 1e-3, "the larger one");
}

#[test]
fn cylinders_and_cones_have_their_outlines() {
    let ends = [[0.0, -0.5, 0.0], [0.0, 0.5, 0.0]];
    let set = Set::new("ao");
    let cylinder = geometry(&set, "cylinder", &ends, &[0.3]);
    let (area, nearest) = seen(set, cylinder);
    assert_close(area, 0.6, 0.01, "a rectangle");
    assert_close(nearest, 4.7, 1e-3, "its side");
    let set = Set::new("ao");
    let cone = geometry(&set, "cone", &ends, &[0.4, 0.0]);
    let (area, _) = seen(set, cone);
    assert_close(area, 0.4, 0.01, "a triangle");
}

#[test]
fn caps_close_the_ends_that_are_asked_for() {
    // Seen along the axis: the wall is edge-on, so only a cap or the inside shows.
    let depth = |caps: &str| {
        let set = Set::new("ao");
        let cylinder = geometry(&set, "cylinder", &[[0.0, 0.0, -0.5], [0.0, 0.0, 0.5]], &[0.5]);
        set.client.set_text(cylinder, "caps", caps);
        let (area, nearest) = seen(set, cylinder);
        (area > 0.7, nearest)
    };
    assert!(!depth("none").0, "open at both ends");
    let (closed, nearest) = depth("first");
    assert!(closed && (nearest - 5.5).abs() < 0.01, "the far end: {nearest}");
    for caps in ["second", "both"] {
        let (closed, nearest) = depth(caps);
        assert!(closed && (nearest - 4.5).abs() < 0.01, "the near end, {caps}: {nearest}");
    }
}

#[test]
fn curves_are_round_at_their_ends() {
    let points = [[-0.5, 0.0, 0.0], [0.5, 0.0, 0.0]];
    let set = Set::new("ao");
    let curve = geometry(&set, "curve", &points, &[0.2]);
    let (area, nearest) = seen(set, curve);
    assert_close(area, 0.4 + PI * 0.04, 0.01, "a rectangle and two halves of a disc");
    assert_close(nearest, 4.8, 1e-3, "its side");
    let set = Set::new("ao");
    let thinner = geometry(&set, "curve", &points, &[0.3, 0.1]);
    // The hull of two discs: two tangents, and an arc of each.
    let (r0, r1, d) = (0.3_f32, 0.1_f32, 1.0_f32);
    let angle = ((r0 - r1) / d).acos();
    let expected = (r0 + r1) * (d * d - (r0 - r1).powi(2)).sqrt() + r0 * r0 * (PI - angle) + r1 * r1 * angle;
    assert_close(seen(set, thinner).0, expected, 0.01, "the hull of two discs");
}

#[test]
fn isosurfaces_of_a_distance_are_spheres() {
    let set = Set::new("ao");
    let n = 33_u64;
    let place = |i: u64| i as f32 / (n - 1) as f32 * 2.0 - 1.0;
    let mut values = Vec::new();
    for z in 0..n {
        for y in 0..n {
            for x in 0..n {
                values.extend((place(x).powi(2) + place(y).powi(2) + place(z).powi(2)).sqrt().to_ne_bytes());
            }
        }
    }
    let field = set.client.object(t::SPATIAL_FIELD, "structuredRegular");
    let data = set.client.array(t::FLOAT32, &[n, n, n], &values);
    set.client.give(field, "data", t::ARRAY3D, data);
    set.client.set_vec3(field, "origin", [-1.0; 3]);
    set.client.set_vec3(field, "spacing", [2.0 / 32.0; 3]);
    set.client.commit(field);
    let surface = set.client.object(t::GEOMETRY, "isosurface");
    set.client.give(surface, "field", t::SPATIAL_FIELD, field);
    set.client.set_float(surface, "isovalue", 0.75);
    let (area, nearest) = seen(set, surface);
    assert_close(area, PI * 0.75 * 0.75, 0.01, "a disc");
    assert_close(nearest, 4.25, 2e-3, "its nearest point");
}

#[test]
fn quads_and_triangles_fill_their_areas() {
    let set = Set::new("ao");
    let square = set.square(0.5);
    assert_close(seen(set, square).0, 1.0, 0.01, "a square");
    let set = Set::new("ao");
    let triangle = set.faces("triangle", &[[-0.5, -0.5, 0.0], [0.5, -0.5, 0.0], [0.0, 0.5, 0.0]]);
    assert_close(seen(set, triangle).0, 0.5, 0.01, "a triangle");
}
