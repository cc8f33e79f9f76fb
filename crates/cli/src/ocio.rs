// SPDX-License-Identifier: GPL-3.0-or-later
//! Pictures by a view of an OpenColorIO configuration, in programs that were compiled with it.
//! Tests: `tests/program/ocio.rs`.

#[cfg(feature = "ocio")]
pub(crate) use with::View;
#[cfg(not(feature = "ocio"))]
pub(crate) use without::View;

#[cfg(feature = "ocio")]
mod with {
    use std::sync::Arc;

    use gnurt::image::Picture;
    use gnurt::ocio;

    use crate::arguments::OcioArguments;
    use crate::failure::Failure;
    use crate::workers::with_workers;

    /// A view of a display.
    #[derive(Clone, Debug)]
    pub(crate) struct View(Arc<ocio::View>);

    impl View {
        /// The requested one, if one is.
        pub(crate) fn of(arguments: &OcioArguments) -> Result<Option<Self>, Failure> {
            let Some(config) = &arguments.config else { return Ok(None) };
            let request = ocio::Request {
                config,
                display: arguments.display.as_deref(),
                view: arguments.view.as_deref(),
                looks: arguments.looks.as_deref(),
                source: arguments.space.as_deref(),
            };
            let view = ocio::View::new(&request).map_err(|error| match error {
                ocio::Error::Config { .. } => Failure::data(format_args!("--ocio {error}")),
                ocio::Error::UnknownName { .. } => Failure::usage(format_args!("--ocio {error}")),
                ocio::Error::NoSource { .. } => {
                    Failure::usage(format_args!("--ocio {error}: give --ocio-space NAME"))
                }
            })?;
            Ok(Some(Self(Arc::new(view))))
        }

        /// The picture as the display shows it.
        pub(crate) fn shown(&self, picture: &Picture, exposure: f32) -> Picture {
            with_workers(|workers| self.0.shown(picture, exposure, workers))
        }
    }
}

#[cfg(not(feature = "ocio"))]
mod without {
    use gnurt::image::Picture;

    use crate::arguments::OcioArguments;
    use crate::failure::Failure;

    /// None is ever made.
    #[derive(Clone, Debug)]
    pub(crate) enum View {}

    impl View {
        /// Rejects a request.
        pub(crate) fn of(arguments: &OcioArguments) -> Result<Option<Self>, Failure> {
            match &arguments.config {
                None => Ok(None),
                Some(_) => Err(Failure::usage(
                    "--ocio: this program was compiled without OpenColorIO; `cargo build --release --features ocio` has \
                     it, and so have the Python package and `cargo xtask install`",
                )),
            }
        }

        pub(crate) fn shown(&self, _: &Picture, _: f32) -> Picture {
            match *self {}
        }
    }
}
