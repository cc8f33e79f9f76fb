// SPDX-License-Identifier: GPL-3.0-or-later
//! The program's world as a scene: surfaces, volumes and lights of all instances, and the world that rays meet.
//! A world is translated again when something of it was committed; geometries, samplers and materials that stayed are kept. Trees are
//! built when a frame first needs them, and only the light from everywhere differs between renderers.
//! Tests: tests/{instances,lifetimes}.rs.

use std::sync::{Arc, Mutex};

use glam::Vec3;
use gnurt::ThreadPool;
use gnurt::render::{CommitOptions, ShaderTable, World};
use gnurt::scene::texture::{Filter, TexelData, Texels, Texture, Wrap};
use gnurt::scene::{
    Affine, Instance as Placed, Light, Material as Plain, MaterialId, RayMask, Scene, Surface as FirstHit,
};
use gnurt::shading::{PixelShader, SurfaceShader};

use crate::attribute::{FREE, NAMES};
use crate::ffi_array::Array;
use crate::field::Field;
use crate::freshness;
use crate::geometry::{Bounds, Geometry, Shapes, build};
use crate::light::{Made, Sky, light};
use crate::material::{Material, class};
use crate::motion::{Motion, Shutter};
use crate::movers::Movers;
use crate::object::{Object, Snapshot, lock};
use crate::sampler::Sampler;
use crate::shader::{AreaLights, Surfaces};
use crate::table::{Instance, ONCE, Surface, Table, Target};
use crate::types;
use crate::volume::{Transfer, Volume};

/// Reports a fault of an object.
pub(crate) type Report<'a> = &'a dyn Fn(&Object, &str);

/// The material of lamps.
const LAMP: MaterialId = MaterialId(class::COUNT);

/// A translated world.
pub(crate) struct Stage {
    pub(crate) table: Arc<Table>,
    scene: Scene,
    sky: Option<Sky>,
    bounds: Bounds,
    movers: Movers,
    ready: Mutex<Option<Ready>>,
}

/// Trees and lights, at the opening of the shutter.
struct Ready {
    ambient: [f32; 3],
    camera_moves: bool,
    scene: Scene,
    world: World,
}

/// Translations of a world for the shutters of its last cameras.
#[derive(Default)]
struct Stages(Mutex<Vec<Arc<Stage>>>);

/// Shutters whose translations are kept.
const MOST_STAGES: usize = 4;

/// Something that may be missing, because its parameters are wrong.
struct Maybe<T>(Option<Arc<T>>);

/// Makes something of an object unless that was made of the same parameters before.
fn made<T: Send + Sync + 'static>(
    object: &Object,
    report: Report,
    make: impl FnOnce() -> Result<T, String>,
) -> Option<Arc<T>> {
    let maybe = object.derived(freshness::stamp(object), || {
        let value = make().map_err(|fault| report(object, &fault)).ok();
        Maybe(value.map(Arc::new))
    });
    maybe.0.clone()
}

/// A geometry by triangles alone, for materials that need them.
struct Triangulated(Arc<Geometry>);

/// A geometry, for a material of this class.
fn geometry(object: &Object, class: u32, report: Report) -> Option<Arc<Geometry>> {
    let shines = class & class::EMITS != 0;
    let shapes = if shines { Shapes::Triangles } else { Shapes::Exact };
    let make = || {
        let (geometry, warning) = build(object, shapes)?;
        if let Some(warning) = warning {
            report(object, &warning);
        }
        Ok(geometry)
    };
    if !shines {
        return made(object, report, make);
    }
    made(object, report, || make().map(|geometry| Triangulated(Arc::new(geometry)))).map(|it| it.0.clone())
}

fn material(object: &Object, report: Report) -> Option<Arc<Material>> {
    made(object, report, || {
        let mut faults = Vec::new();
        let sampler = |object: &Arc<Object>| made(object, report, || Sampler::new(object));
        let material = Material::new(object, &sampler, &mut faults);
        faults.iter().for_each(|fault| report(object, fault));
        Ok(material)
    })
}

/// The objects of a list.
fn list(now: &Snapshot, name: &str) -> Vec<Arc<Object>> {
    let array = now.object(name, types::ARRAY1D).and_then(|array| Array::of(array));
    array.map(Array::objects).unwrap_or_default()
}

fn affine(matrix: &[f32; 16]) -> Affine {
    Affine::from_column_major(&matrix.map(f64::from))
}

/// A translation under way.
struct Builder<'a> {
    table: Table,
    scene: Scene,
    sky: Option<Sky>,
    bounds: Bounds,
    movers: Movers,
    report: Report<'a>,
}

impl Builder<'_> {
    /// Adds the surfaces, volumes and lights of a group, or of the world itself.
    fn contents(&mut self, now: &Snapshot, instance: Instance, motion: Option<&Arc<Motion>>) {
        let number = self.table.instances.len() as u32;
        let (to_world, id) = (instance.world_from_object, instance.id);
        let from_world = instance.object_from_world;
        self.table.instances.push(instance);
        for surface in list(now, "surface") {
            self.surface(&surface, number, to_world, motion);
        }
        for volume in list(now, "volume") {
            if motion.is_some() {
                (self.report)(
                    &volume,
                    "in a moving instance: it stands where it is in the middle of the shutter's time",
                );
            }
            self.volume(&volume, (to_world, from_world), id);
        }
        for object in list(now, "light") {
            if motion.is_some() {
                (self.report)(
                    &object,
                    "in a moving instance: it stands where it is in the middle of the shutter's time",
                );
            }
            match light(&object, &to_world, LAMP) {
                Ok(made) => self.light(&object, made),
                Err(fault) => (self.report)(&object, &fault),
            }
        }
    }

    fn surface(&mut self, object: &Object, instance: u32, to_world: Affine, motion: Option<&Arc<Motion>>) {
        let now = object.committed();
        if now.bool("visible") == Some(false) {
            return;
        }
        let surface_material =
            now.object("material", types::MATERIAL).and_then(|it| material(it, self.report));
        let surface_material = surface_material.unwrap_or_else(|| Arc::new(Material::missing()));
        let class = surface_material.class();
        let shown = now.object("geometry", types::GEOMETRY);
        let Some(geometry) = shown.and_then(|it| geometry(it, class, self.report)) else { return };
        self.table.has_holes |= class & class::HOLES != 0;
        let surface = self.table.surfaces.len() as u32;
        for (part_number, part) in geometry.parts.iter().enumerate() {
            part.extend(&to_world, &mut self.bounds);
            if let Some(motion) = motion {
                self.movers.path(motion).for_each(|place| part.extend(&place, &mut self.bounds));
            }
            let mesh = self.scene.add_mesh(part.mesh_of(MaterialId(class)));
            let shape = self.scene.add_object_of("", vec![mesh]);
            let part_number = part_number as u32;
            let mut add = |placement: u32, object_from_part: Affine| {
                self.table.targets.push(Target::Surface { surface, instance, part: part_number, placement });
                let id = self.scene.instantiate(shape, to_world * object_from_part);
                if let Some(motion) = motion {
                    self.movers.add(id, motion, object_from_part);
                }
            };
            match &part.placements {
                None => add(ONCE, Affine::IDENTITY),
                Some(all) => {
                    all.iter().enumerate().for_each(|(i, placed)| add(i as u32, placed.object_from_part))
                }
            }
        }
        let id = now.u32("id").unwrap_or(u32::MAX);
        self.table.surfaces.push(Surface { geometry, material: surface_material, id });
    }

    fn volume(&mut self, object: &Object, (to_world, object_from_world): (Affine, Affine), instance: u32) {
        let now = object.committed();
        if now.bool("visible") == Some(false) {
            return;
        }
        if object.subtype != "transferFunction1D" {
            return (self.report)(object, "subtype: unsupported, not shown");
        }
        let field = now.object("value", types::SPATIAL_FIELD);
        let field = field.and_then(|it| made(it, self.report, || Field::new(it)));
        let Some(field) = field else {
            return (self.report)(object, "parameter 'value': missing, not shown");
        };
        let Some(transfer) = made(object, self.report, || Transfer::new(object)) else { return };
        let [low, high] = field.bounds();
        for k in 0..8_usize {
            let corner = std::array::from_fn(|axis| {
                f64::from(if k >> axis & 1 == 0 { low[axis] } else { high[axis] })
            });
            self.bounds.add(to_world.point(corner), [0.0; 3]);
        }
        let id = now.u32("id").unwrap_or(u32::MAX);
        self.table.volumes.push(Volume { field, transfer, object_from_world, id, instance });
    }

    fn light(&mut self, object: &Object, made: Made) {
        match made {
            Made::Small(light) => {
                self.scene.add_light(light);
            }
            Made::AreaLight { mesh, area_light, visible } => {
                let mesh = self.scene.add_mesh(mesh);
                let shape = self.scene.add_object_of("", vec![mesh]);
                // One that is not to be seen casts no shadow of others' light either.
                let mask = if visible { RayMask::ALL } else { !(RayMask::CAMERA | RayMask::SHADOW) };
                let transform = Affine::IDENTITY;
                let placed = Placed {
                    name: String::new(),
                    object: shape,
                    world_from_object: transform,
                    visible: true,
                    mask,
                };
                self.scene.add_instance(placed);
                self.table.targets.push(Target::AreaLight(self.table.area_lights.len() as u32));
                self.table.area_lights.push(area_light);
            }
            Made::Sky(sky) => {
                if self.sky.is_some() {
                    (self.report)(object, "a second hdri light: unsupported, the last one counts");
                }
                self.table.shows_sky = sky.visible;
                self.sky = Some(sky);
            }
        }
    }

    /// Adds an instance: a group once, or for each of an array of transforms.
    fn instance(&mut self, object: &Object) {
        let now = object.committed();
        if !["transform", "motionTransform", "motionScaleRotationTranslation"].contains(&&*object.subtype) {
            return (self.report)(
                object,
                "subtype: unsupported, not shown; allowed: transform, motionTransform, motionScaleRotationTranslation",
            );
        }
        let motion = if object.subtype == "transform" { None } else { Motion::of(&now).map(Arc::new) };
        let Some(group) = now.object("group", types::GROUP) else { return };
        let contents = group.committed();
        let array = now.object("transform", types::ARRAY1D).and_then(|array| Array::of(array)?.rows::<16>());
        let transforms = array.unwrap_or_else(|| vec![now.mat4("transform").unwrap_or(UNIT)]);
        let ids = now.object("id", types::ARRAY1D).and_then(|array| Array::of(array)?.indices::<1>());
        let each =
            NAMES.map(|name| now.object(name, types::ARRAY1D).and_then(|array| Array::of(array)?.colors()));
        for (k, matrix) in transforms.iter().enumerate() {
            let world_from_object = match &motion {
                Some(motion) => self.movers.at(motion, 0.5),
                None => affine(matrix),
            };
            let Some(object_from_world) = world_from_object.inverse() else {
                (self.report)(object, "parameter 'transform': no inverse, not shown");
                continue;
            };
            let own: [_; FREE] = std::array::from_fn(|i| {
                let of_array = each[i].as_ref().and_then(|list| list.get(k).copied());
                of_array.or_else(|| now.color(NAMES[i]))
            });
            let id = ids.as_ref().and_then(|ids| ids.get(k)).map(|[id]| *id as u32);
            let id = id.or_else(|| now.u32("id")).unwrap_or(u32::MAX);
            let instance = Instance { world_from_object, object_from_world, attributes: own, id };
            self.contents(&contents, instance, motion.as_ref());
        }
    }
}

const UNIT: [f32; 16] = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];

impl Stage {
    /// The translation of a world, or of anything that holds surfaces, as a group does, or of an instance; for a shutter.
    pub(crate) fn of(object: &Object, shutter: Shutter, report: Report) -> Arc<Self> {
        let stages: Arc<Stages> = object.derived(freshness::stamp(object), Stages::default);
        let fits = |stage: &&Arc<Self>| stage.movers.fit(shutter);
        let known = lock(&stages.0).iter().find(fits).cloned();
        known.unwrap_or_else(|| {
            // Not under the lock: reports call the program.
            let stage = Arc::new(Self::new(object, shutter, report));
            let mut all = lock(&stages.0);
            all.truncate(MOST_STAGES - 1);
            all.insert(0, stage.clone());
            stage
        })
    }

    fn new(object: &Object, shutter: Shutter, report: Report) -> Self {
        let now = object.committed();
        let mut scene = Scene::new();
        for shader in 0..=class::COUNT {
            scene.add_material(Plain::of("", FirstHit::Shader(shader)));
        }
        let (table, bounds) = (Table::default(), Bounds::default());
        let movers = Movers::new(shutter);
        let mut builder = Builder { table, scene, sky: None, bounds, movers, report };
        if object.kind == types::INSTANCE {
            builder.instance(object);
        } else {
            list(&now, "instance").iter().for_each(|instance| builder.instance(instance));
            let (world_from_object, object_from_world) = (Affine::IDENTITY, Affine::IDENTITY);
            let id = now.u32("id").unwrap_or(u32::MAX);
            let own = Instance { world_from_object, object_from_world, attributes: [None; FREE], id };
            builder.contents(&now, own, None);
        }
        let Builder { table, scene, sky, bounds, movers, .. } = builder;
        Self { table: Arc::new(table), scene, sky, bounds, movers, ready: Mutex::default() }
    }

    /// Whether something moves while the shutter is open.
    pub(crate) fn moves(&self) -> bool {
        self.movers.move_now()
    }

    /// Lower and upper corner of surfaces and volumes; `None` where there are none.
    pub(crate) fn bounds(&self) -> Option<[[f32; 3]; 2]> {
        self.bounds.corners()
    }

    fn shaders(&self, pixel: Option<Arc<dyn PixelShader>>) -> ShaderTable {
        let surface =
            |class| Arc::new(Surfaces { table: self.table.clone(), class }) as Arc<dyn SurfaceShader>;
        let area_lights = Arc::new(AreaLights { table: self.table.clone() }) as Arc<dyn SurfaceShader>;
        let surfaces = (0..class::COUNT).map(surface).chain([area_lights]).collect();
        ShaderTable { surfaces, pixel, ..ShaderTable::default() }
    }

    /// The world that rays meet, under this light from everywhere; `pixel` shades the pixels. With `camera_moves` rays have times, also
    /// where nothing else moves. An error in words where trees cannot be built.
    pub(crate) fn world(
        &self,
        ambient: [f32; 3],
        pixel: Option<Arc<dyn PixelShader>>,
        camera_moves: bool,
        pool: &ThreadPool,
    ) -> Result<World, String> {
        let ready = self.take_ready(ambient, camera_moves, pool)?;
        // The program's other frames may show another picture of it: only the shader of pixels differs.
        let mut world = ready.world.clone();
        let (exposure, options) = (self.movers.exposure(camera_moves), CommitOptions::default());
        let shown = match pixel {
            Some(pixel) => {
                let shaders = self.shaders(Some(pixel));
                world.commit_exposed(&ready.scene, &exposure, &shaders, &options, pool).map(|_| world)
            }
            None => Ok(world),
        };
        *lock(&self.ready) = Some(ready);
        shown.map_err(|error| error.to_string())
    }

    /// The same world at a share of the time that the shutter is open, where nothing moves.
    pub(crate) fn moment(&self, ambient: [f32; 3], share: f32, pool: &ThreadPool) -> Result<World, String> {
        let mut ready = self.take_ready(ambient, false, pool)?;
        let mut world = ready.world.clone();
        self.movers.pose(&mut ready.scene, share);
        let shown = world.commit(&ready.scene, &self.shaders(None), &CommitOptions::default(), pool);
        self.movers.pose(&mut ready.scene, 0.0);
        *lock(&self.ready) = Some(ready);
        shown.map(|_| world).map_err(|error| error.to_string())
    }

    /// Trees and lights, which the caller puts back.
    fn take_ready(&self, ambient: [f32; 3], camera_moves: bool, pool: &ThreadPool) -> Result<Ready, String> {
        let fits = |ready: &Ready| ready.ambient == ambient && ready.camera_moves == camera_moves;
        let taken = lock(&self.ready).take().filter(fits);
        let options = CommitOptions::default();
        let ready = match taken {
            Some(ready) => ready,
            None => {
                let mut scene = self.scene.clone();
                self.surround(&mut scene, ambient);
                self.movers.pose(&mut scene, 0.0);
                let mut world = World::new();
                let exposure = self.movers.exposure(camera_moves);
                world
                    .commit_exposed(&scene, &exposure, &self.shaders(None), &options, pool)
                    .map_err(|error| error.to_string())?;
                Ready { ambient, camera_moves, scene, world }
            }
        };
        Ok(ready)
    }

    /// Adds the light from all around.
    fn surround(&self, scene: &mut Scene, ambient: [f32; 3]) {
        let Some(sky) = &self.sky else {
            if ambient.iter().any(|&x| x > 0.0) {
                let world_from_light = Affine::IDENTITY;
                scene.add_light(Light::Environment { radiance: ambient, texture: None, world_from_light });
            }
            return;
        };
        let texels = sky.texels.iter().map(|texel| {
            let [r, g, b] = std::array::from_fn(|k| texel[k] + ambient[k]);
            [r, g, b, 1.0]
        });
        let [width, height] = sky.size;
        let texels = Arc::new(Texels { width, height, data: TexelData::Float(texels.collect()) });
        let wrap = [Wrap::Repeat, Wrap::ClampToEdge];
        let texture =
            scene.add_texture(Texture { name: String::new(), texels, wrap, filter: Filter::Linear });
        let columns = [sky.middle.cross(sky.up), sky.up, -sky.middle, Vec3::ZERO];
        let world_from_light = Affine { columns: columns.map(|v| v.to_array().map(f64::from)) };
        scene.add_light(Light::Environment { radiance: [1.0; 3], texture: Some(texture), world_from_light });
    }
}
