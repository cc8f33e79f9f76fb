// SPDX-License-Identifier: GPL-3.0-or-later
//! All lights of a world: the description's lights, its emissive shapes and the shader table's lights.
//! Each is kept until an edit affects it; the light tree depends only on lights with a position, an
//! environment's distribution only on its texture.
//! Tests: `crates/render/tests/{lights,commit}.rs`.

use std::ops::Range;
use std::sync::{Arc, OnceLock};

use glam::{Mat3, Vec3};
use gnurt_accel::Threads;
use gnurt_scene::material::TextureRef;
use gnurt_scene::{Affine, ConeEdge, Light, LightId, Scene};
use gnurt_shading::lights as shading;
use gnurt_shading::lights::{EnvironmentLight, LightSet};
use gnurt_shading::{ColorMap, EnvironmentShader, LightShader};

use super::emitters::Emitters;
use super::table::ShaderTable;
use super::textures::sharp;
use crate::many_lights::PluginEmitters;

/// Identity of a set of lights.
#[derive(Clone, Default)]
pub(crate) struct LightsContent(Arc<()>);

impl PartialEq for LightsContent {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

/// All lights of a world.
#[derive(Default)]
pub(crate) struct Lights {
    /// The form for shaders.
    pub(crate) shaders: Vec<Arc<dyn LightShader>>,
    /// Those of `shaders` that only have `illuminate`: the shader table's.
    pub(crate) plugins: Range<usize>,
    /// Radiance of rays that hit nothing.
    pub(crate) environment: Option<Arc<dyn EnvironmentShader>>,
    /// Radiance of camera rays that hit nothing, in place of that.
    pub(crate) backdrop: Option<Arc<shading::PictureEnvironment>>,
    pub(super) emitters: Arc<Emitters>,
    /// The same for lights that differ only in the geometry that they light.
    pub(super) content: LightsContent,
    /// The scene's own environment, unless the shader table has one.
    own_environment: Option<EnvironmentLight>,
    /// The scene's lights without extent, in their order.
    punctual: Vec<Light>,
    /// From their colours to the working space.
    map: ColorMap,
    /// All but `plugins`, for callers that need densities.
    parts: shading::LightParts,
    /// Built for the first integrator that needs it.
    set: OnceLock<LightSet>,
    /// The starts of light paths at lights that only have `illuminate`.
    plugin_emitters: OnceLock<PluginEmitters>,
}

/// A part of the lights.
#[derive(Clone, Copy)]
pub(crate) enum LightPart<'a> {
    /// All emissive shapes.
    Shapes(&'a shading::ShapeLights),
    /// A light without extent, by its number in the scene's order.
    WithoutExtent(usize),
    /// One of the shader table.
    Plugin,
    Environment,
}

/// Lights and the environment of the shader table.
type FromTable<'a> = (&'a [Arc<dyn LightShader>], &'a Option<Arc<dyn EnvironmentShader>>);

/// Changes that a commit found before it updates the lights.
pub(super) struct ChangedLights {
    /// Those of the scene were edited, or a texture.
    pub(super) edited: bool,
    /// The emissive shapes, if they have changed.
    pub(super) emitters: Option<Emitters>,
    /// Of all that can be lit.
    pub(super) bounds: [Vec3; 2],
}

impl Lights {
    /// All lights but those of shader plugins, with densities; built by one thread at first use.
    pub(crate) fn set(&self) -> &LightSet {
        self.set.get_or_init(|| LightSet::new(self.parts.clone(), Threads::Single))
    }

    /// Builds the result of [`set`](Self::set) with all threads, unless it exists. Outside of `set`: a thread
    /// that waits in the pool executes other tasks, and would re-enter its own unfinished initialization.
    pub(crate) fn make_set(&self, pool: &rayon::ThreadPool) {
        if self.set.get().is_none() {
            let set = LightSet::new(self.parts.clone(), Threads::Pool(pool));
            // A second thread has computed the same.
            let _ = self.set.set(set);
        }
    }

    /// The part of the lights that the light of this number among `shaders` is.
    pub(crate) fn part(&self, light: usize) -> LightPart<'_> {
        let first = usize::from(self.parts.shapes.is_some());
        match &self.parts.shapes {
            Some(shapes) if light == 0 => LightPart::Shapes(shapes),
            _ if light < self.plugins.start => LightPart::WithoutExtent(light - first),
            _ if light < self.plugins.end => LightPart::Plugin,
            _ => LightPart::Environment,
        }
    }

    /// Leaf, mesh and primitive of the emissive shapes, as a light set numbers them.
    pub(crate) fn shape_ids(&self) -> &[[u32; 3]] {
        &self.emitters.ids
    }

    /// Where light paths start at lights of shader plugins, within `bounds`.
    pub(crate) fn plugin_emitters(&self, bounds: Option<([f32; 3], [f32; 3])>) -> &PluginEmitters {
        let lights = &self.shaders[self.plugins.clone()];
        let environment = self.environment.as_deref().filter(|_| self.parts.environment.is_none());
        self.plugin_emitters.get_or_init(|| PluginEmitters::new(lights, environment, bounds))
    }

    /// The lights after changes; `None` if they are as they were.
    pub(super) fn after(
        &self,
        changed: ChangedLights,
        scene: &Scene,
        shaders: &ShaderTable,
        pool: &rayon::ThreadPool,
        map: ColorMap,
    ) -> Option<Self> {
        let table_changed = !self.shows(shaders);
        let own_environment = if shaders.environment.is_some() {
            None
        } else if changed.edited || table_changed {
            environment(scene, self.own_environment.as_ref(), Threads::Pool(pool), map)
        } else {
            self.own_environment.clone()
        };
        let backdrop = match table_changed || changed.edited {
            _ if own_environment.is_none() => None,
            true => backdrop(scene, self.backdrop.as_ref(), Threads::Pool(pool), map),
            false => self.backdrop.clone(),
        };
        let same_environment = same(backdrop.as_ref(), self.backdrop.as_ref(), Arc::ptr_eq)
            && same(own_environment.as_ref(), self.own_environment.as_ref(), EnvironmentLight::is);
        let same_bounds = changed.bounds == self.parts.bounds;
        let same_lights = !changed.edited && changed.emitters.is_none() && !table_changed && same_environment;
        if same_lights && same_bounds {
            return None;
        }
        let emitters = changed.emitters.map_or_else(|| self.emitters.clone(), Arc::new);
        let mut lights = Self::of(scene, shaders, emitters, own_environment, changed.bounds, map);
        lights.backdrop = backdrop;
        if same_lights || (same_environment && !table_changed && lights.is_like(self)) {
            // An edit of an invisible light, or of a texture other than the environment's, changes nothing.
            if same_bounds {
                return None;
            }
            lights.content = self.content.clone();
        }
        if let Some(set) = self.set.get() {
            // An unbuilt light tree stays unbuilt until its first use.
            lights.set = set.again(&lights.parts).map(OnceLock::from).unwrap_or_default();
        }
        Some(lights)
    }

    fn of(
        scene: &Scene,
        table: &ShaderTable,
        emitters: Arc<Emitters>,
        own_environment: Option<EnvironmentLight>,
        bounds: [Vec3; 2],
        map: ColorMap,
    ) -> Self {
        let others = (&table.lights[..], &table.environment);
        Self::made(scene.lights(), others, emitters, own_environment, bounds, map)
    }

    /// The same lights at a time of the open shutter: those of the scene, and the emissive shapes, if they
    /// differ then.
    pub(super) fn at(&self, lights: Option<Vec<Light>>, emitters: Option<Emitters>) -> Self {
        let lights = lights.unwrap_or_else(|| self.punctual.clone());
        let emitters = emitters.map_or_else(|| self.emitters.clone(), Arc::new);
        let from_table = self.environment.clone().filter(|_| self.own_environment.is_none());
        let others = (&self.shaders[self.plugins.clone()], &from_table);
        let made =
            Self::made(&lights, others, emitters, self.own_environment.clone(), self.parts.bounds, self.map);
        Self { backdrop: self.backdrop.clone(), ..made }
    }

    fn made(
        lights: &[Light],
        (others, environment): FromTable,
        emitters: Arc<Emitters>,
        own_environment: Option<EnvironmentLight>,
        bounds: [Vec3; 2],
        map: ColorMap,
    ) -> Self {
        let mut parts = shading::LightParts {
            shapes: emitters.shapes.clone(),
            shape_ids: emitters.ids.clone(),
            environment: own_environment.clone(),
            bounds,
            ..Default::default()
        };
        let is_punctual =
            |light: &&Light| !matches!(light, Light::Environment { .. } | Light::Backdrop { .. });
        let punctual: Vec<Light> = lights.iter().filter(is_punctual).cloned().collect();
        let mut shaders: Vec<Arc<dyn LightShader>> = Vec::new();
        if let Some(shapes) = &parts.shapes {
            shaders.push(shapes.clone());
        }
        shaders.extend(punctual.iter().filter_map(|light| without_extent(light, &mut parts, map)));
        let plugins = shaders.len()..shaders.len() + others.len();
        shaders.extend(others.iter().cloned());
        let mut environment = environment.clone();
        if let Some(own) = &own_environment {
            let (light, own): (Arc<dyn LightShader>, Arc<dyn EnvironmentShader>) = match own {
                EnvironmentLight::Constant(constant) => (constant.clone(), constant.clone()),
                EnvironmentLight::Picture(picture) => (picture.clone(), picture.clone()),
            };
            shaders.push(light);
            environment = Some(own);
        }
        let (set, plugin_emitters, content) = Default::default();
        Self {
            content,
            shaders,
            plugins,
            environment,
            backdrop: None,
            emitters,
            own_environment,
            punctual,
            map,
            parts,
            set,
            plugin_emitters,
        }
    }

    /// Whether lights and environment of the shader table are unchanged.
    fn shows(&self, table: &ShaderTable) -> bool {
        let before = &self.shaders[self.plugins.clone()];
        let is_same = |(a, b): (&Arc<dyn LightShader>, &Arc<dyn LightShader>)| Arc::ptr_eq(a, b);
        let from_table = self.environment.as_ref().filter(|_| self.own_environment.is_none());
        before.len() == table.lights.len()
            && before.iter().zip(&table.lights).all(is_same)
            && same(table.environment.as_ref(), from_table, Arc::ptr_eq)
    }

    /// Whether the parts that edits of lights reach are equal.
    fn is_like(&self, before: &Self) -> bool {
        Arc::ptr_eq(&self.emitters, &before.emitters) && self.punctual == before.punctual
    }

    /// The scene's own environment.
    #[cfg(test)]
    pub(super) fn own_environment(&self) -> Option<&EnvironmentLight> {
        self.own_environment.as_ref()
    }
}

/// Whether both are the same, or neither is there.
fn same<T>(now: Option<&T>, before: Option<&T>, is: impl Fn(&T, &T) -> bool) -> bool {
    match (now, before) {
        (Some(now), Some(before)) => is(now, before),
        (None, None) => true,
        _ => false,
    }
}

/// A light without extent, which is added to `parts`, too.
fn without_extent(
    light: &Light,
    parts: &mut shading::LightParts,
    map: ColorMap,
) -> Option<Arc<dyn LightShader>> {
    let color = |color: [f32; 3]| map.of(Vec3::from(color));
    match *light {
        Light::Point { position, intensity, radius } => {
            let point =
                shading::PointLight { radius, ..shading::PointLight::new(position.into(), color(intensity)) };
            parts.points.push(point);
            Some(Arc::new(point))
        }
        Light::Spot { position, direction, intensity, inner_angle, outer_angle, edge, radius } => {
            let edge = match edge {
                ConeEdge::Squared => shading::ConeEdge::Squared,
                ConeEdge::Smooth => shading::ConeEdge::Smooth,
            };
            let cone = shading::Cone::new(direction.into(), inner_angle, outer_angle, edge)?;
            let all_around = shading::PointLight::new(position.into(), color(intensity));
            let spot = shading::PointLight { radius, cone: Some(cone), ..all_around };
            parts.points.push(spot);
            Some(Arc::new(spot))
        }
        Light::Directional { direction, irradiance, angle } => {
            let directional = shading::DirectionalLight::new(direction.into(), color(irradiance), angle)?;
            parts.directionals.push(directional);
            Some(Arc::new(directional))
        }
        Light::Environment { .. } | Light::Backdrop { .. } => None,
    }
}

/// The scene's lights without extent in the order of a light set: points and spots, directional lights.
pub(super) fn order_in_set(scene: &Scene) -> Vec<LightId> {
    let mut parts = shading::LightParts::default();
    let mut kinds = [(); 2].map(|()| Vec::new());
    for (id, light) in (0..).map(LightId).zip(scene.lights()) {
        if without_extent(light, &mut parts, ColorMap::default()).is_some() {
            let counts = [parts.points.len(), parts.directionals.len()];
            let grown = (0..2).find(|&kind| counts[kind] > kinds[kind].len());
            grown.into_iter().for_each(|kind| kinds[kind].push(id));
        }
    }
    kinds.concat()
}

fn rotation_of(world_from_light: &Affine) -> Mat3 {
    let [x, y, z, _] = world_from_light.to_f32();
    let unit = |v: [f32; 3]| Vec3::from(v).normalize_or_zero();
    Mat3::from_cols(unit(x), unit(y), unit(z))
}

/// The last backdrop of the scene, or the previous one if it is unchanged.
fn backdrop(
    scene: &Scene,
    before: Option<&Arc<shading::PictureEnvironment>>,
    threads: Threads,
    map: ColorMap,
) -> Option<Arc<shading::PictureEnvironment>> {
    let (texture, rotation) = scene.lights().iter().rev().find_map(|light| match light {
        Light::Backdrop { texture, world_from_light } => Some((*texture, rotation_of(world_from_light))),
        _ => None,
    })?;
    let sampler = sharp(scene, &TextureRef::new(texture));
    match before {
        Some(same) if same.shows(&sampler) && same.shines_as(Vec3::ONE, rotation) => Some(same.clone()),
        _ => {
            let new = shading::PictureEnvironment::new(sampler, Vec3::ONE, rotation, threads)?;
            Some(Arc::new(new.mapped(map)))
        }
    }
}

/// The last environment of the scene; shares the unchanged parts of the one before.
fn environment(
    scene: &Scene,
    before: Option<&EnvironmentLight>,
    threads: Threads,
    map: ColorMap,
) -> Option<EnvironmentLight> {
    let last = scene.lights().iter().rev().find_map(|light| match light {
        Light::Environment { radiance, texture, world_from_light } => {
            Some((Vec3::from(*radiance), *texture, world_from_light))
        }
        _ => None,
    });
    let (radiance, texture, world_from_light) = last.filter(|(radiance, ..)| radiance.max_element() > 0.0)?;
    let Some(texture) = texture else {
        let radiance = map.of(radiance);
        let same = |light: &&EnvironmentLight| matches!(light, EnvironmentLight::Constant(constant) if constant.radiance == radiance);
        let new = || EnvironmentLight::Constant(Arc::new(shading::ConstantEnvironment { radiance }));
        return Some(before.filter(same).cloned().unwrap_or_else(new));
    };
    let rotation = rotation_of(world_from_light);
    let sampler = sharp(scene, &TextureRef::new(texture));
    let picture = match before {
        Some(same @ EnvironmentLight::Picture(picture)) if picture.shows(&sampler) => {
            if picture.shines_as(radiance, rotation) {
                return Some(same.clone());
            }
            picture.again(radiance, rotation)?
        }
        _ => shading::PictureEnvironment::new(sampler, radiance, rotation, threads)?.mapped(map),
    };
    Some(EnvironmentLight::Picture(Arc::new(picture)))
}
