// SPDX-License-Identifier: GPL-3.0-or-later
//! Displaced surfaces beside closed forms: spheres, waves, closed shells, lamps, open shutters, edits.

use std::sync::Arc;

use gnurt_accel::Ray;
use gnurt_render::{CommitError, CommitOptions, CommitReport, ShaderTable, World};
use gnurt_scene::animation::Exposure;
use gnurt_scene::displacement::{Displacement, Offset, Refinement, VectorSpace};
use gnurt_scene::texture::{Filter, TexelData, Texels, Texture, TextureRef, Wrap};
use gnurt_scene::{Affine, InstanceId, Material, MaterialId, Mesh, MeshId, Scene, TextureId};
use gnurt_shading::{AttributeRequest, DisplacementShader, SurfaceBatch, Vec3s};
use gnurt_testkit::Random;

use crate::common::*;

/// An offset by the point, its normal and its coordinates.
type Move = fn([f32; 3], [f32; 3], [f32; 2]) -> [f32; 3];

struct Function(Move);

impl DisplacementShader for Function {
    fn displace(&self, points: &SurfaceBatch, out: &mut Vec3s) {
        for i in 0..points.len() {
            let [p, n] = [points.p.get(i), points.ns.get(i)].map(|v| v.to_array());
            out.set(i, self.0(p, n, points.uv(i)).into());
        }
    }

    fn attributes(&self) -> &[AttributeRequest] {
        &[]
    }
}

fn shaders(all: &[Move]) -> ShaderTable {
    let displacements = all.iter().map(|f| Arc::new(Function(*f)) as _).collect();
    ShaderTable { displacements, ..ShaderTable::default() }
}

fn commit(world: &mut World, scene: &Scene, table: &ShaderTable) -> CommitReport {
    world.commit(scene, table, &CommitOptions::default(), &pool(1)).expect("the scene is sound")
}

fn world(scene: &Scene, table: &ShaderTable) -> World {
    let mut world = World::new();
    let report = commit(&mut world, scene, table);
    assert!(report.warnings.is_empty(), "{:?}", report.warnings);
    world
}

/// A picture of heights, linear floats.
fn picture(width: u32, height: u32, mut at: impl FnMut(u32, u32) -> [f32; 4]) -> Texture {
    let all = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let data = TexelData::Float(all.map(|(x, y)| at(x, y)).collect());
    let texels = Arc::new(Texels { width, height, data });
    Texture { name: "heights".into(), texels, wrap: [Wrap::Repeat; 2], filter: Filter::Linear }
}

fn constant(x: f32) -> Displacement {
    Displacement::new(Offset::Constant(x))
}

/// How far a ray goes.
fn hits(world: &World, ray: &Ray) -> f32 {
    world.intersect(ray).map_or(f32::INFINITY, |hit| hit.t)
}

/// The direction of a vector.
fn unit(v: [f32; 3]) -> [f32; 3] {
    let length = v.iter().map(|x| x * x).sum::<f32>().sqrt();
    if length > 0.0 { v.map(|x| x / length) } else { [0.0, 0.0, 1.0] }
}

#[test]
fn a_sphere_and_a_constant_are_a_larger_sphere() {
    let ball = |radius: f32, displaced: Option<f32>| {
        let mut scene = Scene::new();
        let material = matte(&mut scene, [0.5; 3]);
        put_mesh(&mut scene, sphere([0.3, -0.2, 0.1], radius, 200, material));
        scene.set_displacement(material, displaced.map(constant));
        scene
    };
    let none = ShaderTable::default();
    let [moved, large] = [ball(1.0, Some(0.25)), ball(1.25, None)].map(|scene| world(&scene, &none));
    let by_shader = {
        let mut scene = ball(1.0, None);
        scene.set_displacement(MaterialId(0), Some(Displacement::new(Offset::Shader(0))));
        world(&scene, &shaders(&[|_, n, _| n.map(|x| 0.25 * x)]))
    };
    let mut random = Random::new(3);
    for _ in 0..2000 {
        let from = unit(random.point()).map(|x| 4.0 * x);
        let to: [f32; 3] = random.point().map(|x| 0.5 * x);
        let dir = [0, 1, 2].map(|k| to[k] - from[k]);
        let length = dir.iter().map(|x| x * x).sum::<f32>().sqrt();
        let ray = Ray::new(from, dir.map(|x| x / length));
        let expected = hits(&large, &ray);
        for world in [&moved, &by_shader] {
            let t = hits(world, &ray);
            assert!(t == expected || (t - expected).abs() < 1e-5, "{t} instead of {expected}");
        }
        if expected.is_finite() {
            let p = [0, 1, 2].map(|k| f64::from(ray.org[k]) + f64::from(ray.dir[k]) * f64::from(expected));
            let radius = (p[0] - 0.3).hypot(p[1] + 0.2).hypot(p[2] - 0.1);
            assert!((radius - 1.25).abs() < 2.5e-4, "the closed form, within the sagitta: {radius}");
        }
    }
}

/// A sheet over `[0, 1]^2` with its coordinates, of few triangles.
fn sheet(scene: &mut Scene, displacement: Displacement) -> MaterialId {
    let material = matte(scene, [0.5; 3]);
    let mut mesh = quad([0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], material);
    mesh.normals = vec![[0.0, 0.0, 1.0]; 4];
    put_mesh(scene, mesh);
    scene.set_displacement(material, Some(displacement));
    material
}

const WAVES: f32 = 2.0 * std::f32::consts::TAU;

/// Height and slope of the wave.
fn wave(x: f32) -> [f32; 2] {
    [0.1 * (WAVES * x).sin(), 0.1 * WAVES * (WAVES * x).cos()]
}

#[test]
fn waves_by_texture_and_by_shader_are_the_sine() {
    let refinement = Refinement::Edges(0.01);
    let mut of_texture = Scene::new();
    let width = 2048;
    // Half-way up is level: the numbers are between 0 and 1.
    let texture = of_texture.add_texture(picture(width, 1, |x, _| {
        let [height, _] = wave((x as f32 + 0.5) / width as f32);
        [0.0, height / 0.4 + 0.5, 0.0, 1.0]
    }));
    let offset = Offset::Height { texture: TextureRef::new(texture), channel: 1 };
    sheet(&mut of_texture, Displacement { offset, scale: 0.4, midlevel: 0.5, refinement });
    let mut of_shader = Scene::new();
    sheet(&mut of_shader, Displacement { refinement, ..Displacement::new(Offset::Shader(0)) });
    let table = shaders(&[|p, n, _| n.map(|x| wave(p[0])[0] * x)]);
    let mut of_levels = Scene::new();
    let levels = Refinement::Levels(8);
    sheet(&mut of_levels, Displacement { refinement: levels, ..Displacement::new(Offset::Shader(1)) });
    let more = shaders(&[|_, _, _| [0.0; 3], |_, n, uv| n.map(|x| wave(uv[0])[0] * x)]);
    let worlds = [
        ("texture", world(&of_texture, &ShaderTable::default())),
        ("shader", world(&of_shader, &table)),
        ("levels", world(&of_levels, &more)),
    ];
    let mut random = Random::new(7);
    for _ in 0..2000 {
        let [x, y] = [(); 2].map(|()| random.between(0.001, 0.999));
        let ray = Ray::new([x, y, 1.0], [0.0, 0.0, -1.0]);
        let [height, slope] = wave(x);
        for (name, world) in &worlds {
            let hit = world.intersect(&ray).unwrap_or_else(|| panic!("{name}: a hole at {x}, {y}"));
            let found = 1.0 - hit.t;
            assert!((found - height).abs() < 3e-4, "{name}: {found} instead of {height} at {x}");
            let [nx, _, nz] = world.normal(&hit).expect("a triangle");
            assert!((-nx / nz - slope).abs() < 0.1, "{name}: slope {} instead of {slope}", -nx / nz);
        }
    }
    assert_eq!(worlds[2].1.stats().triangles, 2 << 16, "eight levels");
}

/// A cube of six sides that share no vertices; each has coordinates of its own, and every other one another material.
fn shell(materials: [MaterialId; 2]) -> Vec<Mesh> {
    let mut meshes: Vec<Mesh> = Vec::new();
    for axis in 0..3 {
        for side in [-1.0_f32, 1.0] {
            let unit =
                |k: usize, x: f32| -> [f32; 3] { std::array::from_fn(|i| if i == k { x } else { 0.0 }) };
            let (a, b) = ((axis + 1) % 3, (axis + 2) % 3);
            let mut corner = [-1.0; 3];
            corner[axis] = side;
            let (a, b) = if side > 0.0 { (a, b) } else { (b, a) };
            let mut mesh = quad(corner, unit(a, 2.0), unit(b, 2.0), materials[meshes.len() % 2]);
            mesh.normals = vec![unit(axis, side); 4];
            meshes.push(mesh);
        }
    }
    meshes
}

#[test]
fn closed_shells_stay_closed() {
    let mut random = Random::new(11);
    let noise = picture(37, 29, |_, _| [random.unit(), random.unit(), random.unit(), 1.0]);
    let offsets: [fn(TextureId) -> Offset; 3] = [
        |texture| Offset::Height { texture: TextureRef::new(texture), channel: 0 },
        |texture| Offset::Vector { texture: TextureRef::new(texture), space: VectorSpace::Object },
        |texture| Offset::Vector { texture: TextureRef::new(texture), space: VectorSpace::Tangent },
    ];
    for (case, offset) in offsets.into_iter().enumerate() {
        for both in [true, false] {
            for refinement in [Refinement::Levels(5), Refinement::Edges(0.11)] {
                let mut scene = Scene::new();
                let texture = scene.add_texture(noise.clone());
                let materials = [matte(&mut scene, [0.5; 3]), matte(&mut scene, [0.2; 3])];
                let meshes = shell(materials).into_iter().map(|mesh| scene.add_mesh(mesh)).collect();
                let object = scene.add_object_of("shell", meshes);
                scene.instantiate(object, Affine::IDENTITY);
                let offset = offset(texture);
                let displacement = Displacement { offset, scale: 0.2, midlevel: 0.3, refinement };
                scene.set_displacement(materials[0], Some(displacement));
                // The others may stay, or move otherwise; all are cut alike.
                let other = Displacement { scale: -0.3, refinement: Refinement::None, ..displacement };
                scene.set_displacement(materials[1], both.then_some(other));
                let world = world(&scene, &ShaderTable::default());
                let mut random = Random::new(5);
                for ray in 0..4000 {
                    let from = random.point().map(|x| 0.3 * x);
                    let dir = unit(random.point());
                    let is_hit = world.occluded(&Ray::new(from, dir));
                    assert!(is_hit, "case {case}, {refinement:?}, both {both}: ray {ray} escapes");
                }
            }
        }
    }
}

#[test]
fn normals_follow_and_edges_stay_hard() {
    let mut scene = Scene::new();
    let material = matte(&mut scene, [0.5; 3]);
    // A box whose corners have one normal for each side: these stay level, though the rims move outwards.
    let mut meshes = shell([material; 2]);
    meshes.iter_mut().for_each(|mesh| mesh.texcoords.clear());
    let ids = meshes.into_iter().map(|mesh| scene.add_mesh(mesh)).collect();
    let object = scene.add_object_of("box", ids);
    scene.instantiate(object, Affine::IDENTITY);
    let refinement = Refinement::Levels(4);
    scene.set_displacement(material, Some(Displacement { refinement, ..constant(0.5) }));
    let world = world(&scene, &ShaderTable::default());
    let side = world.intersect(&Ray::new([0.1, 0.2, 5.0], [0.0, 0.0, -1.0])).expect("the upper side");
    assert!((side.t - 3.5).abs() < 1e-6, "it moved by as much: {}", side.t);
    assert_eq!(world.normal(&side), Some([0.0, 0.0, 1.0]), "and is level");
    let corner = world.bounds().expect("a box");
    let reach = 1.5_f32.max(1.0 + 0.5 * 0.5_f32.sqrt());
    assert!((corner.1[0] - reach).abs() < 1e-5, "{corner:?}");
}

#[test]
fn lamps_shine_by_their_new_areas() {
    let lit = |radius: f32, displaced: Option<f32>| {
        let mut scene = floor(0.5, 40.0);
        let shine = emitter(&mut scene, [1.0; 3]);
        put_mesh(&mut scene, sphere([0.0, 0.0, 10.0], radius, 24, shine));
        scene.set_displacement(shine, displaced.map(constant));
        radiance_at(&scene, [3.0, 0.0, 20.0], [3.0, 0.0, 0.0], 64)[0]
    };
    let [small, moved, large] = [lit(1.0, None), lit(1.0, Some(0.5)), lit(1.5, None)];
    assert_close(moved, large, 1e-3, "as a lamp of that size");
    assert_close(moved, small * 2.25, 0.02, "by the area of it");
}

#[test]
fn shutters_instances_and_edits_follow() {
    let mut scene = Scene::new();
    let material = sheet(&mut scene, Displacement { refinement: Refinement::Levels(1), ..constant(0.5) });
    scene.instantiate(
        gnurt_scene::ObjectId(0),
        Affine::translation([3.0, 0.0, 0.0]) * Affine::scale([1.0, 1.0, 2.0]),
    );
    let mesh = scene.meshes()[0].clone();
    // At the end it stands upright, and moves along its normal then.
    let mut turned = Mesh::clone(&mesh);
    turned.positions.iter_mut().for_each(|p| *p = [p[2], p[1], -p[0]]);
    turned.normals.iter_mut().for_each(|n| *n = [n[2], n[1], -n[0]]);
    let keys = vec![mesh, Arc::new(turned)];
    let exposure = Exposure { meshes: vec![(MeshId(0), keys)], ..Exposure::default() };
    let (mut world, pool, how) = (World::new(), pool(1), CommitOptions::default());
    let none = ShaderTable::default();
    world.commit_exposed(&scene, &exposure, &none, &how, &pool).expect("sound");
    let down = Ray::new([0.3, 0.4, 5.0], [0.0, 0.0, -1.0]);
    let across = Ray::new([5.0, 0.4, -0.3], [-1.0, 0.0, 0.0]);
    let opened = Ray { time: 0.0, ..down };
    assert!((hits(&world, &opened) - 4.5).abs() < 1e-6, "when it opens: {}", hits(&world, &opened));
    let closed = Ray { time: 1.0, ..across };
    let closed_at = hits(&world, &Ray { org: [2.0, 0.4, -0.3], ..closed });
    assert!((closed_at - 1.5).abs() < 1e-5, "when it closes, along the normal then: {closed_at}");
    // An edit of the displacement is one of the object, and of nothing else.
    commit(&mut world, &scene, &none);
    assert!((hits(&world, &down) - 4.5).abs() < 1e-6);
    let second = Ray { org: [3.3, 0.4, 5.0], ..down };
    assert!((hits(&world, &second) - 4.0).abs() < 1e-6, "the instance is scaled: {}", hits(&world, &second));
    assert_eq!(commit(&mut world, &scene, &none).built_objects, 0, "nothing has changed");
    scene.edit_material(material).emission = [1.0; 3];
    let report = commit(&mut world, &scene, &none);
    assert_eq!((report.built_objects, report.refitted_objects), (0, 0), "its colour moves nothing");
    scene.set_displacement(
        material,
        Some(Displacement { refinement: Refinement::Levels(1), ..constant(0.75) }),
    );
    let report = commit(&mut world, &scene, &none);
    assert_eq!(report.built_objects + report.refitted_objects, 1, "another height");
    assert!((hits(&world, &down) - 4.25).abs() < 1e-6);
    scene.edit_instance(InstanceId(1)).visible = false;
    scene.set_displacement(material, None);
    commit(&mut world, &scene, &none);
    assert_eq!(hits(&world, &down), 5.0, "none any more");
    assert_eq!(world.stats().triangles, 2, "nor finer triangles");
}

#[test]
fn shaders_and_textures_are_followed() {
    let (mut scene, mut world) = (Scene::new(), World::new());
    let texture = scene.add_texture(picture(1, 1, |_, _| [0.25; 4]));
    let reference = TextureRef::new(texture);
    let material = sheet(&mut scene, Displacement::new(Offset::Height { texture: reference, channel: 2 }));
    let down = Ray::new([0.3, 0.4, 5.0], [0.0, 0.0, -1.0]);
    commit(&mut world, &scene, &ShaderTable::default());
    assert_eq!(hits(&world, &down), 4.75, "by the texture");
    *scene.edit_texture(texture) = picture(1, 1, |_, _| [0.5; 4]);
    commit(&mut world, &scene, &ShaderTable::default());
    assert_eq!(hits(&world, &down), 4.5, "by the next one");
    scene.set_displacement(material, Some(Displacement::new(Offset::Shader(0))));
    let fault = world.commit(&scene, &ShaderTable::default(), &CommitOptions::default(), &pool(1));
    let expected = CommitError::UnknownDisplacement { material: 0, shader: 0, known: 0 };
    assert_eq!(fault, Err(expected), "a shader that is not there");
    commit(&mut world, &scene, &shaders(&[|_, _, _| [0.0, 0.0, 1.0]]));
    assert_eq!(hits(&world, &down), 4.0, "by a shader");
    commit(&mut world, &scene, &shaders(&[|_, _, _| [0.0, 0.0, 2.0]]));
    assert_eq!(hits(&world, &down), 3.0, "by another one in its place");
    let report = commit(&mut world, &scene, &shaders(&[|_, _, _| [0.0, 0.0, f32::NAN]]));
    assert_eq!(hits(&world, &down), 5.0, "numbers that are none move nothing");
    assert_eq!(report.warnings, ["mesh '': 4 vertices with infinite displacement stay in place"]);
}

#[test]
fn undisplaced_surfaces_keep_their_bits() {
    let mut scene = floor(0.5, 4.0);
    put_mesh(&mut scene, sphere([0.0, 0.0, 1.0], 1.0, 12, MaterialId(0)));
    let other = scene.add_material(Material::matte("other", [0.3; 3]));
    let plain = frame(&scene, &camera([5.0, 1.0, 3.0], [0.0; 3], 40.0), &options(24, 24, 4)).picture;
    scene.set_displacement(other, Some(constant(1.0)));
    let beside = frame(&scene, &camera([5.0, 1.0, 3.0], [0.0; 3], 40.0), &options(24, 24, 4)).picture;
    assert_eq!(plain.color, beside.color, "of another material");
    scene.set_displacement(MaterialId(0), Some(constant(0.0)));
    let zero = frame(&scene, &camera([5.0, 1.0, 3.0], [0.0; 3], 40.0), &options(24, 24, 4)).picture;
    assert_eq!(plain.color, zero.color, "by nothing");
}
