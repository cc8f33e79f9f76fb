// SPDX-License-Identifier: GPL-3.0-or-later
//! Whether and how noise is taken out of a picture. Tests: `tests/program/denoising.rs`.

use clap::Args;
use gnurt::denoise::{Method, Options};

use super::value::{self, DenoiserChoice};

/// The option of commands that write pictures.
#[derive(Args, Clone, Copy, Debug, Default)]
#[command(next_help_heading = "Quality")]
pub(crate) struct DenoiserArguments {
    /// Denoiser: auto (OIDN if its library is found or named by OIDN_LIB, else built-in), built-in, oidn or none; `render` and
    /// `view` denoise by default, see --help-all
    #[arg(
        long,
        value_name = "HOW",
        value_parser = value::denoiser,
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = "auto",
        long_help = "Denoiser: auto (OIDN if its library is found or named by OIDN_LIB, else built-in), built-in, oidn or none. \
                     By default the built-in filter denoises PNGs of fewer than 256 samples per pixel by path, ir, bir or mir \
                     in `render`, and still pictures in `view`; EXR, HDR and PFM keep their noise."
    )]
    pub(crate) denoise: Option<DenoiserChoice>,
}

/// The variable that names OIDN's library.
const OIDN: &str = "OIDN_LIB";

impl DenoiserArguments {
    /// The filter for a picture of which only `region` was rendered, if one is requested.
    pub(crate) fn options(self, region: Option<[u32; 4]>) -> Option<Options> {
        match self.denoise? {
            DenoiserChoice::None => None,
            DenoiserChoice::By(method) => Some(by(method, region)),
        }
    }

    /// The same, with the built-in filter, whose bits are the same everywhere, as the default.
    pub(crate) fn options_or_built_in(self, region: Option<[u32; 4]>) -> Option<Options> {
        match self.denoise {
            None => Some(by(Method::BuiltIn, region)),
            Some(_) => self.options(region),
        }
    }

    /// Whether it is left to the program.
    pub(crate) fn is_left_open(self) -> bool {
        self.denoise.is_none()
    }
}

fn by(method: Method, region: Option<[u32; 4]>) -> Options {
    let library = std::env::var_os(OIDN).filter(|file| !file.is_empty()).map(Into::into);
    Options { method, region, library }
}
