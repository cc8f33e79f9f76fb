// SPDX-License-Identifier: GPL-3.0-or-later
//! Takes the noise out of rendered pictures.
//! Source: original; the filter is after \[RKZ12\], \[MCY14\] and \[BRM*16\].
//!
//! Two ways: a filter that needs nothing ([`Method::BuiltIn`]), and Intel's Open Image Denoise where its library is found
//! at run time ([`Method::Oidn`]). Both look at what camera rays met first, which is hardly noisy: the picture must have the
//! layers `albedo`, `N`, `P` and `variance` of a rendering. Space: linear light.
//!
//! # Limits today
//! * Biased, as denoisers are: what is finer than the noise is blurred.
//! * What is seen in mirrors and through glass has no layers of its own: edges there are kept by their colours alone.
#![deny(unsafe_code)]

mod built_in;
mod error;
#[allow(unsafe_code, reason = "the one door to the library of C")]
mod ffi_oidn;
mod noisy;
mod oidn;
mod patches;
mod regression;

pub use error::Error;

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

use gnurt_image::{Layer, Picture};

use crate::noisy::Noisy;

/// Which denoiser is wanted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Method {
    /// OIDN where its library is found, else the built-in one.
    #[default]
    Auto,
    /// The built-in one: the same bits on any number of threads.
    BuiltIn,
    /// OIDN's, or an error.
    Oidn,
}

impl Method {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Auto, Self::BuiltIn, Self::Oidn];

    /// The name on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::BuiltIn => "built-in",
            Self::Oidn => "oidn",
        }
    }
}

impl FromStr for Method {
    type Err = Error;

    fn from_str(name: &str) -> Result<Self, Error> {
        let found = Self::ALL.into_iter().find(|method| method.name() == name);
        found.ok_or_else(|| Error::UnknownMethod(name.into()))
    }
}

/// What is to be done, and where.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Options {
    /// Which denoiser.
    pub method: Method,
    /// `[x0, y0, x1, y1]` in pixels, upper left origin, `x1` and `y1` exclusive: only this part was rendered. `None` = all.
    pub region: Option<[u32; 4]>,
    /// OIDN's library; `None` = wherever the system's loader finds `libOpenImageDenoise.so.2`.
    pub library: Option<PathBuf>,
}

/// Which denoiser was used.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Used {
    /// The built-in one. The text says why it was not OIDN's, if that was looked for.
    BuiltIn {
        /// Why OIDN was not used; `None` if nobody asked for it.
        without_oidn: Option<String>,
    },
    /// OIDN's.
    Oidn {
        /// As the library says: `2.3.3`.
        version: String,
        /// What it ran on, as in `OIDN_DEVICE_TYPE_CPU`: `CPU`.
        device: &'static str,
    },
}

impl Used {
    /// For a file's header: `built-in` or `oidn 2.3.3`.
    #[must_use]
    pub fn name(&self) -> String {
        match self {
            Self::BuiltIn { .. } => Method::BuiltIn.name().into(),
            Self::Oidn { version, .. } => format!("{} {version}", Method::Oidn.name()),
        }
    }
}

impl fmt::Display for Used {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::BuiltIn { without_oidn: None } => write!(f, "denoised by the built-in filter"),
            Self::BuiltIn { without_oidn: Some(why) } => {
                write!(f, "denoised by the built-in filter: {why}")
            }
            Self::Oidn { version, device } => {
                write!(f, "denoised by Open Image Denoise {version} on the {device}")
            }
        }
    }
}

/// Whether what the options ask for can be had, for programs that fail early.
///
/// # Errors
/// [`Error::Oidn`] if OIDN is asked for and cannot be used.
pub fn check(options: &Options) -> Result<(), Error> {
    match options.method {
        Method::Oidn => oidn::check(options.library.as_deref()),
        Method::Auto | Method::BuiltIn => Ok(()),
    }
}

/// Replaces the picture's colours by denoised ones, and keeps those that it had as layer `noisy`. Opacity stays.
///
/// # Errors
/// [`Error`] if a layer is missing, the region is no part of the picture, or OIDN was asked for and cannot be used; the
/// picture has not changed then.
pub fn denoise(picture: &mut Picture, options: &Options, pool: &rayon::ThreadPool) -> Result<Used, Error> {
    let used = denoise_unless(&|| false, picture, options, pool)?;
    Ok(used.unwrap_or(Used::BuiltIn { without_oidn: None }))
}

/// As [`denoise`], but gives up as soon as `stop` says so, which is called from all threads: the picture has not changed then,
/// and the answer is `None`. The built-in filter asks about a hundred times for a picture, OIDN does not.
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
    let before = |k: usize| picture.color.iter().map(|pixel| pixel[k]).collect();
    let layer = Layer::floats("noisy", [("R", before(0)), ("G", before(1)), ("B", before(2))]);
    picture.layers.push(layer);
    let [x0, y0, x1, y1] = region.map(|x| x as usize);
    let rows = picture.color.chunks_exact_mut(picture.width as usize);
    for (row, clean) in rows.take(y1).skip(y0).zip(clean.chunks_exact(x1 - x0)) {
        for (pixel, clean) in row[x0..x1].iter_mut().zip(clean) {
            pixel[..3].copy_from_slice(clean);
        }
    }
    Ok(Some(used))
}
