// SPDX-License-Identifier: GPL-3.0-or-later
//! The listener for errors (rtDebugCallback). Source: after OpenGL's KHR_debug. Tests: tests/c/debug.c.

use std::sync::Arc;

use crate::context::Context;
use crate::state::error::Result;
use crate::state::listener::{Hearing, Listener};

impl Context {
    /// rtDebugCallback: returns the one before, of which calls may still be in progress.
    pub(crate) fn set_listener(&mut self, listener: Option<Arc<Listener>>) -> Result<Option<Arc<Listener>>> {
        self.outside_block()?;
        Ok(std::mem::replace(&mut self.listener, listener))
    }

    /// The right to report an error to the listener, if there is one.
    pub(crate) fn hearing(&self) -> Option<Hearing> {
        self.listener.as_ref().map(Listener::hearing)
    }
}
