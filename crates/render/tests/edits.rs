// SPDX-License-Identifier: GPL-3.0-or-later
//! Random edits, each followed by a commit: the world is that of a fresh commit, picture for picture, bit for bit, and a frame
//! in flight keeps the world that it began with. `GNURT_EDITS=n` asks for n edits;
//! of very many, some are looked at.

use std::sync::Arc;

use crate::common::*;
use glam::Vec3;
use gnurt_image::{TexelData, Texels};
use gnurt_render::{
    CommitOptions, CommitReport, Integrator, RenderOptions, SceneCamera, ShaderTable, Silent, World,
    WorldStats, render,
};
use gnurt_scene::material::{Alpha, Color, Opacity, OpacityChannel, TextureRef};
use gnurt_scene::texture::{Filter, Texture, Wrap};
use gnurt_scene::{
    Affine, CameraId, InstanceId, Light, LightId, Material, MaterialId, Member, Mesh, MeshId, Motion, Object,
    ObjectId, RayMask, Scene, Surface, TextureId,
};
use gnurt_shading::{
    EnvironmentShader, LightBatch, LightShader, RadianceShader, SurfaceBatch, SurfaceShader, Tracer, Vec3s,
};

/// A surface of the shader table.
struct ShaderEmission(Vec3);

impl RadianceShader for ShaderEmission {
    fn shade(&self, _: &mut dyn Tracer, hits: &SurfaceBatch, out: &mut Vec3s) {
        (0..hits.len()).for_each(|i| out.set(i, self.0));
    }
}

impl SurfaceShader for ShaderEmission {
    fn radiance(&self) -> Option<&dyn RadianceShader> {
        Some(self)
    }
}

/// A light of the shader table.
struct PluginLight(Vec3);

impl LightShader for PluginLight {
    fn illuminate(&self, p: &Vec3s, _: &Vec3s, _: &[[f32; 2]], out: &mut LightBatch) {
        for i in 0..p.len() {
            let offset = self.0 - p.get(i);
            out.dir.set(i, offset.normalize());
            out.dist[i] = offset.length();
            out.radiance.set(i, Vec3::splat(3.0 / offset.length_squared()));
        }
    }
}

/// An environment of the shader table.
struct Sky(Vec3);

impl EnvironmentShader for Sky {
    fn miss(&self, dir: &Vec3s, out: &mut Vec3s) {
        (0..dir.len()).for_each(|i| out.set(i, self.0));
    }
}

/// Numbers that look random.
struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % n
    }

    fn within(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.below(1 << 20) as f32 / (1 << 20) as f32
    }

    fn vector(&mut self, low: f32, high: f32) -> [f32; 3] {
        [(); 3].map(|()| self.within(low, high))
    }
}

const MESHES: usize = 8;
const OBJECTS: usize = 6;
const INSTANCES: usize = 12;
const MATERIALS: usize = 7;
const TEXTURES: usize = 3;
const LIGHTS: usize = 4;

fn any_mesh(random: &mut Random) -> Mesh {
    let material = MaterialId(random.below(MATERIALS) as u32);
    if random.below(3) == 0 {
        quad(random.vector(-1.0, 0.0), [1.0, 0.0, 0.0], random.vector(-1.0, 1.0), material)
    } else {
        let radius = random.within(0.2, 0.8);
        sphere(random.vector(-0.5, 0.5), radius, 3 + random.below(4) as u32, material)
    }
}

fn any_place(random: &mut Random) -> Affine {
    let mut transform = Affine::translation(random.vector(-2.5, 2.5).map(f64::from));
    for k in 0..3 {
        transform.columns[k][k] = f64::from(random.within(0.3, 1.2));
        transform.columns[k][(k + 1) % 3] = f64::from(random.within(-0.2, 0.2));
    }
    match random.below(16) {
        // Mirrored, flat, or no place at all.
        0 => transform.columns[0] = transform.columns[0].map(|x| -x),
        1 => transform.columns[1] = [0.0; 3],
        2 => transform.columns[3][0] = f64::NAN,
        _ => {}
    }
    transform
}

/// An object below `end` in another.
fn any_member(random: &mut Random, end: usize) -> Member {
    let mask = RayMask(if random.below(4) == 0 { random.below(8) as u32 } else { u32::MAX });
    Member { object: ObjectId(random.below(end) as u32), object_from_member: any_place(random), mask }
}

fn any_texture(random: &mut Random) -> Texture {
    let (width, height) = (1 + random.below(4) as u32, 1 + random.below(4) as u32);
    let texels = (0..width * height).map(|_| {
        let [r, g, b] = random.vector(0.0, 1.5);
        [r, g, b, random.within(0.0, 1.0)]
    });
    let data = TexelData::Float(texels.collect());
    let texels = Arc::new(Texels { width, height, data });
    Texture { name: String::new(), texels, wrap: [Wrap::Repeat; 2], filter: Filter::Linear }
}

fn any_reference(random: &mut Random) -> Option<TextureRef> {
    (random.below(3) == 0).then(|| TextureRef::new(TextureId(random.below(TEXTURES) as u32)))
}

fn any_material(random: &mut Random) -> Material {
    let color = Color { factor: random.vector(0.1, 0.9), texture: any_reference(random) };
    let surface = match random.below(6) {
        0 => Surface::Mirror { reflectance: color },
        1 => Surface::Dielectric {
            ior: 1.5,
            reflectance: [1.0; 3],
            transmittance: [1.0; 3],
            interior: Default::default(),
        },
        2 => Surface::Shader(random.below(2) as u32),
        _ => Surface::Matte { base_color: color },
    };
    let mut material = Material::of("", surface);
    if random.below(4) == 0 {
        (material.emission, material.emission_texture) = (random.vector(0.5, 3.0), any_reference(random));
    }
    if random.below(5) == 0 {
        let (factor, texture) = (random.within(0.2, 1.0), any_reference(random));
        let opacity = Opacity { factor, texture, channel: OpacityChannel::Alpha };
        material.alpha = if random.below(2) == 0 {
            Alpha::Blend { opacity }
        } else {
            Alpha::Mask { cutoff: 0.5, opacity }
        };
    }
    material
}

fn any_light(random: &mut Random) -> Light {
    let (position, direction) = (random.vector(-3.0, 3.0), random.vector(-1.0, 1.0));
    let [inner_angle, outer_angle] = [0.4, 0.8];
    match random.below(6) {
        0 => Light::Point { position, intensity: [4.0; 3], radius: 0.0 },
        1 => Light::Spot {
            position,
            direction,
            intensity: [9.0; 3],
            inner_angle,
            outer_angle,
            edge: gnurt_scene::ConeEdge::default(),
            radius: 0.0,
        },
        2 => Light::Directional { direction, irradiance: [0.7; 3], angle: 0.0 },
        3 => environment([0.3 * random.below(3) as f32; 3]),
        _ => {
            let mut world_from_light = Affine::IDENTITY;
            world_from_light.columns.swap(0, random.below(3));
            let texture = Some(TextureId(random.below(TEXTURES) as u32));
            Light::Environment {
                radiance: [0.5 + 0.5 * random.below(2) as f32; 3],
                texture,
                world_from_light,
            }
        }
    }
}

/// A scene, and shaders beside it.
struct Edited {
    scene: Scene,
    shaders: ShaderTable,
}

impl Edited {
    fn new(random: &mut Random) -> Self {
        let mut scene = Scene::new();
        (0..TEXTURES).for_each(|_| _ = scene.add_texture(any_texture(random)));
        (0..MATERIALS).for_each(|_| _ = scene.add_material(any_material(random)));
        scene.add_mesh(any_mesh(random));
        let object = scene.add_object_of("", vec![MeshId(0)]);
        scene.instantiate(object, Affine::IDENTITY);
        scene.add_light(environment([0.4; 3]));
        scene.add_camera(gnurt_scene::Camera {
            name: String::new(),
            eye: [0.0, -7.0, 1.0],
            target: [0.0; 3],
            up: [0.0, 0.0, 1.0],
            fov_y: 40.0,
            ..gnurt_scene::Camera::default()
        });
        let surface = |x| Arc::new(ShaderEmission(Vec3::splat(x))) as Arc<dyn SurfaceShader>;
        let shaders = ShaderTable { surfaces: vec![surface(0.2), surface(0.7)], ..ShaderTable::default() };
        Self { scene, shaders }
    }

    /// Makes a random edit; returns its description.
    fn edit(&mut self, random: &mut Random) -> &'static str {
        let Self { scene, shaders } = self;
        let instance = InstanceId(random.below(scene.instances().len()) as u32);
        let mesh = MeshId(random.below(scene.meshes().len()) as u32);
        let object = ObjectId(random.below(scene.objects().len()) as u32);
        let material = MaterialId(random.below(MATERIALS) as u32);
        match random.below(27) {
            0..3 if scene.instances().len() < INSTANCES => {
                scene.instantiate(object, any_place(random));
                "an instance more"
            }
            3 if scene.meshes().len() < MESHES => {
                scene.add_mesh(any_mesh(random));
                "a mesh more"
            }
            4 if scene.objects().len() < OBJECTS => {
                let motion = [Motion::Auto, Motion::Rigid, Motion::Deforming, Motion::Known][random.below(4)];
                scene.add_object(Object { meshes: vec![mesh], motion, ..Object::default() });
                "an object more"
            }
            5 | 6 => {
                scene.edit_instance(instance).world_from_object = any_place(random);
                "a move"
            }
            7 => {
                scene.edit_mesh(mesh).positions.iter_mut().for_each(|p| p[2] *= 0.9);
                "a deformation"
            }
            8 => {
                scene.edit_mesh(mesh).texcoords.iter_mut().for_each(|uv| uv[0] += 0.3);
                scene.edit_mesh(mesh).normals.clear();
                "other attributes"
            }
            9 => {
                scene.edit_mesh(mesh).material = material;
                "another material"
            }
            10 => {
                scene.replace_mesh(mesh, any_mesh(random));
                "a mesh defined again"
            }
            11 => {
                let meshes = &mut scene.edit_object(object).meshes;
                if random.below(3) == 0 {
                    meshes.clear()
                } else {
                    meshes.push(mesh)
                }
                "an object defined again"
            }
            12 => {
                let instance = scene.edit_instance(instance);
                instance.visible = !instance.visible;
                "an instance gone or back"
            }
            13 => {
                scene.edit_instance(instance).mask = RayMask(random.below(8) as u32);
                "other rays"
            }
            14 => {
                scene.edit_instance(instance).object = object;
                "another object"
            }
            15 | 16 => {
                *scene.edit_material(material) = any_material(random);
                "a material"
            }
            17 => {
                let color = Color::constant(random.vector(0.1, 0.9));
                scene.edit_material(material).surface = Surface::Matte { base_color: color };
                "a shader's parameter"
            }
            18 => {
                *scene.edit_texture(TextureId(random.below(TEXTURES) as u32)) = any_texture(random);
                "a texture"
            }
            19 if scene.lights().len() < LIGHTS => {
                scene.add_light(any_light(random));
                "a light more"
            }
            19 | 20 => {
                let light = LightId(random.below(scene.lights().len()) as u32);
                *scene.edit_light(light) = any_light(random);
                "a light"
            }
            21 => {
                let number = random.below(2);
                shaders.surfaces[number] = Arc::new(ShaderEmission(Vec3::from(random.vector(0.0, 1.0))));
                "a shader of the table"
            }
            22 => {
                match random.below(4) {
                    0 => shaders.lights.push(Arc::new(PluginLight(Vec3::from(random.vector(-3.0, 3.0))))),
                    1 => shaders.lights.clear(),
                    2 => shaders.environment = Some(Arc::new(Sky(Vec3::from(random.vector(0.0, 0.5))))),
                    _ => shaders.environment = None,
                }
                "a light of the table"
            }
            23 if scene.objects().len() < OBJECTS => {
                let members = (0..1 + random.below(3)).map(|_| any_member(random, scene.objects().len()));
                scene.add_object_of_members("", members.collect());
                "an object made of objects"
            }
            // An object holds only earlier objects, so that none holds itself.
            24 | 25 if object.index() > 0 => {
                let members = &mut scene.edit_object(object).members;
                match random.below(4) {
                    0 => members.push(any_member(random, object.index())),
                    1 => members.truncate(1),
                    _ => members.iter_mut().for_each(|member| *member = any_member(random, object.index())),
                }
                "other members"
            }
            _ => {
                scene.edit_camera(CameraId(0)).eye = [random.within(-1.0, 1.0), -7.0, 1.0];
                "the camera"
            }
        }
    }

    fn commit(&self, world: &mut World, pool: &rayon::ThreadPool) -> CommitReport {
        let options = CommitOptions::default();
        world.commit(&self.scene, &self.shaders, &options, pool).expect("all ids name something")
    }

    /// How many own each mesh: the scene, and each object that a visible instance shows, by itself or within another.
    fn owners(&self) -> Vec<usize> {
        let mut owners = vec![1; self.scene.meshes().len()];
        let mut shown: Vec<*const Object> =
            self.scene.occurrences().map(|it| std::ptr::from_ref(it.object)).collect();
        shown.sort_unstable();
        shown.dedup();
        for object in
            self.scene.objects().iter().filter(|object| shown.contains(&std::ptr::from_ref(*object)))
        {
            object.meshes.iter().for_each(|mesh| owners[mesh.index()] += 1);
        }
        owners
    }
}

const SIZE: [u32; 2] = [12, 9];

fn picture(
    world: &World,
    camera: &SceneCamera,
    integrator: Integrator,
    pool: &rayon::ThreadPool,
) -> Vec<[f32; 4]> {
    let [width, height] = SIZE;
    let options = RenderOptions { integrator, vpls: 16, max_depth: 4, ..options(width, height, 1) };
    render(world, camera, &options, pool, &Silent).expect("sound options").picture.color
}

const INTEGRATORS: [Integrator; 5] = [
    Integrator::Path,
    Integrator::Whitted,
    Integrator::Eyelight,
    Integrator::InstantRadiosity,
    Integrator::BidirectionalInstantRadiosity,
];

fn bits(picture: &[[f32; 4]]) -> Vec<[u32; 4]> {
    picture.iter().map(|pixel| pixel.map(f32::to_bits)).collect()
}

/// How many edits are made, of how many each scene gets, and how many commits go by between two that are looked at.
struct Length {
    edits: usize,
    of_one_scene: usize,
    look_at_each: usize,
}

impl Length {
    /// The request in `GNURT_EDITS`: a few fully checked scenes, or long runs with some ten thousand checks.
    fn requests() -> Self {
        let edits: usize = std::env::var("GNURT_EDITS").ok().and_then(|n| n.parse().ok()).unwrap_or(160);
        let of_one_scene = if edits > 10_000 { edits.div_ceil(8) } else { 80 };
        Self { edits, of_one_scene, look_at_each: (edits / 10_000).max(1) }
    }
}

#[test]
fn any_edit_leads_to_the_picture_of_a_fresh_world() {
    let Length { edits, of_one_scene, look_at_each } = Length::requests();
    let (pool, other_pool) = (pool(2), pool(1));
    for seed in 0..edits.div_ceil(of_one_scene) as u64 {
        let mut random = Random(seed);
        let (mut edited, mut world) = (Edited::new(&mut random), World::new());
        edited.commit(&mut world, &pool);
        let resident_at_first = resident();
        for step in 0..of_one_scene {
            if step % look_at_each != 0 {
                edited.edit(&mut random);
                edited.commit(&mut world, &pool);
                continue;
            }
            let integrator = INTEGRATORS[random.below(INTEGRATORS.len())];
            let camera = SceneCamera::new(&edited.scene.cameras()[0]).expect("a view");
            let before = world.clone();
            let seen_before = picture(&before, &camera, integrator, &pool);
            let what: Vec<_> = (0..1 + random.below(2)).map(|_| edited.edit(&mut random)).collect();
            let what = format!("seed {seed}, step {step}, {integrator}: {}", what.join(", "));
            // A frame is in flight meanwhile.
            let (report, in_flight) = std::thread::scope(|scope| {
                let frame = scope.spawn(|| picture(&before, &camera, integrator, &other_pool));
                (edited.commit(&mut world, &pool), frame.join().expect("a picture"))
            });
            assert!(bits(&in_flight) == bits(&seen_before), "{what}: the frame in flight keeps its world");
            drop(before);
            let mut fresh = World::new();
            let whole = edited.commit(&mut fresh, &pool);
            let camera = SceneCamera::new(&edited.scene.cameras()[0]).expect("a view");
            let [found, expected] =
                [&world, &fresh].map(|world| bits(&picture(world, &camera, integrator, &pool)));
            assert!(found == expected, "{what}: the picture of a fresh world");
            // A tree that was refitted has other nodes than one that was built, and knows more.
            let sizes = |world: &World| WorldStats { tree_nodes: 0, tree_bytes: 0, ..world.stats() };
            assert_eq!(sizes(&world), sizes(&fresh), "{what}: sizes");
            assert_eq!(
                [report.dropped_triangles, report.dropped_instances],
                [whole.dropped_triangles, whole.dropped_instances],
                "{what}: triangles and instances left out"
            );
            drop(fresh);
            let owners: Vec<usize> = edited.scene.meshes().iter().map(Arc::strong_count).collect();
            assert_eq!(owners, edited.owners(), "{what}: who has each mesh");
        }
        // The scenes are small: a leak for each edit would exceed this.
        let grown = resident().saturating_sub(resident_at_first);
        eprintln!("seed {seed}: {of_one_scene} commits, {} MB more in memory", grown >> 20);
        assert!(grown < (64 << 20), "seed {seed}: {grown} bytes more in memory");
    }
}

/// Resident bytes of the process; 0 if unknown.
fn resident() -> u64 {
    let pages = std::fs::read_to_string("/proc/self/statm").unwrap_or_default();
    pages.split(' ').nth(1).and_then(|pages| pages.parse::<u64>().ok()).unwrap_or(0) * 4096
}

/// A camera edit and invisible things cost nothing; a world of another scene is rebuilt.
#[test]
fn what_is_not_due_is_not_made() {
    let mut random = Random(7);
    let (mut edited, mut world, pool) = (Edited::new(&mut random), World::new(), pool(2));
    edited.commit(&mut world, &pool);
    let nothing = |report: CommitReport| {
        let cached =
            CommitReport { build_seconds: 0.0, dropped_triangles: 0, dropped_instances: 0, ..report };
        assert_eq!(cached, CommitReport::default(), "nothing was due");
    };
    nothing(edited.commit(&mut world, &pool));
    edited.scene.edit_camera(CameraId(0)).eye[0] = 1.0;
    nothing(edited.commit(&mut world, &pool));
    edited.scene.add_mesh(any_mesh(&mut random));
    edited.scene.add_object_of("unseen", vec![MeshId(1)]);
    nothing(edited.commit(&mut world, &pool));
    let object = ObjectId(1);
    let instance = gnurt_scene::Instance {
        name: String::new(),
        object,
        world_from_object: Affine::IDENTITY,
        visible: false,
        mask: RayMask::ALL,
    };
    let instance = edited.scene.add_instance(instance);
    edited.scene.edit_mesh(MeshId(1)).positions[0][0] += 0.1;
    nothing(edited.commit(&mut world, &pool));
    // The same light again is no other light.
    _ = edited.scene.edit_light(LightId(0));
    nothing(edited.commit(&mut world, &pool));

    edited.scene.edit_instance(instance).visible = true;
    let report = edited.commit(&mut world, &pool);
    assert_eq!((report.built_objects, report.placed_instances, report.made_shaders), (1, 1, 0), "it comes");
    assert!(report.built_top_tree, "and is in the tree");
    edited.scene.edit_mesh(MeshId(1)).texcoords.push([0.5; 2]);
    let report = edited.commit(&mut world, &pool);
    assert_eq!((report.built_objects, report.placed_instances), (0, 1), "triangles stay");
    assert!(!report.built_top_tree, "so do boxes");

    let copy = Edited { scene: edited.scene.clone(), shaders: edited.shaders.clone() };
    edited.scene.edit_instance(instance).visible = false;
    edited.commit(&mut world, &pool);
    let report = copy.commit(&mut world, &pool);
    assert_eq!(report.built_objects, 2, "a copy of a scene is another scene");
    let camera = SceneCamera::new(&copy.scene.cameras()[0]).expect("a view");
    let mut fresh = World::new();
    copy.commit(&mut fresh, &pool);
    let [found, expected] = [&world, &fresh].map(|world| picture(world, &camera, Integrator::Path, &pool));
    assert_eq!(bits(&found), bits(&expected), "and the world shows it");
}

/// An error leaves the world as it was, and the edits for the next commit.
#[test]
fn errors_change_nothing() {
    let mut random = Random(3);
    let (mut edited, mut world, pool) = (Edited::new(&mut random), World::new(), pool(2));
    edited.commit(&mut world, &pool);
    let camera = SceneCamera::new(&edited.scene.cameras()[0]).expect("a view");
    let before = picture(&world, &camera, Integrator::Path, &pool);
    edited.scene.edit_instance(InstanceId(0)).world_from_object = Affine::translation([0.5, 0.0, 0.0]);
    edited.scene.edit_material(MaterialId(0)).surface = Surface::Shader(9);
    let refused = world.commit(&edited.scene, &edited.shaders, &CommitOptions::default(), &pool);
    assert!(refused.is_err(), "there is no shader 9");
    assert_eq!(bits(&picture(&world, &camera, Integrator::Path, &pool)), bits(&before), "as it was");
    edited.scene.edit_material(MaterialId(0)).surface = Surface::Shader(1);
    let report = edited.commit(&mut world, &pool);
    assert_eq!((report.placed_instances, report.made_shaders), (1, 1), "both edits come");
    edited.shaders.surfaces.truncate(1);
    let refused = world.commit(&edited.scene, &edited.shaders, &CommitOptions::default(), &pool);
    assert!(refused.is_err(), "the table lost a shader that is shown");
}
