// SPDX-License-Identifier: GPL-3.0-or-later
//! Whether and how noise is taken out of a picture. Source: original. Proof: `tests/program/denoising.rs`.

use clap::Args;
use gnurt::denoise::{Method, Options};

/// The option of those who write pictures.
#[derive(Args, Clone, Copy, Debug, Default)]
pub(crate) struct DenoiserArguments {
    /// Take the noise out of the picture: auto (OIDN where its library is found or OIDN_LIB names it, else built-in),
    /// built-in, oidn
    #[arg(
        long,
        value_name = "HOW",
        value_parser = super::value::denoiser,
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = "auto"
    )]
    pub(crate) denoise: Option<Method>,
}

/// The variable that names OIDN's library.
const OIDN: &str = "OIDN_LIB";

impl DenoiserArguments {
    /// How a picture is to be denoised of which only `region` was rendered, if at all.
    pub(crate) fn options(self, region: Option<[u32; 4]>) -> Option<Options> {
        let library = std::env::var_os(OIDN).filter(|file| !file.is_empty()).map(Into::into);
        self.denoise.map(|method| Options { method, region, library })
    }
}
