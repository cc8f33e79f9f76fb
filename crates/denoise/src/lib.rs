// SPDX-License-Identifier: GPL-3.0-or-later
//! Takes the noise out of rendered pictures.
//! The filter is after \[RKZ12\], \[MCY14\] and \[BRM*16\].
//!
//! Two methods: a filter without dependencies ([`Method::BuiltIn`]), and Intel's Open Image Denoise if its
//! library is found at run time ([`Method::Oidn`]). Both use features of camera rays' hits, which have
//! little noise. The picture must have the layers `albedo`, `N` and `variance` of a rendering; those of mirrors and glass
//! (`seen_*`) come first. `unscattered`, the directly visible light, keeps the edges of lights sharp.
//! Space: linear light.
//!
//! # Limits today
//! * Biased, as denoisers are: detail finer than the noise is blurred.
//! * Films: points behind curved mirrors and glass move by other laws than the layer of motion expects, and borrow less.
//! * Reflections of rough surfaces have no layers: their edges are preserved by colours only.
#![deny(unsafe_code)]

mod built_in;
mod details;
mod error;
mod explain;
#[allow(unsafe_code, reason = "the one door to the library of C")]
mod ffi_oidn;
pub mod film;
mod light;
mod method;
mod noisy;
mod oidn;
mod other_renderers;
mod outliers;
mod patches;
mod regression;
mod variance;

pub use error::Error;
pub use method::{Method, Used};
pub use other_renderers::{adopt, has_motion};

use std::path::PathBuf;

use gnurt_image::{Layer, Picture};

use crate::noisy::Noisy;

/// The method, and the region.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Options {
    /// Which denoiser.
    pub method: Method,
    /// `[x0, y0, x1, y1]` in pixels, upper left origin, `x1` and `y1` exclusive: only this part was rendered. `None` = all.
    pub region: Option<[u32; 4]>,
    /// OIDN's library; `None` = wherever the system's loader finds `libOpenImageDenoise.so.2`.
    pub library: Option<PathBuf>,
}

/// Whether the options can be satisfied, for programs that fail early.
///
/// # Errors
/// [`Error::Oidn`] if OIDN is requested and cannot be used.
pub fn check(options: &Options) -> Result<(), Error> {
    match options.method {
        Method::Oidn => oidn::check(options.library.as_deref()),
        Method::Auto | Method::BuiltIn => Ok(()),
    }
}

/// Replaces the picture's colours by denoised ones, and stores the original ones as layer `noisy`. Opacity
/// stays.
///
/// # Errors
/// [`Error`] if a layer is missing, the region is no part of the picture, or OIDN was requested and cannot be
/// used; the picture has not changed then.
pub fn denoise(picture: &mut Picture, options: &Options, pool: &rayon::ThreadPool) -> Result<Used, Error> {
    let used = denoise_unless(&|| false, picture, options, pool)?;
    Ok(used.unwrap_or(Used::BuiltIn { without_oidn: None }))
}

/// The colours before the filter, as a layer.
fn noisy_layer(picture: &Picture) -> Layer {
    let before = |k: usize| picture.color.iter().map(|pixel| pixel[k]).collect();
    Layer::floats("noisy", [("R", before(0)), ("G", before(1)), ("B", before(2))])
}

/// As [`denoise`], but ends as soon as `stop` returns true, which is called from all threads: the picture has
/// not changed then, and the result is `None`. The built-in filter calls it once for every few rows, OIDN
/// does not.
///
/// # Errors
/// As [`denoise`].
pub fn denoise_unless(
    stop: &(dyn Fn() -> bool + Sync),
    picture: &mut Picture,
    options: &Options,
    pool: &rayon::ThreadPool,
) -> Result<Option<Used>, Error> {
    let region = options.region.unwrap_or([0, 0, picture.width, picture.height]);
    let noisy = Noisy::of(picture, region)?;
    let by_itself = |without_oidn| {
        built_in::filter(&noisy, pool, stop).map(|clean| (clean, Used::BuiltIn { without_oidn }))
    };
    let oidn = || oidn::filter(&noisy, options.library.as_deref(), pool.current_num_threads());
    let done = match options.method {
        Method::BuiltIn => by_itself(None),
        Method::Oidn => Some(oidn()?),
        Method::Auto => oidn().map_or_else(|why| by_itself(Some(why.to_string())), Some),
    };
    let Some((clean, used)) = done else { return Ok(None) };
    picture.layers.push(noisy_layer(picture));
    let [x0, y0, x1, y1] = region.map(|x| x as usize);
    let rows = picture.color.chunks_exact_mut(picture.width as usize);
    for (row, clean) in rows.take(y1).skip(y0).zip(clean.chunks_exact(x1 - x0)) {
        for (pixel, clean) in row[x0..x1].iter_mut().zip(clean) {
            pixel[..3].copy_from_slice(clean);
        }
    }
    Ok(Some(used))
}
