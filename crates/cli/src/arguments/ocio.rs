// SPDX-License-Identifier: GPL-3.0-or-later
//! Options for displays and views of OpenColorIO. Tests: `tests/program/ocio.rs`.

use clap::Args;

/// A view in place of a tone curve.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "Look")]
pub(crate) struct OcioArguments {
    /// Write PNG, JPEG and WebP files by a view of this OpenColorIO configuration instead of a tone curve: a file (.ocio, .ocioz) or ocio://NAME, such as ocio://default
    #[arg(
        id = "ocio_config",
        long = "ocio",
        value_name = "CONFIG",
        conflicts_with = "tone",
        hide_short_help = true
    )]
    pub(crate) config: Option<String>,
    /// Display of the configuration [default: its own]
    #[arg(
        id = "ocio_display",
        long = "ocio-display",
        value_name = "NAME",
        requires = "ocio_config",
        hide_short_help = true
    )]
    pub(crate) display: Option<String>,
    /// View of the display [default: its own]
    #[arg(
        id = "ocio_view",
        long = "ocio-view",
        value_name = "NAME",
        requires = "ocio_config",
        hide_short_help = true
    )]
    pub(crate) view: Option<String>,
    /// Looks between commas, instead of those of the view
    #[arg(
        id = "ocio_looks",
        long = "ocio-looks",
        value_name = "LIST",
        requires = "ocio_config",
        allow_hyphen_values = true,
        hide_short_help = true
    )]
    pub(crate) looks: Option<String>,
    /// The configuration's colour space of linear light with Rec. 709 primaries [default: found by name or roles]
    #[arg(
        id = "ocio_space",
        long = "ocio-space",
        value_name = "NAME",
        requires = "ocio_config",
        hide_short_help = true
    )]
    pub(crate) space: Option<String>,
}
