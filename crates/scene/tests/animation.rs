// SPDX-License-Identifier: GPL-3.0-or-later
//! Animations of glTF files and of programs: positions at a time, against a simple evaluation in double
//! precision. GlTF 2.0 section 3.11 and appendix C, KHR_animation_pointer, KHR_node_visibility.

use std::sync::Arc;

use crate::common::{glb, load_named};
use gnurt_scene::animation::{
    Attachment, Channel, Clip, Interpolation, Local, MovingMember, Node, Sampler, Target, Trs,
};
use gnurt_scene::edit::Edit;
use gnurt_scene::io::{Error, Loaded, Oddity};
use gnurt_scene::{Affine, Animation, Light, Member, MeshId, Scene, Surface};

/// A binary glTF file in the making.
#[derive(Default)]
struct Gltf {
    bytes: Vec<u8>,
    views: Vec<String>,
    accessors: Vec<String>,
}

impl Gltf {
    fn add(&mut self, bytes: &[u8], component: u32, shape: &str, count: usize, more: &str) -> usize {
        let offset = self.bytes.len();
        self.bytes.extend(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let view = self.views.len();
        self.views.push(format!(r#"{{"buffer":0,"byteOffset":{offset},"byteLength":{}}}"#, bytes.len()));
        self.accessors.push(format!(
            r#"{{"bufferView":{view},"componentType":{component},"count":{count},"type":"{shape}"{more}}}"#
        ));
        self.accessors.len() - 1
    }

    fn floats(&mut self, values: &[f32], shape: &str) -> usize {
        let width = ["SCALAR", "VEC2", "VEC3", "VEC4"].iter().position(|s| *s == shape).map_or(16, |i| i + 1);
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.add(&bytes, 5126, shape, values.len() / width, "")
    }

    /// An animation's sampler and its channel with this `target`.
    fn curve(&mut self, times: &[f32], values: &[f32], shape: &str, how: &str) -> String {
        let (input, output) = (self.floats(times, "SCALAR"), self.floats(values, shape));
        format!(r#"{{"input":{input},"output":{output},"interpolation":"{how}"}}"#)
    }

    fn load(&self, body: &str) -> Result<Loaded, Error> {
        let (views, accessors) = (self.views.join(","), self.accessors.join(","));
        let json = format!(
            r#"{{"asset":{{"version":"2.0"}},"buffers":[{{"byteLength":{}}}],"bufferViews":[{views}],"accessors":[{accessors}],{body}}}"#,
            self.bytes.len()
        );
        load_named("t.glb", &glb(json.as_bytes(), &self.bytes))
    }

    fn scene(&self, body: &str) -> Scene {
        let loaded = self.load(body).unwrap_or_else(|e| panic!("{e}"));
        assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
        loaded.scene.check().expect("it is in order");
        loaded.scene
    }
}

fn clip(name: &str, samplers: &[String], channels: &[(usize, &str)]) -> String {
    let channel =
        |(sampler, target): &(usize, &str)| format!(r#"{{"sampler":{sampler},"target":{{{target}}}}}"#);
    let channels: Vec<String> = channels.iter().map(channel).collect();
    format!(r#"{{"name":"{name}","samplers":[{}],"channels":[{}]}}"#, samplers.join(","), channels.join(","))
}

fn pointer(path: &str) -> String {
    format!(r#""path":"pointer","extensions":{{"KHR_animation_pointer":{{"pointer":"{path}"}}}}"#)
}

const TRIANGLE: [f32; 9] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];

fn close(found: [f64; 3], expected: [f64; 3], what: &str) {
    let error = (0..3).map(|k| (found[k] - expected[k]).abs()).fold(0.0, f64::max);
    assert!(error < 1e-6, "{what}: {found:?}, not {expected:?}");
}

#[test]
fn nodes_move_with_their_parents() {
    let mut g = Gltf::default();
    let mesh = g.floats(&TRIANGLE, "VEC3");
    let quarter = std::f32::consts::FRAC_1_SQRT_2;
    let rotation = g.curve(&[1.0, 3.0], &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, quarter, quarter], "VEC4", "LINEAR");
    let walk = g.curve(&[0.0, 2.0, 4.0], &[0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 2.0, 6.0, 0.0], "VEC3", "LINEAR");
    let grow = g.curve(&[0.0, 1.0], &[1.0, 1.0, 1.0, 2.0, 3.0, 4.0], "VEC3", "STEP");
    let clips = [
        clip(
            "turn",
            &[rotation, walk],
            &[(0, r#""node":0,"path":"rotation""#), (1, r#""node":1,"path":"translation""#)],
        ),
        clip("grow", &[grow], &[(0, r#""node":1,"path":"scale""#)]),
    ]
    .join(",");
    let mut scene = g.scene(&format!(
        r#""meshes":[{{"primitives":[{{"attributes":{{"POSITION":{mesh}}}}}]}}],"animations":[{clips}],
        "nodes":[{{"children":[1],"translation":[5,0,0]}},{{"mesh":0,"translation":[0,0,7]}},{{"mesh":0}}]"#
    ));
    let animation = scene.animation().expect("an animation");
    let names: Vec<_> = animation.clips.iter().map(|c| (&c.name[..], c.range())).collect();
    assert_eq!(names, [("turn", [0.0, 4.0]), ("grow", [0.0, 1.0])], "clips");
    assert_eq!(animation.nodes.len(), 2, "what stands still is not there");
    let at = |scene: &Scene| scene.instances()[0].world_from_object.point([1.0, 0.0, 0.0]);
    close(at(&scene), [6.0, 0.0, 7.0], "at rest");
    for (seconds, degrees, found_position) in [
        (-1.0, 0.0, [0.0, 0.0]),
        (1.0, 0.0, [1.0, 0.0]),
        (1.5, 22.5, [1.5, 0.0]),
        (2.5, 67.5, [2.0, 1.5]),
        (9.0, 90.0, [2.0, 6.0]),
    ] {
        scene.pose(0, seconds);
        let (s, c) = f64::to_radians(degrees).sin_cos();
        let (x, y) = (found_position[0] + 1.0, found_position[1]);
        close(at(&scene), [5.0 + c * x - s * y, s * x + c * y, 0.0], &format!("at {seconds}"));
    }
    scene.pose(1, 0.99);
    close(at(&scene), [6.0, 0.0, 7.0], "another clip, from rest");
    scene.pose(1, 1.0);
    close(at(&scene), [7.0, 0.0, 7.0], "twice as wide");
    scene.rest();
    close(at(&scene), [6.0, 0.0, 7.0], "at rest again");
}

/// Cubic splines in the simplest way: de Casteljau on the Bezier form.
fn bezier(a: f64, out: f64, into: f64, b: f64, length: f64, u: f64) -> f64 {
    let mut p = [a, a + out * length / 3.0, b - into * length / 3.0, b];
    for n in (1..4).rev() {
        (0..n).for_each(|i| p[i] += u * (p[i + 1] - p[i]));
    }
    p[0]
}

#[test]
fn cubic_splines_and_normalized_integers() {
    let mut g = Gltf::default();
    let mesh = g.floats(&TRIANGLE, "VEC3");
    // in-tangent, value, out-tangent of two keys.
    let values =
        [9.0, 9.0, 9.0, 1.0, 2.0, 3.0, 0.5, -1.0, 2.0, -2.0, 0.25, 1.0, 4.0, 0.0, -3.0, 9.0, 9.0, 9.0];
    let spline = g.curve(&[1.0, 3.5], &values, "VEC3", "CUBICSPLINE");
    let rotations =
        [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.4, 0.0, 0.0, 0.0, 0.3, 0.0, 0.0, 0.0, 0.6, 0.0, 0.8];
    let rotations: Vec<f32> = rotations.into_iter().chain([0.0; 4]).collect();
    let rotation = g.curve(&[0.0, 1.0], &rotations, "VEC4", "CUBICSPLINE");
    // Half a turn about y in bytes, and back on the other side of the sphere: no way at all.
    let times = g.floats(&[0.0, 1.0], "SCALAR");
    let bytes = [0_i8, 127, 0, 0, 0, -127, 0, 0].map(|b| b as u8);
    let packed = g.add(&bytes, 5120, "VEC4", 2, r#","normalized":true"#);
    let packed = format!(r#"{{"input":{times},"output":{packed}}}"#);
    let clips = [
        clip(
            "a",
            &[spline, rotation],
            &[(0, r#""node":0,"path":"translation""#), (1, r#""node":0,"path":"rotation""#)],
        ),
        clip("b", &[packed], &[(0, r#""node":0,"path":"rotation""#)]),
    ]
    .join(",");
    let mut scene = g.scene(&format!(
        r#""meshes":[{{"primitives":[{{"attributes":{{"POSITION":{mesh}}}}}]}}],"nodes":[{{"mesh":0}}],"animations":[{clips}]"#
    ));
    let (from, out, into, to) = ([1.0, 2.0, 3.0], [0.5, -1.0, 2.0], [-2.0, 0.25, 1.0], [4.0, 0.0, -3.0]);
    for i in 0..=20 {
        let seconds = 1.0 + 2.5 * f64::from(i) / 20.0;
        scene.pose(0, seconds);
        let found_position: [f64; 3] =
            [0, 1, 2].map(|k| bezier(from[k], out[k], into[k], to[k], 2.5, f64::from(i) / 20.0));
        close(
            scene.instances()[0].world_from_object.point([0.0; 3]),
            found_position,
            &format!("at {seconds}"),
        );
    }
    for u in [0.0, 0.3, 0.5, 0.9, 1.0] {
        scene.pose(0, u);
        let y = bezier(0.0, f64::from(0.4_f32), f64::from(0.3_f32), f64::from(0.6_f32), 1.0, u);
        let w = bezier(1.0, 0.0, 0.0, f64::from(0.8_f32), 1.0, u);
        let angle = 2.0 * y.atan2(w);
        close(
            scene.instances()[0].world_from_object.vector([1.0, 0.0, 0.0]),
            [angle.cos(), 0.0, -angle.sin()],
            &format!("a spline of turns is normalised at {u}"),
        );
    }
    scene.pose(1, 0.37);
    close(
        scene.instances()[0].world_from_object.vector([1.0, 0.0, 0.0]),
        [-1.0, 0.0, 0.0],
        "the shorter way",
    );
}

/// A bar along y of three squares, whose vertices follow two joints by their height, in two sets of joints.
fn bar(g: &mut Gltf, joint: u8) -> String {
    let (mut positions, mut first, mut second, mut normals) =
        (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for row in 0..4_u8 {
        for x in [0.0, 1.0] {
            positions.extend([x, f32::from(row), 0.0]);
            normals.extend([0.0, 0.0, 1.0]);
            // Half of the expected value: weights are divided by their sum.
            first.extend([0.5 * (1.0 - f32::from(row) / 3.0), 0.0, 0.0, 0.0]);
            second.extend([0.0, 0.5 * f32::from(row) / 3.0, 0.0, 0.0]);
        }
    }
    let quads = (0..3_u8).flat_map(|row| [0, 1, 3, 0, 3, 2].map(|k| 2 * row + k)).collect::<Vec<_>>();
    let (p, n) = (g.floats(&positions, "VEC3"), g.floats(&normals, "VEC3"));
    let (w0, w1) = (g.floats(&first, "VEC4"), g.floats(&second, "VEC4"));
    let j0 = g.add(&[0; 32], 5121, "VEC4", 8, "");
    let j1 = g.add(&[7, joint, 9, 9].repeat(8), 5121, "VEC4", 8, "");
    let i = g.add(&quads, 5121, "SCALAR", 18, "");
    format!(
        r#"{{"primitives":[{{"indices":{i},"attributes":{{"POSITION":{p},"NORMAL":{n},"JOINTS_0":{j0},"WEIGHTS_0":{w0},"JOINTS_1":{j1},"WEIGHTS_1":{w1}}}}}]}}"#
    )
}

fn bent(g: &mut Gltf, joint: u8) -> String {
    let mesh = bar(g, joint);
    let column =
        |x: f32, y: f32| [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, x, y, 0.0, 1.0];
    let binds = g.floats(&[column(0.0, 0.0), column(0.0, -3.0)].concat(), "MAT4");
    let half = (std::f32::consts::FRAC_PI_4 / 2.0).sin_cos();
    let rotation = g.curve(&[0.0, 1.0], &[0.0, 0.0, 0.0, 1.0, half.0, 0.0, 0.0, half.1], "VEC4", "LINEAR");
    let rise = g.curve(&[0.0, 1.0], &[0.0, 0.0, 0.0, 0.0, 0.0, 2.0], "VEC3", "LINEAR");
    let clip = clip(
        "bend",
        &[rotation, rise],
        &[(0, r#""node":2,"path":"rotation""#), (1, r#""node":1,"path":"translation""#)],
    );
    format!(
        r#""meshes":[{mesh}],"skins":[{{"joints":[1,2],"inverseBindMatrices":{binds}}}],"animations":[{clip}],
        "nodes":[{{"mesh":0,"skin":0,"translation":[99,0,0]}},{{"children":[2]}},{{"translation":[0,3,0]}}]"#
    )
}

#[test]
fn skins_bend_by_all_their_joints() {
    let mut g = Gltf::default();
    let body = bent(&mut g, 1);
    let mut scene = g.scene(&body);
    for seconds in [0.0, 0.25, 0.5, 1.0] {
        let posed = scene.pose(0, seconds);
        assert_eq!(posed.instances, 0, "a skinned mesh stays in the world");
        let (s, c) = (std::f64::consts::FRAC_PI_4 * seconds).sin_cos();
        let mesh = scene.mesh(MeshId(0));
        for (i, found) in mesh.positions.iter().enumerate() {
            let (x, y, up) = ((i % 2) as f64, (i / 2) as f64, 2.0 * seconds);
            let weight = y / 3.0;
            let turned = [x, 3.0 + c * (y - 3.0), s * (y - 3.0) + up];
            let expected = [0, 1, 2].map(|k| (1.0 - weight) * [x, y, up][k] + weight * turned[k]);
            close(found.map(f64::from), expected, &format!("vertex {i} at {seconds}"));
        }
        let [x, y, z] = mesh.normals[7].map(f64::from);
        close([x, y, z], [0.0, -s, c], &format!("the normal of the upper end at {seconds}"));
    }
    close(scene.instances()[0].world_from_object.point([0.0; 3]), [0.0; 3], "its node does not count");
}

/// The area vector of a triangle of a mesh, and the normal of its first corner.
fn sides(mesh: &gnurt_scene::Mesh, triangle: usize) -> ([f32; 3], [f32; 3]) {
    let [a, b, c] = mesh.indices[triangle].map(|i| mesh.positions[i as usize]);
    let [u, v] = [b, c].map(|p| [0, 1, 2].map(|k| p[k] - a[k]));
    let cross = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    (cross, mesh.normals[mesh.indices[triangle][0] as usize])
}

/// A character that is scaled by -1 keeps its outside outside.
#[test]
fn joints_that_mirror_turn_triangles_round() {
    let mut g = Gltf::default();
    let flip = g.curve(&[0.0, 1.0], &[1.0, 1.0, 1.0, -1.0, 1.0, 1.0], "VEC3", "STEP");
    let mesh = bar(&mut g, 1);
    let clip = clip("flip", &[flip], &[(0, r#""node":1,"path":"scale""#)]);
    let body = |scale: &str, animations: &str| {
        format!(
            r#""meshes":[{mesh}],"skins":[{{"joints":[1,2]}}],{animations}
            "nodes":[{{"mesh":0,"skin":0}},{{"children":[2]{scale}}},{{}}]"#
        )
    };
    let check = |scene: &Scene, what: &str| {
        for triangle in 0..6 {
            let (area, normal) = sides(scene.mesh(MeshId(0)), triangle);
            assert!(area[2] * normal[2] > 0.0, "{what}: triangle {triangle} {area:?} {normal:?}");
        }
    };
    check(&g.scene(&body("", "")), "as it is");
    check(&g.scene(&body(r#","scale":[-1,1,1]"#, "")), "mirrored at rest");
    check(&g.scene(&body(r#","scale":[-1,-1,1]"#, "")), "mirrored twice");
    let mut moving = g.scene(&body("", &format!(r#""animations":[{clip}],"#)));
    for seconds in [0.5, 1.0, 0.5, 1.0, 0.0] {
        moving.pose(0, seconds);
        check(&moving, &format!("at {seconds}"));
        let x = moving.mesh(MeshId(0)).positions[1][0];
        assert_eq!(x, if seconds < 1.0 { 1.0 } else { -1.0 }, "mirrored from 1 on, at {seconds}");
    }
}

/// Invalid numbers in the file: the deformed mesh gets a warning.
#[test]
fn weights_and_matrices_that_are_no_numbers_are_told() {
    for (weight, bind, text) in [
        (f32::NAN, 1.0, "vertex 1 has a joint weight that is not finite"),
        (1.0, f32::NAN, "skins[0]: inverse bind matrix 0"),
        (1.0, 1.0, ""),
    ] {
        let mut g = Gltf::default();
        let p = g.floats(&TRIANGLE, "VEC3");
        let j = g.add(&[0; 12], 5121, "VEC4", 3, "");
        let mut weights = [1.0, 0.0, 0.0, 0.0].repeat(3);
        weights[4] = weight;
        let w = g.floats(&weights, "VEC4");
        let mut matrix = [0.0; 16];
        (0..4).for_each(|k| matrix[5 * k] = 1.0);
        matrix[0] = bind;
        let b = g.floats(&matrix, "MAT4");
        let rise = g.curve(&[0.0, 1.0], &[0.0, 0.0, 0.0, 0.0, 0.0, 2.0], "VEC3", "LINEAR");
        let clip = clip("c", &[rise], &[(0, r#""node":1,"path":"translation""#)]);
        let loaded = g
            .load(&format!(
                r#""meshes":[{{"primitives":[{{"attributes":{{"POSITION":{p},"JOINTS_0":{j},"WEIGHTS_0":{w}}}}}]}}],
                "skins":[{{"joints":[1],"inverseBindMatrices":{b}}}],"animations":[{clip}],"nodes":[{{"mesh":0,"skin":0}},{{}}]"#
            ))
            .unwrap_or_else(|e| panic!("{e}"));
        let lines: Vec<String> = loaded.warnings.iter().map(ToString::to_string).collect();
        let is_told = if text.is_empty() { lines.is_empty() } else { lines.iter().any(|l| l.contains(text)) };
        assert!(is_told, "{text}: {lines:?}");
        let mut scene = loaded.scene;
        scene.pose(0, 0.5);
        assert!(scene.mesh(MeshId(0)).positions.as_flattened().iter().all(|x| x.is_finite()), "{text}");
    }
}

#[test]
fn joints_out_of_range_are_an_error() {
    let mut g = Gltf::default();
    let body = bent(&mut g, 2);
    let error = g.load(&body).expect_err("no such joint").to_string();
    assert!(
        error.contains("meshes[0].primitives[0]: vertex 2 uses joint 2, but the skin has 2 joints"),
        "{error}"
    );
    let dangling = body.replace(r#""joints":[1,2]"#, r#""joints":[1,3]"#);
    let error = g.load(&dangling).expect_err("no such node").to_string();
    assert!(error.contains("skins[0]: joint 3 does not exist"), "{error}");
}

#[test]
fn weights_morph_positions_and_normals() {
    let mut g = Gltf::default();
    let mesh = g.floats(&TRIANGLE, "VEC3");
    let normals = g.floats(&[0.0, 0.0, 1.0].repeat(3), "VEC3");
    let wide = g.floats(&[0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 0.0, 0.0], "VEC3");
    let tilt = g.floats(&[1.0, 0.0, 0.0].repeat(3), "VEC3");
    // Vertex 2 alone, by a sparse accessor.
    let (at, by) = (g.add(&[2], 5121, "SCALAR", 1, ""), g.floats(&[0.0, 0.0, 4.0], "VEC3"));
    g.accessors.push(format!(
        r#"{{"componentType":5126,"count":3,"type":"VEC3","sparse":{{"count":1,"indices":{{"bufferView":{at},"componentType":5121}},"values":{{"bufferView":{by}}}}}}}"#
    ));
    let deep = g.accessors.len() - 1;
    let both = g.curve(&[0.0, 1.0], &[0.0, 1.0, 1.0, 0.0], "SCALAR", "LINEAR");
    let spline = g.curve(
        &[0.0, 1.0],
        &[0.0, 0.0, 0.25, 0.5, 1.0, 1.0, 1.0, 1.0, 0.75, 0.5, 0.0, 0.0],
        "SCALAR",
        "CUBICSPLINE",
    );
    let one = g.curve(&[0.0, 1.0], &[0.0, 3.0], "SCALAR", "LINEAR");
    let all = format!(
        r#"{},{},{}"#,
        clip("node", &[both], &[(0, r#""node":1,"path":"weights""#)]),
        clip("spline", &[spline], &[(0, r#""node":1,"path":"weights""#)]),
        clip("one", &[one], &[(0, &pointer("/meshes/0/weights/1"))])
    );
    let mut scene = g.scene(&format!(
        r#""meshes":[{{"weights":[0.5,0],"primitives":[{{"attributes":{{"POSITION":{mesh},"NORMAL":{normals}}},
        "targets":[{{"POSITION":{wide},"NORMAL":{tilt}}},{{"POSITION":{deep}}}]}}]}}],
        "nodes":[{{"mesh":0}},{{"mesh":0}}],"animations":[{all}]"#
    ));
    assert_eq!(scene.objects().len(), 2, "one as the mesh has it, one of its own");
    let find = |scene: &Scene, weights: [f32; 2], mesh: u32, when: &str| {
        let mesh = scene.mesh(MeshId(mesh));
        let expected = [[0.0; 3], [1.0 + 2.0 * weights[0], 0.0, 0.0], [0.0, 1.0, 4.0 * weights[1]]];
        assert_eq!(mesh.positions, expected, "{when}");
        assert_eq!(mesh.normals, [[weights[0], 0.0, 1.0]; 3], "{when}");
    };
    find(&scene, [0.5, 0.0], 0, "at rest");
    find(&scene, [0.5, 0.0], 1, "at rest");
    scene.pose(0, 0.25);
    find(&scene, [0.25, 0.75], 1, "the node's weights");
    find(&scene, [0.5, 0.0], 0, "the mesh's are at rest");
    scene.pose(1, 0.5);
    let middle = [bezier(0.25, 1.0, 1.0, 0.75, 1.0, 0.5), bezier(0.5, 1.0, 1.0, 0.5, 1.0, 0.5)];
    find(&scene, middle.map(|x| x as f32), 1, "a spline: tangents of all, then values of all");
    scene.pose(2, 0.5);
    find(&scene, [0.5, 1.5], 0, "one weight of the mesh by a pointer");
    find(&scene, [0.5, 0.0], 1, "the other node has weights of its own");
}

#[test]
fn pointers_drive_cameras_lights_materials_and_visibility() {
    let mut g = Gltf::default();
    let mesh = g.floats(&TRIANGLE, "VEC3");
    let one = g.curve(&[0.0, 2.0], &[1.0, 0.5], "SCALAR", "LINEAR");
    let color = g.curve(&[0.0, 2.0], &[1.0, 1.0, 1.0, 0.0, 0.5, 1.0], "VEC3", "LINEAR");
    let base = g.curve(&[0.0, 2.0], &[1.0, 1.0, 1.0, 1.0, 0.5, 0.0, 0.0, 0.5], "VEC4", "LINEAR");
    let offset = g.curve(&[0.0, 2.0], &[0.0, 0.0, 1.0, 0.5], "VEC2", "LINEAR");
    let times = g.floats(&[0.0, 1.0], "SCALAR");
    let joint_accessor = g.add(&[1, 0], 5121, "SCALAR", 2, "");
    let joint_accessor = format!(r#"{{"input":{times},"output":{joint_accessor},"interpolation":"STEP"}}"#);
    let lights = "/extensions/KHR_lights_punctual/lights/0";
    let transform =
        "/materials/0/pbrMetallicRoughness/baseColorTexture/extensions/KHR_texture_transform/offset";
    let pointers = [
        (0, "/cameras/0/perspective/yfov".to_owned()),
        (0, format!("{lights}/intensity")),
        (1, format!("{lights}/color")),
        (0, "/materials/0/pbrMetallicRoughness/roughnessFactor".to_owned()),
        (1, "/materials/0/emissiveFactor".to_owned()),
        (2, "/materials/0/pbrMetallicRoughness/baseColorFactor".to_owned()),
        (3, transform.to_owned()),
        (4, "/nodes/1/extensions/KHR_node_visibility/visible".to_owned()),
        (1, "/nodes/3/translation".to_owned()),
    ]
    .map(|(sampler, path)| (sampler, pointer(&path)));
    let channels: Vec<(usize, &str)> = pointers.iter().map(|(sampler, path)| (*sampler, &path[..])).collect();
    let clip = clip("all", &[one, color, base, offset, joint_accessor], &channels);
    let pixel =
        "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mP8z8BQDwAEhQGAhKmMIQAAAABJRU5ErkJggg==";
    let mut scene = g.scene(&format!(
        r#""extensionsRequired":["KHR_animation_pointer","KHR_node_visibility"],"animations":[{clip}],
        "images":[{{"uri":"data:image/png;base64,{pixel}"}}],"textures":[{{"source":0}}],
        "materials":[{{"alphaMode":"BLEND","pbrMetallicRoughness":{{"baseColorTexture":{{"index":0}}}}}}],
        "meshes":[{{"primitives":[{{"material":0,"attributes":{{"POSITION":{mesh}}}}}]}}],
        "cameras":[{{"type":"perspective","perspective":{{"yfov":1,"znear":0.1}}}}],
        "extensions":{{"KHR_lights_punctual":{{"lights":[{{"type":"point","intensity":7}}]}}}},
        "nodes":[{{"mesh":0}},{{"children":[2]}},{{"mesh":0,"extensions":{{"KHR_lights_punctual":{{"light":0}}}}}},{{"camera":0}}]"#
    ));
    scene.pose(0, 0.5);
    let camera = &scene.cameras()[0];
    assert!((f64::from(camera.fov_y) - 0.875_f64.to_degrees()).abs() < 1e-4, "the angle: {}", camera.fov_y);
    close(camera.eye.map(f64::from), [0.75, 0.875, 1.0], "the camera");
    close(camera.target.map(f64::from), [0.75, 0.875, 0.0], "what it looks at");
    let Light::Point { intensity, .. } = scene.lights()[0] else { panic!("{:?}", scene.lights()) };
    close(intensity.map(f64::from), [0.75 * 0.875, 0.875 * 0.875, 0.875], "the light");
    let material = &scene.materials()[0];
    let Surface::MetallicRoughness { roughness, base_color, .. } = &material.surface else {
        panic!("{material:?}")
    };
    assert_eq!((*roughness, base_color.factor), (0.875, [0.875, 0.75, 0.75]), "the material");
    assert_eq!(material.emission, [0.75, 0.875, 1.0], "what it gives off");
    assert!(format!("{:?}", material.alpha).contains("factor: 0.875"), "its opacity: {:?}", material.alpha);
    let map = base_color.texture.expect("a texture").uv_from_mesh;
    assert_eq!((map[4], map[5]), (0.25, -0.125), "moved by 0.25 and, v being upwards, by -0.125");
    assert!(scene.instances()[1].visible, "seen");
    scene.pose(0, 1.0);
    assert!(scene.instances()[0].visible && !scene.instances()[1].visible, "hidden with what it stands on");
    let Light::Point { intensity, .. } = scene.lights()[0] else { panic!("{:?}", scene.lights()) };
    assert_eq!(intensity, [0.0; 3], "and so is the light");
    scene.rest();
    assert!(scene.instances()[1].visible && scene.materials()[0].emission == [0.0; 3], "at rest");
}

#[test]
fn bad_animations_are_told_by_their_place() {
    let mut g = Gltf::default();
    let mesh = g.floats(&TRIANGLE, "VEC3");
    let good = g.curve(&[0.0, 1.0], &[0.0; 6], "VEC3", "LINEAR");
    let nan = g.curve(&[0.0, f32::NAN], &[0.0; 6], "VEC3", "LINEAR");
    let back = g.curve(&[0.0, 2.0, 1.0], &[0.0; 9], "VEC3", "LINEAR");
    let equal = g.curve(&[0.0, 1.0, 1.0], &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 8.0, 0.0, 0.0], "VEC3", "LINEAR");
    let few = g.curve(&[0.0, 1.0], &[0.0; 9], "VEC3", "LINEAR");
    let odd = g.curve(&[0.0, 1.0], &[0.0; 6], "VEC3", "QUADRATIC");
    let none = g.curve(&[], &[], "VEC3", "LINEAR");
    let weights = g.curve(&[0.0, 1.0], &[0.0; 4], "SCALAR", "LINEAR");
    let no_turn = g.curve(&[0.0, 1.0], &[0.0, 0.0, 0.0, 1.0, 0.0, f32::NAN, 0.0, 1.0], "VEC4", "LINEAR");
    let no_place = g.curve(&[0.0, 1.0], &[0.0, 0.0, f32::INFINITY, 0.0, 0.0, 0.0], "VEC3", "STEP");
    let shown = |samplers: &[String], target: &str| {
        let clip = clip("c", samplers, &[(0, target)]);
        g.load(&format!(
            r#""meshes":[{{"primitives":[{{"attributes":{{"POSITION":{mesh}}},"targets":[{{"POSITION":{mesh}}}]}}]}}],"nodes":[{{"mesh":0}},{{"matrix":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]}}],"animations":[{{}},{clip}]"#
        ))
    };
    let move_it = r#""node":0,"path":"translation""#;
    for (sampler, target, oddity, text) in [
        (
            &nan,
            move_it,
            Oddity::BadAnimation,
            "animations[1].samplers[0] of animations[1].channels[0]: the time of key 1 is not a finite number",
        ),
        (
            &no_turn,
            r#""node":0,"path":"rotation""#,
            Oddity::BadAnimation,
            "animations[1].samplers[0] of animations[1].channels[0]: a value of key 1 is not a finite number",
        ),
        (&no_place, move_it, Oddity::BadAnimation, "a value of key 0 is not a finite number"),
        (&back, move_it, Oddity::BadAnimation, "the time of key 2 is before that of the key before it"),
        (&equal, move_it, Oddity::RepeatedKey, "animations[1].samplers[0]"),
        (&few, move_it, Oddity::BadAnimation, "9 values for 2 keys; expected 6"),
        (&odd, move_it, Oddity::BadAnimation, "unknown interpolation `QUADRATIC`"),
        (&none, move_it, Oddity::BadAnimation, "keys missing"),
        (
            &weights,
            r#""node":0,"path":"weights""#,
            Oddity::BadAnimation,
            "animations[1].channels[0]: 2 weights for 1 morph targets",
        ),
        (&good, r#""node":1,"path":"translation""#, Oddity::BadAnimation, "nodes[1] has a matrix"),
        (
            &good,
            r#""path":"translation""#,
            Oddity::NotShown,
            "animations[1].channels[0]: animation of `translation`",
        ),
        (&good, r#""node":0,"path":"colour""#, Oddity::NotShown, "animation of `colour`"),
        (
            &good,
            &pointer("/materials/0/doubleSided")[..],
            Oddity::NotShown,
            "animation of `/materials/0/doubleSided`",
        ),
    ] {
        let loaded = shown(std::slice::from_ref(sampler), target).unwrap_or_else(|e| panic!("{e}"));
        let warnings: Vec<String> = loaded.warnings.iter().map(ToString::to_string).collect();
        assert_eq!(loaded.warnings.count(oddity), 1, "{target}: {warnings:?}");
        assert!(warnings.iter().any(|w| w.contains(text)), "{text}: {warnings:?}");
        let mut scene = loaded.scene;
        scene.pose(1, 0.5);
    }
    for (samplers, target, text) in [
        (
            vec![good.clone()],
            r#""node":7,"path":"scale""#.to_owned(),
            "animations[1].channels[0]: node 7 does not exist",
        ),
        (vec![], move_it.to_owned(), "animations[1].channels[0]: sampler 0 does not exist"),
        (
            vec![r#"{"input":99,"output":0}"#.to_owned()],
            move_it.to_owned(),
            "animations[1].samplers[0]: accessor 99 does not exist",
        ),
        (vec![good.clone()], pointer("/materials/3/emissiveFactor"), "material 3 does not exist"),
        (vec![good.clone()], r#""node":0,"path":"rotation""#.to_owned(), "expected 4"),
    ] {
        let error = shown(&samplers, &target).expect_err("an index to nowhere").to_string();
        assert!(error.contains(text), "{text}: {error}");
    }
}

#[test]
fn moments_share_what_stays() {
    let mut g = Gltf::default();
    let body = bent(&mut g, 1);
    let other = g.floats(&TRIANGLE, "VEC3");
    let body = body.replacen(
        r#""meshes":["#,
        &format!(r#""meshes":[{{"primitives":[{{"attributes":{{"POSITION":{other}}}}}]}},"#),
        1,
    );
    let body = body
        .replace(r#"{"mesh":0,"skin":0,"#, r#"{"mesh":1,"skin":0,"#)
        .replace(r#"{"translation":[0,3,0]}"#, r#"{"translation":[0,3,0]},{"mesh":0}"#);
    let mut scene = g.scene(&body);
    let still = scene.instances()[1].object;
    let still = scene.object(still).meshes[0];
    let held = scene.meshes()[still.index()].clone();
    let before = scene.cursor();
    let posed = scene.pose(0, 0.25);
    assert_eq!((posed.meshes, posed.instances, posed.materials), (1, 0, 0), "the bar bends, nothing else");
    assert_eq!(scene.edits_since(before).collect::<Vec<_>>(), [Edit::Mesh(MeshId(0))], "the log knows");
    let again = scene.cursor();
    assert_eq!(scene.pose(0, 0.25).meshes, 0, "nothing to do");
    assert_eq!(scene.edits_since(again).count(), 0, "and nothing noted");
    assert!(Arc::ptr_eq(&scene.meshes()[still.index()], &held), "what stands still is shared");
    // A world that keeps the mesh that is shown, as commits do: two meshes take turns.
    let mut world = scene.meshes()[0].clone();
    let mut found_positions = Vec::new();
    for k in 0..6 {
        let retained = world.positions.clone();
        scene.pose(0, f64::from(k) / 5.0);
        assert_eq!(world.positions, retained, "a world keeps what it has");
        world = scene.meshes()[0].clone();
        found_positions.push(world.indices.as_ptr());
    }
    found_positions.sort_unstable();
    found_positions.dedup();
    assert!(found_positions.len() <= 2, "indices were copied {} times", found_positions.len());
    // The way there does not matter.
    let mut fresh = g.scene(&body);
    fresh.pose(0, 1.0);
    assert_eq!(fresh.meshes()[0], scene.meshes()[0], "the same moment, the same mesh");
}

#[test]
fn programs_make_animations() {
    let mut scene = Scene::new();
    let object = scene.add_object_of("o", vec![]);
    let instance = scene.instantiate(object, Affine::IDENTITY);
    let sampler = |width| {
        let values = vec![0.0; 2 * width];
        Arc::new(Sampler::new([0.0, 1.0].into(), values, width, Interpolation::Linear).expect("keys"))
    };
    let node = |parent| Node { name: "n".into(), parent, rest: Local::Parts(Trs::default()), visible: true };
    let ground = Attachment::Fixed { world_from_node: Affine::IDENTITY, visible: true };
    let good = Animation {
        nodes: vec![node(ground), node(Attachment::On(0))],
        instances: vec![gnurt_scene::animation::MovingInstance { instance, node: 1, has_transform: true }],
        clips: vec![Clip {
            name: "c".into(),
            channels: vec![Channel { target: Target::Translation(0), sampler: sampler(3) }],
        }],
        ..Animation::default()
    };
    scene.animate(good.clone()).expect("it goes together");
    assert_eq!(scene.pose(0, 0.5).instances, 0, "no way from here to here");
    let holder = scene.add_object_of_members("h", vec![Member::new(object, Affine::IDENTITY)]);
    scene.instantiate(holder, Affine::IDENTITY);
    let values = vec![0.0, 0.0, 0.0, 2.0, 0.0, 0.0];
    let along = Sampler::new([0.0, 1.0].into(), values, 3, Interpolation::Linear).expect("keys");
    let mut nested = good.clone();
    nested.members = vec![MovingMember { object: holder, member: 0, node: 1 }];
    nested.clips[0].channels[0].sampler = Arc::new(along);
    let mut with_members = scene.clone();
    with_members.animate(nested.clone()).expect("it goes together");
    assert_eq!(with_members.pose(0, 0.5).members, 1, "the member moves");
    let found_position = |scene: &Scene| scene.object(holder).members[0].object_from_member;
    assert_eq!(found_position(&with_members), Affine::translation([1.0, 0.0, 0.0]), "with its node");
    assert_eq!(with_members.pose(0, 0.5).members, 0, "nothing to do");
    let exposure = with_members.expose(0, 0.5, 1.0);
    let [((object, 0), found_positions)] = &exposure.members[..] else { panic!("one member: {exposure:?}") };
    assert_eq!(
        (*object, found_positions[found_positions.len() - 1]),
        (holder, Affine::translation([2.0, 0.0, 0.0]))
    );
    assert_eq!(
        found_positions[0],
        found_position(&with_members),
        "it shows the moment at which the shutter opens"
    );
    nested.members[0].member = 1;
    let error = scene.animate(nested).expect_err("no such member").to_string();
    assert_eq!(error, "animation member 0: member 1 does not exist");
    let mut problem = |edit: fn(&mut Animation)| {
        let mut bad = good.clone();
        edit(&mut bad);
        scene.animate(bad).expect_err("a mistake").to_string()
    };
    assert_eq!(
        problem(|a| a.nodes[1].parent = Attachment::On(1)),
        "animation node 1: its parent node 1 does not precede it",
        "a circle"
    );
    assert!(problem(|a| a.instances[0].node = 2).contains("node 2 does not exist"), "an instance");
    let wide = problem(|a| a.clips[0].channels[0].target = Target::Rotation(0));
    assert_eq!(wide, "animation clip 0: a value of 3 numbers drives one of 4", "a width");
    assert!(
        problem(|a| a.clips[0].channels[0].target = Target::Weights(0)).contains("set of weights 0"),
        "a set"
    );
}

#[test]
fn an_open_shutter_sees_the_clip() {
    let mut g = Gltf::default();
    let mesh = g.floats(&TRIANGLE, "VEC3");
    let bulge = g.floats(&[0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 2.0, 0.0], "VEC3");
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let rotation = g.curve(&[0.0, 1.0], &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, half, half], "VEC4", "LINEAR");
    let swell = g.curve(&[0.0, 1.0, 2.0], &[0.0, 1.0, 0.0], "SCALAR", "LINEAR");
    let joint_accessor = g.curve(&[0.0, 0.5], &[1.0, 0.0], "SCALAR", "STEP");
    let clips = clip(
        "all",
        &[rotation, swell, joint_accessor],
        &[
            (0, r#""node":0,"path":"rotation""#),
            (1, r#""node":2,"path":"weights""#),
            (2, &pointer("/nodes/3/extensions/KHR_node_visibility/visible")),
        ],
    );
    let mut scene = g.scene(&format!(
        r#""meshes":[{{"primitives":[{{"attributes":{{"POSITION":{mesh}}}}}]}},
        {{"primitives":[{{"attributes":{{"POSITION":{mesh}}},"targets":[{{"POSITION":{bulge}}}]}}]}}],"animations":[{clips}],
        "nodes":[{{"children":[1]}},{{"mesh":0,"translation":[2,0,0]}},{{"mesh":1}},{{"mesh":0,"translation":[0,0,9]}}]"#
    ));
    let mut posed = scene.clone();
    for (opens, closes) in [(0.25, 0.5), (0.5, 1.5), (1.2, 1.9)] {
        let exposure = scene.expose(0, opens, closes);
        posed.pose(0, opens);
        assert_eq!(scene.instances(), posed.instances(), "it shows the moment at which it opens");
        for (id, found_positions) in &exposure.instances {
            for (i, found_position) in found_positions.iter().enumerate() {
                posed.pose(0, opens + (closes - opens) * i as f64 / (found_positions.len() - 1) as f64);
                assert_eq!(
                    *found_position,
                    posed.instance(*id).world_from_object,
                    "place {i} of {id:?}, {opens}"
                );
            }
        }
        assert_eq!(exposure.instances.len(), usize::from(opens < 1.0), "what turns, while it does");
        let [(id, keys)] = &exposure.meshes[..] else { panic!("one mesh bends: {exposure:?}") };
        for (i, key) in keys.iter().enumerate() {
            posed.pose(0, opens + (closes - opens) * i as f64 / (keys.len() - 1) as f64);
            assert_eq!(key.positions, posed.mesh(*id).positions, "key {i}, {opens}");
        }
        let straight = opens != 0.5;
        assert_eq!(keys.len(), if straight { 2 } else { 3 }, "as few keys as say where it is, {opens}");
        let goes = u32::from(opens < 0.5 && closes >= 0.5);
        assert_eq!(exposure.held, goes as usize, "what goes meanwhile, {opens}");
    }
    assert!(
        scene.expose(0, 0.5, 0.5).is_still() && scene.expose(0, 0.5, f64::NAN).is_still(),
        "closed at once"
    );
    assert!(scene.expose(0, 5.0, 9.0).is_still(), "nothing moves after the last key");
}
