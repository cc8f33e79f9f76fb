// SPDX-License-Identifier: GPL-3.0-or-later
//! Round shapes of the kernels: exact surfaces, numbers and attributes of their primitives, and those that shine.

use anari_library_gnurt::types as t;

use crate::common::{Set, assert_close};

const SIZE: [u32; 2] = [200, 200];

/// A geometry with vertices and radii.
fn geometry(set: &Set, subtype: &str, points: &[[f32; 3]], radii: &[f32]) -> usize {
    let geometry = set.client.object(t::GEOMETRY, subtype);
    for (name, kind, floats) in
        [("vertex.position", t::FLOAT32_VEC3, points.as_flattened()), ("vertex.radius", t::FLOAT32, radii)]
    {
        let list = set.client.floats(kind, floats);
        set.client.give(geometry, name, t::ARRAY1D, list);
    }
    geometry
}

fn list(set: &Set, geometry: usize, name: &str, values: &[u32]) {
    let list = set.client.numbers(t::UINT32, values);
    set.client.give(geometry, name, t::ARRAY1D, list);
}

/// The place of a column or a row in the plane z = 0.
fn place(i: usize, size: u32) -> f32 {
    (i as f32 + 0.5) / size as f32 * 2.0 - 1.0
}

/// Largest difference of depths from those of a height above z = 0, which is `None` at and beyond outlines.
fn error_of(mut set: Set, geometry: usize, height: impl Fn(f32, f32) -> Option<f32>) -> f32 {
    set.client.commit(geometry);
    let grey = set.matte([0.5; 3]);
    set.add(geometry, grey);
    let depths = set.channel(SIZE, "channel.depth", t::FLOAT32).floats();
    set.assert_quiet();
    let (mut most, mut count) = (0.0_f32, 0);
    for (i, depth) in depths.iter().enumerate() {
        let (x, y) = (place(i % 200, SIZE[0]), place(i / 200, SIZE[1]));
        if let Some(height) = height(x, y) {
            most = most.max((depth - (5.0 - height)).abs());
            count += 1;
        }
    }
    assert!(count > 500, "{count} pixels are compared");
    most
}

#[test]
fn spheres_have_no_facets() {
    let set = Set::new("ao");
    let sphere = geometry(&set, "sphere", &[[0.1, 0.0, 0.5], [9.0, 9.0, 9.0]], &[0.8, 0.0]);
    let height = |x: f32, y: f32| {
        let off = (x - 0.1).powi(2) + y * y;
        (off < 0.63).then(|| 0.5 + (0.64 - off).sqrt())
    };
    let error = error_of(set, sphere, height);
    assert!(error < 2e-5, "{error} from a sphere");
}

#[test]
fn curves_have_no_facets() {
    // A rod, then a cone: the cone touches the balls of its ends where the sine of its angle is 0.15.
    let set = Set::new("ao");
    let points = [[-0.9, 0.0, 0.0], [-0.1, 0.0, 0.0], [0.9, 0.0, 0.0]];
    let curve = geometry(&set, "curve", &points, &[0.25, 0.25, 0.1]);
    let sine = 0.15_f32;
    let cosine = (1.0 - sine * sine).sqrt();
    let height = |x: f32, y: f32| {
        if (-0.88..-0.12).contains(&x) && y.abs() < 0.24 {
            return Some((0.0625 - y * y).sqrt());
        }
        // The radius across the axis, of the cone.
        let radius = (0.25 / cosine) - (x + 0.1) * sine / cosine;
        ((0.0..0.85).contains(&x) && y.abs() < 0.9 * radius).then(|| (radius * radius - y * y).sqrt())
    };
    let error = error_of(set, curve, height);
    assert!(error < 2e-5, "{error} from a rod and a cone");
}

#[test]
fn cylinders_and_cones_have_no_facets() {
    let ends = [[-0.8, 0.1, 0.0], [0.8, 0.1, 0.0]];
    for (subtype, radii) in [("cylinder", [0.4; 2]), ("cone", [0.5, 0.1]), ("cone", [0.0, 0.6])] {
        let set = Set::new("ao");
        let thing = geometry(&set, subtype, &ends, &radii);
        if subtype == "cylinder" {
            set.client.set_float(thing, "radius", radii[0]);
        }
        let height = |x: f32, y: f32| {
            let radius = radii[0] + (radii[1] - radii[0]) * (x + 0.8) / 1.6;
            let off = y - 0.1;
            (x.abs() < 0.79 && off.abs() < 0.95 * radius).then(|| (radius * radius - off * off).sqrt())
        };
        let error = error_of(set, thing, height);
        assert!(error < 3e-5, "{subtype} {radii:?}: {error}");
    }
}

#[test]
fn closed_ends_have_discs() {
    // Seen along the axis of a cone from its open, wide end: the cap of the far end, and the wall around it.
    let cone = |caps: &str| {
        let mut set = Set::new("ao");
        let cone = geometry(&set, "cone", &[[0.0, 0.0, -1.0], [0.0, 0.0, 0.0]], &[0.4, 0.8]);
        set.client.set_text(cone, "caps", caps);
        set.client.commit(cone);
        let grey = set.matte([0.5; 3]);
        set.add(cone, grey);
        let depths = set.channel(SIZE, "channel.depth", t::FLOAT32).floats();
        set.assert_quiet();
        depths
    };
    for (caps, middle) in [("none", f32::INFINITY), ("first", 6.0), ("second", 5.0), ("both", 5.0)] {
        for (i, depth) in cone(caps).into_iter().enumerate() {
            let off = place(i % 200, SIZE[0]).hypot(place(i / 200, SIZE[1]));
            let expected = match off {
                _ if off < 0.39 => middle,
                _ if (0.41..0.79).contains(&off) && middle != 5.0 => 5.0 + (0.8 - off) / 0.4,
                _ if off < 0.79 && middle == 5.0 => 5.0,
                _ if off > 0.81 => f32::INFINITY,
                _ => continue,
            };
            let is_right = depth == expected || (depth - expected).abs() < 1e-4;
            assert!(is_right, "caps {caps}, {off} off the axis: {depth}, expected {expected}");
        }
    }
}

/// Numbers of primitives along the middle row of eight pixels.
fn numbers(set: &mut Set, geometry: usize) -> Vec<u32> {
    set.client.commit(geometry);
    let grey = set.matte([0.5; 3]);
    set.add(geometry, grey);
    let all = set.channel([8, 8], "channel.primitiveId", t::UINT32).numbers();
    all[32..40].to_vec()
}

const NONE: u32 = u32::MAX;

#[test]
fn pieces_of_curves_keep_their_numbers() {
    let points: Vec<[f32; 3]> = (0..5).map(|i| [-1.0 + 0.5 * i as f32, 0.0, 0.0]).collect();
    let mut set = Set::new("ao");
    let curve = geometry(&set, "curve", &points, &[0.2; 5]);
    assert_eq!(numbers(&mut set, curve), [0, 0, 1, 1, 2, 2, 3, 3], "one curve");
    let mut set = Set::new("ao");
    let curve = geometry(&set, "curve", &points, &[0.2; 5]);
    // The second names no vertex, the third the last one, which begins no piece.
    list(&set, curve, "primitive.index", &[3, 77, 4, 0]);
    list(&set, curve, "primitive.id", &[10, 11, 12, 13]);
    let found = numbers(&mut set, curve);
    assert_eq!(found[..2], [13, 13], "the first piece is the fourth of the index");
    assert_eq!(found[6..], [10, 10], "the last piece is the first of the index");
    assert_eq!(found[3..5], [NONE; 2], "the others are missing");
    let messages = set.client.messages();
    assert!(messages.iter().any(|m| m.text.contains("2 of 4 primitives")), "{messages:?}");
}

#[test]
fn spheres_keep_their_numbers() {
    let mut set = Set::new("ao");
    let spheres = geometry(&set, "sphere", &[[-0.5, 0.0, 0.0], [0.5, 0.0, 0.0]], &[0.3, 0.3]);
    list(&set, spheres, "primitive.index", &[9, 1, 0]);
    let found = numbers(&mut set, spheres);
    assert_eq!([found[1], found[2], found[5], found[6]], [2, 2, 1, 1], "the first names no vertex");
}

/// Albedos of the middle row of eight pixels, red alone.
fn reds(mut set: Set, geometry: usize, name: &str) -> Vec<f32> {
    set.client.commit(geometry);
    let material = set.client.object(t::MATERIAL, "matte");
    set.client.set_text(material, "color", name);
    set.client.commit(material);
    set.add(geometry, material);
    let floats = set.channel([8, 8], "channel.albedo", t::FLOAT32_VEC3).floats();
    set.assert_quiet();
    (0..8).map(|x| floats[3 * (32 + x)]).collect()
}

#[test]
fn curves_carry_attributes() {
    let points = [[-1.0, 0.0, 0.0], [0.0, 0.0, 0.0], [1.0, 0.0, 0.0]];
    let give = |set: &Set, curve: usize, name: &str, values: &[f32]| {
        let list = set.client.floats(t::FLOAT32, values);
        set.client.give(curve, name, t::ARRAY1D, list);
    };
    let set = Set::new("ao");
    let curve = geometry(&set, "curve", &points, &[0.3; 3]);
    give(&set, curve, "vertex.attribute1", &[0.0, 0.5, 0.0]);
    give(&set, curve, "primitive.attribute1", &[0.9, 0.9]);
    for (x, found) in reds(set, curve, "attribute1").into_iter().enumerate() {
        let expected = 0.5 * (1.0 - place(x, 8).abs());
        assert!((found - expected).abs() < 1e-4, "between vertices: {found}, expected {expected}");
    }
    let set = Set::new("ao");
    let curve = geometry(&set, "curve", &points, &[0.3; 3]);
    list(&set, curve, "primitive.index", &[1, 0]);
    give(&set, curve, "primitive.attribute0", &[0.25, 0.75]);
    let found = reds(set, curve, "attribute0");
    assert!(
        found[..4].iter().all(|&red| red == 0.75) && found[4..].iter().all(|&red| red == 0.25),
        "{found:?}"
    );
}

#[test]
fn spheres_carry_attributes() {
    let set = Set::new("ao");
    let spheres = geometry(&set, "sphere", &[[9.0; 3], [-0.5, 0.0, 0.0], [0.5, 0.0, 0.0]], &[0.4; 3]);
    list(&set, spheres, "primitive.index", &[2, 1]);
    let values = set.client.floats(t::FLOAT32, &[0.1, 0.2, 0.3]);
    set.client.give(spheres, "vertex.attribute3", t::ARRAY1D, values);
    let found = reds(set, spheres, "attribute3");
    assert_eq!([found[1], found[2], found[5], found[6]], [0.2, 0.2, 0.3, 0.3], "of the vertices");
}

#[test]
fn cylinders_carry_attributes_up_to_their_caps() {
    let mut set = Set::new("ao");
    let cylinder = geometry(&set, "cylinder", &[[0.0, 0.0, 0.5], [0.0, 0.0, -0.5]], &[0.9; 2]);
    set.client.set_float(cylinder, "radius", 0.9);
    set.client.set_text(cylinder, "caps", "both");
    let values = set.client.floats(t::FLOAT32, &[0.75, 0.25]);
    set.client.give(cylinder, "vertex.attribute0", t::ARRAY1D, values);
    list(&set, cylinder, "primitive.id", &[42]);
    set.client.commit(cylinder);
    let found = reds(set, cylinder, "attribute0");
    assert_eq!(found[3..5], [0.75; 2], "the near end is the first one");
    set = Set::new("ao");
    let cone = geometry(&set, "cone", &[[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]], &[0.2, 0.6]);
    let values = set.client.floats(t::FLOAT32, &[0.0, 1.0]);
    set.client.give(cone, "vertex.attribute0", t::ARRAY1D, values);
    for (x, found) in reds(set, cone, "attribute0").into_iter().enumerate() {
        let expected = (place(x, 8) + 1.0) / 2.0;
        assert!((found - expected).abs() < 1e-4, "along a cone: {found}, expected {expected}");
    }
}

/// The opacity in the middle of a thing of half opacity.
fn opacity(subtype: &str) -> f32 {
    let mut set = Set::new("ao");
    let points = [[0.0, -1.0, 0.0], [0.0, 0.0, 0.0], [0.1, 1.0, 0.0]];
    let thing = match subtype {
        "sphere" => geometry(&set, "sphere", &[[0.0; 3]], &[0.5]),
        // Of three vertices, the middle one of which is seen.
        "curve" => geometry(&set, subtype, &points, &[0.5; 3]),
        _ => geometry(&set, subtype, &[points[0], [0.0, 1.0, 0.0]], &[0.5; 2]),
    };
    set.client.set_float(thing, "radius", 0.5);
    set.client.commit(thing);
    let material = set.client.object(t::MATERIAL, "matte");
    set.client.set_text(material, "alphaMode", "blend");
    set.client.set_float(material, "opacity", 0.5);
    set.client.commit(material);
    set.add(thing, material);
    set.client.set_floats(set.renderer, "background", t::FLOAT32_VEC4, &[0.0; 4]);
    set.client.commit(set.renderer);
    let picture = set.picture([9, 9]).floats();
    set.assert_quiet();
    picture[4 * (9 * 4 + 4) + 3]
}

#[test]
fn transparent_things_have_a_far_side() {
    for subtype in ["sphere", "curve", "cone", "cylinder"] {
        assert_close(opacity(subtype), 0.75, 0.01, subtype);
    }
}

#[test]
fn lights_of_any_shape_light_a_floor() {
    // A floor of 2 x 2 behind a shining ball or rod; both are sampled, so that few samples do.
    let brightness = |subtype: &str| {
        let mut set = Set::new("default");
        set.samples(16);
        let floor = set.square(1.0);
        let grey = set.matte([0.8; 3]);
        set.add(floor, grey);
        let points = [[-0.3, 0.0, 1.5], [0.3, 0.0, 1.5]];
        let lamp = geometry(&set, subtype, &points, &[0.05, 0.05]);
        set.client.set_float(lamp, "radius", 0.05);
        set.client.commit(lamp);
        let shines = set.client.object(t::MATERIAL, "physicallyBased");
        set.client.set_vec3(shines, "emissive", [50.0; 3]);
        set.client.commit(shines);
        set.add(lamp, shines);
        let floats = set.picture([40, 40]).floats();
        set.assert_quiet();
        // Pixels far from the lamp. Medians leave out a firefly.
        let mut corner: Vec<f32> = (0..64).map(|i| floats[4 * (40 * (i / 8) + i % 8)]).collect();
        let median = |values: &mut Vec<f32>| {
            values.sort_by(f32::total_cmp);
            values[32]
        };
        let mean = median(&mut corner);
        let spread = median(&mut corner.iter().map(|x| (x - mean).abs()).collect()) / mean;
        (mean, spread)
    };
    for subtype in ["sphere", "curve", "cone", "cylinder"] {
        let (mean, spread) = brightness(subtype);
        assert!(mean > 0.03 && spread < 0.5, "{subtype}: light {mean}, noise {spread}");
    }
}
