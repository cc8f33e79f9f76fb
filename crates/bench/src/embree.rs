// SPDX-License-Identifier: GPL-3.0-or-later
//! Embree as a program uses it: rays one by one, ready in its structures; packets with rays that are copied from arrays, and
//! results read back.
//! Tests: `tests::finds_the_triangle` (where `EMBREE4_LIB` names a library).

use std::path::{Path, PathBuf};

use gnurt::accel::{INVALID_ID, RayBatch};
use gnurt::simd::Level;

use crate::Error;
use crate::ffi_embree::{Active, Arguments, Device, Library, OneRay, Packet, Scene};
use crate::job::{EmbreeKind, Packets};
use crate::timing::{Answers, Engine};

/// A library of Embree 4.
pub struct EmbreeLibrary {
    file: PathBuf,
    library: Library,
}

impl EmbreeLibrary {
    /// Loads it, and queries its version.
    ///
    /// # Errors
    /// [`Error::Embree`] if the file is missing, no library, or not Embree 4.
    pub fn open(file: &Path) -> Result<Self, Error> {
        let failed = |why| Error::Embree { library: file.display().to_string(), why };
        let library = Library::open(file).map_err(failed)?;
        Device::open(&library, "").map_err(failed)?;
        Ok(Self { file: file.to_owned(), library })
    }

    /// 40400 for 4.4.0.
    #[must_use]
    pub fn version(&self) -> i64 {
        Device::open(&self.library, "").map_or(0, |device| device.version() as i64)
    }

    pub(crate) fn failed(&self, why: String) -> Error {
        Error::Embree { library: self.file.display().to_string(), why }
    }

    /// A device that uses this instruction set and this many threads (0: all) to build.
    pub(crate) fn device(&self, level: Level, threads: usize) -> Result<Device<'_>, Error> {
        let isa = isa(level).map_or(String::new(), |isa| format!(",isa={isa}"));
        let settings = format!("threads={threads}{isa}");
        Device::open(&self.library, &settings).map_err(|why| self.failed(why))
    }
}

/// Embree's name of an instruction set; it has nothing below SSE2.
fn isa(level: Level) -> Option<&'static str> {
    match level {
        Level::Scalar => Some("sse2"),
        Level::Sse42 => Some("sse4.2"),
        Level::Avx2 => Some("avx2"),
        Level::Avx512 => Some("avx512"),
        Level::Neon => None,
    }
}

impl EmbreeKind {
    /// Quality of the build and flags of the scene.
    pub(crate) fn settings(self) -> (i32, i32) {
        const COMPACT: i32 = 2;
        const ROBUST: i32 = 4;
        match self {
            Self::Medium => (1, 0),
            Self::High => (2, 0),
            Self::Robust => (1, ROBUST),
            Self::Compact => (1, COMPACT),
        }
    }
}

/// A scene, queried in packets of one size.
pub(crate) struct EmbreeEngine<'a> {
    pub(crate) scene: &'a Scene<'a>,
    pub(crate) packets: Packets,
}

impl Engine for EmbreeEngine<'_> {
    fn make_ready(&self, rays: &RayBatch, answers: &mut Answers) {
        if self.packets.size == 1 {
            answers.embree_rays.clear();
            answers.embree_rays.extend((0..rays.len()).map(|i| OneRay::new(&rays.get(i))));
        }
    }

    fn read_back(&self, any: bool, answers: &mut Answers) {
        if self.packets.size != 1 {
            return;
        }
        answers.resize(answers.embree_rays.len());
        for (i, ray) in answers.embree_rays.iter().enumerate() {
            if any {
                answers.occluded[i] = ray.is_occluded();
            } else {
                (answers.hits.t[i], answers.hits.prim_id[i]) =
                    ray.hit().unwrap_or((f32::INFINITY, INVALID_ID));
            }
        }
    }

    fn closest(&self, rays: &RayBatch, answers: &mut Answers) {
        let arguments = Arguments::new(self.packets.coherent);
        match self.packets.size {
            1 => {
                answers.embree_rays.iter_mut().for_each(|ray| self.scene.intersect_one(ray, &arguments));
            }
            4 => closest::<4>(self.scene, &arguments, rays, answers),
            8 => closest::<8>(self.scene, &arguments, rays, answers),
            _ => closest::<16>(self.scene, &arguments, rays, answers),
        }
    }

    fn any(&self, rays: &RayBatch, answers: &mut Answers) {
        let arguments = Arguments::new(self.packets.coherent);
        match self.packets.size {
            1 => {
                answers.embree_rays.iter_mut().for_each(|ray| self.scene.occluded_one(ray, &arguments));
            }
            4 => any::<4>(self.scene, &arguments, rays, answers),
            8 => any::<8>(self.scene, &arguments, rays, answers),
            _ => any::<16>(self.scene, &arguments, rays, answers),
        }
    }
}

/// Copies `N` rays from `first` on; the last packet may have fewer, which are repeated where nothing is active.
#[inline(always)]
fn load<const N: usize>(rays: &RayBatch, first: usize, packet: &mut Packet<N>, active: &mut Active<N>) {
    if first + N <= rays.len() {
        for k in 0..3 {
            packet.org[k].copy_from_slice(&rays.org[k][first..first + N]);
            packet.dir[k].copy_from_slice(&rays.dir[k][first..first + N]);
        }
        packet.t_near.copy_from_slice(&rays.t_near[first..first + N]);
        packet.t_far.copy_from_slice(&rays.t_far[first..first + N]);
    } else {
        for lane in 0..N {
            let ray = rays.get((first + lane).min(rays.len() - 1));
            active.0[lane] = if first + lane < rays.len() { -1 } else { 0 };
            for k in 0..3 {
                packet.org[k][lane] = ray.org[k];
                packet.dir[k][lane] = ray.dir[k];
            }
            packet.t_near[lane] = ray.t_near;
            packet.t_far[lane] = ray.t_far;
        }
    }
}

fn closest<const N: usize>(scene: &Scene, arguments: &Arguments, rays: &RayBatch, answers: &mut Answers) {
    let (mut packet, mut active) = (Packet::<N>::new(), Active([-1; N]));
    answers.resize(rays.len());
    let (t, prim_id) = (&mut answers.hits.t[..rays.len()], &mut answers.hits.prim_id[..rays.len()]);
    let mut first = 0;
    while first < rays.len() {
        load(rays, first, &mut packet, &mut active);
        packet.geom_id = [INVALID_ID; N];
        packet.inst_id = [INVALID_ID; N];
        scene.intersect(&active, &mut packet, arguments);
        for lane in 0..N.min(rays.len() - first) {
            let is_hit = packet.geom_id[lane] != INVALID_ID;
            t[first + lane] = if is_hit { packet.t_far[lane] } else { f32::INFINITY };
            prim_id[first + lane] = if is_hit { packet.prim_id[lane] } else { INVALID_ID };
        }
        first += N;
    }
}

fn any<const N: usize>(scene: &Scene, arguments: &Arguments, rays: &RayBatch, answers: &mut Answers) {
    let (mut packet, mut active) = (Packet::<N>::new(), Active([-1; N]));
    answers.resize(rays.len());
    let occluded = &mut answers.occluded[..rays.len()];
    let mut first = 0;
    while first < rays.len() {
        load(rays, first, &mut packet, &mut active);
        scene.occluded(&active, &mut packet, arguments);
        for lane in 0..N.min(rays.len() - first) {
            occluded[first + lane] = packet.t_far[lane] == f32::NEG_INFINITY;
        }
        first += N;
    }
}

/// The library that `EMBREE4_LIB` names, for tests; without it they print that they are skipped.
#[cfg(test)]
pub(crate) fn embree_of_tests() -> Option<EmbreeLibrary> {
    let Some(file) = std::env::var_os("EMBREE4_LIB") else {
        eprintln!("skipped: EMBREE4_LIB names no library of Embree 4");
        return None;
    };
    Some(EmbreeLibrary::open(Path::new(&file)).expect("Embree 4"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::timing::ask;
    use gnurt::accel::Ray;

    #[test]
    fn what_is_no_embree_is_refused() {
        let message = |file: &str| EmbreeLibrary::open(Path::new(file)).err().map(|e| e.to_string());
        assert!(message("no/such/library.so").is_some_and(|m| m.contains("no/such/library.so")), "missing");
        let libc = ["/lib/x86_64-linux-gnu/libc.so.6", "/lib/aarch64-linux-gnu/libc.so.6"];
        for file in libc.into_iter().filter(|file| Path::new(file).exists()) {
            assert!(message(file).is_some_and(|m| m.contains("not Embree 4")), "{file} is another library");
        }
    }

    #[test]
    fn finds_the_triangle() {
        let Some(library) = embree_of_tests() else { return };
        let device = library.device(Level::best(), 0).expect("a device");
        let padded = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0; 3]];
        for kind in EmbreeKind::ALL {
            let (quality, flags) = kind.settings();
            let scene = Scene::build(&device, &padded, &[[0, 1, 2]], quality, flags).expect("it builds");
            // Nineteen rays: whole packets and a part of one.
            let rays: RayBatch =
                (0..19).map(|i| Ray::new([(i as f32 + 0.5) / 16.0, 0.01, 2.0], [0.0, 0.0, -0.5])).collect();
            for size in [1, 4, 8, 16].into_iter().filter(|&size| device.has_packets(size)) {
                let mut answers = Answers::default();
                let engine = EmbreeEngine { scene: &scene, packets: Packets { size, coherent: size == 8 } };
                for any in [false, true] {
                    ask(&engine, any, &rays, &mut answers);
                }
                for i in 0..19 {
                    let is_hit = i < 16;
                    assert_eq!(answers.occluded[i], is_hit, "ray {i} of {size} at once");
                    // Now and then Embree's is one rounding off.
                    let t = answers.hits.t[i];
                    let is_right = if is_hit { (t - 4.0).abs() < 1e-5 } else { t == f32::INFINITY };
                    assert!(is_right, "ray {i} of {size} at once is hit at {t}, not 4");
                }
            }
        }
    }
}
