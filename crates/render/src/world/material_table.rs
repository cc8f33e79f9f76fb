// SPDX-License-Identifier: GPL-3.0-or-later
//! The shaders of a world's materials. An edit makes the shader of its material again and no other.
//! Invariant: entry by entry the scene's materials; the counts are those of all entries.
//! Tests: crates/render/tests/commit.rs.

use std::sync::Arc;

use gnurt_accel::SharedList;
use gnurt_scene::{Scene, Surface};
use gnurt_shading::lights::Emitter;
use gnurt_shading::materials::{Coverage, Emission};
use gnurt_shading::{ColorMap, SurfaceShader};

use super::materials;
use super::table::{CommitOptions, ShaderTable};
use super::textures::{Reading, Textures};

/// A material as rays meet it.
#[derive(Clone)]
pub(crate) struct MaterialEntry {
    pub(crate) shader: Arc<dyn SurfaceShader>,
    /// Its emission: none, that of the front, that of both sides by the shader, or that of the front and that of the back.
    emitters: Vec<Arc<Emitter>>,
    is_opaque: bool,
    pub(crate) is_solid: bool,
    has_medium: bool,
    pub(crate) is_clear: bool,
    reads_widths: bool,
    has_holes: bool,
    /// The shader of the table that it shows.
    from_table: Option<Arc<dyn SurfaceShader>>,
}

/// All materials.
#[derive(Clone, Default)]
pub(crate) struct MaterialTable {
    /// By material id. `None` only during a commit.
    entries: SharedList<Option<MaterialEntry>>,
    /// Ids of materials with a shader of the shader table, ascending, and its number there.
    from_table: Vec<(u32, u32)>,
    /// How many let light straight through.
    see_through: usize,
    /// The number with transparent parts.
    holey: usize,
    /// How many absorb light on one of their sides.
    filled: usize,
    /// How many may be smooth glass.
    clear: usize,
    /// The number of materials that read the width of cones.
    reading: usize,
    /// The number that may leave holes in the picture.
    holding: usize,
    textures: Textures,
}

/// The changes of an update.
#[derive(Default)]
pub(super) struct ChangedMaterials {
    /// Shaders that were made.
    pub(super) made: usize,
    /// Whether something gives off other light.
    pub(super) emission: bool,
}

impl MaterialTable {
    /// One of the materials. Panics on an id of another scene.
    #[inline]
    pub(crate) fn get(&self, material: usize) -> &MaterialEntry {
        self.entries[material].as_ref().expect("commit makes all materials")
    }

    /// The shaders of all materials.
    pub(crate) fn shaders(&self) -> impl Iterator<Item = &dyn SurfaceShader> {
        self.entries.iter().filter_map(|entry| entry.as_ref().map(|entry| &*entry.shader))
    }

    /// Whether no surface lets light straight through.
    pub(crate) fn all_opaque(&self) -> bool {
        self.see_through == 0
    }

    /// Whether no surface has transparent parts; scattering transmission does not count.
    pub(crate) fn all_solid(&self) -> bool {
        self.holey == 0
    }

    /// Whether some surface has an absorbing medium.
    pub(crate) fn has_media(&self) -> bool {
        self.filled > 0
    }

    /// Whether some surface may be smooth glass, through which light samples search for lights.
    pub(crate) fn has_panes(&self) -> bool {
        self.clear > 0
    }

    /// Whether some surface may leave holes in the picture.
    pub(crate) fn have_holes(&self) -> bool {
        self.holding > 0
    }

    /// Whether some surface reads the width of ray cones. Otherwise widths need not be computed.
    pub(crate) fn read_widths(&self) -> bool {
        self.reading > 0
    }

    /// The emission of each, in their order.
    pub(super) fn emitters(&self) -> impl Iterator<Item = &[Arc<Emitter>]> {
        self.entries.iter().map(|entry| entry.as_ref().map_or(&[][..], |entry| &entry.emitters))
    }

    pub(super) fn is_emissive(&self, material: usize) -> bool {
        !self.get(material).emitters.is_empty()
    }

    /// Those whose shader in the table is another one now, and its number there.
    pub(super) fn swapped<'a>(&'a self, shaders: &'a ShaderTable) -> impl Iterator<Item = (u32, u32)> + 'a {
        let is_other = |&&(material, number): &&(u32, u32)| {
            let before = self.get(material as usize).from_table.as_ref();
            let now = shaders.surfaces.get(number as usize);
            !matches!((before, now), (Some(before), Some(now)) if Arc::ptr_eq(before, now))
        };
        self.from_table.iter().filter(is_other).copied()
    }

    /// Makes the shaders of `dirty`, ascending.
    pub(super) fn update(
        &mut self,
        dirty: &[u32],
        scene: &Scene,
        shaders: &ShaderTable,
        options: &CommitOptions,
    ) -> ChangedMaterials {
        let mut changed = ChangedMaterials { made: dirty.len(), emission: false };
        self.entries.grow(scene.materials().len());
        for &id in dirty {
            let index = self.entries.edit(id as usize);
            let before = index.take();
            let now = entry((scene, &self.textures), id, shaders, options, before.as_ref());
            let before_emitters = before.as_ref().map_or(&[][..], |entry| &entry.emitters);
            changed.emission |= !same_emitters(before_emitters, &now.emitters);
            let count = |what: fn(&MaterialEntry) -> bool, total: usize| {
                total + usize::from(!what(&now))
                    - usize::from(before.as_ref().is_some_and(|entry| !what(entry)))
            };
            self.see_through = count(|entry| entry.is_opaque, self.see_through);
            self.holey = count(|entry| entry.is_solid, self.holey);
            self.filled = count(|entry| !entry.has_medium, self.filled);
            self.clear = count(|entry| !entry.is_clear, self.clear);
            self.reading = count(|entry| !entry.reads_widths, self.reading);
            self.holding = count(|entry| !entry.has_holes, self.holding);
            let listed = self.from_table.binary_search_by_key(&id, |&(material, _)| material);
            let number = now.from_table.as_ref().and(number_of(scene, id));
            match (listed, number) {
                (Ok(at), Some(number)) => self.from_table[at].1 = number,
                (Ok(at), None) => _ = self.from_table.remove(at),
                (Err(at), Some(number)) => self.from_table.insert(at, (id, number)),
                (Err(_), None) => {}
            }
            *index = Some(now);
        }
        self.textures.tidy();
        changed
    }
}

fn same_emitters(a: &[Arc<Emitter>], b: &[Arc<Emitter>]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| Arc::ptr_eq(a, b))
}

/// The number in the shader table that a material names.
fn number_of(scene: &Scene, material: u32) -> Option<u32> {
    match scene.materials()[material as usize].surface {
        Surface::Shader(number) => Some(number),
        _ => None,
    }
}

fn entry(
    (scene, textures): (&Scene, &Textures),
    id: u32,
    shaders: &ShaderTable,
    options: &CommitOptions,
    before: Option<&MaterialEntry>,
) -> MaterialEntry {
    let force_diffuse = options.force_diffuse;
    let material = &scene.materials()[id as usize];
    let opacity_texture = if force_diffuse { None } else { materials::opacity_texture(&material.alpha) };
    let from = Reading { scene, textures, opacity_texture, map: ColorMap::to(options.space) };
    let emission = materials::emission(from, material);
    let coverage = if force_diffuse { None } else { materials::coverage(from, &material.alpha) };
    // With or without `--force-diffuse`: an edit of the shader marks the surface as dirty.
    let from_table = number_of(scene, id).map(|number| shaders.surfaces[number as usize].clone());
    // Radiance from a surface's own rays and light loops is no emission.
    let emission_shader =
        from_table.as_ref().filter(|it| !force_diffuse && it.emits() && it.radiance().is_none());
    let before = before.map_or(&[][..], |before| &before.emitters);
    let emitter = |emission: Emission, coverage: Option<&Coverage>| {
        let same = before.iter().find(|emitter| emitter.gives_off(&emission, coverage));
        same.cloned().unwrap_or_else(|| Arc::new(Emitter::new(emission, coverage.cloned())))
    };
    let is_queried = emission_shader.is_some();
    let mut emitters: Vec<_> = emission
        .clone()
        .filter(|_| !is_queried)
        .map(|emission| emitter(emission, coverage.as_ref()))
        .into_iter()
        .collect();
    // Cones carry the kind of the ray, too.
    let reads_kinds = matches!(material.surface, Surface::Shader(_) | Surface::Unlit { .. });
    let shader = materials::shader(from, material, shaders, force_diffuse, emission, coverage);
    if is_queried {
        emitters = match shader.even_emission() {
            Some(sides) => sides.map(|factor| emitter(Emission::constant(factor), None)).into(),
            None => vec![Arc::new(Emitter::by_shader(shader.clone()))],
        };
    }
    MaterialEntry {
        is_opaque: shader.is_opaque(),
        is_solid: shader.is_solid(),
        has_medium: shader.has_medium(),
        is_clear: shader.is_clear(),
        has_holes: shader.has_holes(),
        reads_widths: reads_kinds || materials::textures_of(material).next().is_some(),
        emitters,
        from_table,
        shader,
    }
}
