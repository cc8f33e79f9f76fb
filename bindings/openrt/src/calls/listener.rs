// SPDX-License-Identifier: GPL-3.0-or-later
//! Who hears of errors (rtDebugCallback). Source: original, after OpenGL's KHR_debug. Proof: tests/c/debug.c.

use crate::context::Context;
use crate::state::error::Result;
use crate::state::report::Listener;

impl Context {
    /// rtDebugCallback.
    pub(crate) fn set_listener(&mut self, listener: Option<Listener>) -> Result<()> {
        self.outside_block()?;
        self.listener = listener;
        Ok(())
    }

    /// Who wants to hear of errors.
    #[must_use]
    pub(crate) fn listener(&self) -> Option<Listener> {
        self.listener.clone()
    }
}
