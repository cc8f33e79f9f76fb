// SPDX-License-Identifier: GPL-3.0-or-later
//! The interpreter, or machine code.

use std::sync::Arc;

use gnurt_sl::exec::{Plan, Program};

/// How groups of a system are run. Copies share machine code.
#[derive(Clone, Debug, Default)]
pub(crate) struct Engines {
    #[cfg(feature = "jit")]
    codes: Arc<gnurt_jit::Cache>,
    pub(crate) is_interpreted: bool,
}

/// The program that runs a group.
pub(crate) enum Engine {
    Interpreter(Arc<Plan>),
    #[cfg(feature = "jit")]
    Code(gnurt_jit::Job),
}

impl Engine {
    pub(crate) fn new(engines: &Engines, plan: &Arc<Plan>) -> Self {
        #[cfg(feature = "jit")]
        if let level = gnurt_simd::Level::best()
            && gnurt_jit::Compiled::can(level)
            && !engines.is_interpreted
        {
            return Self::Code(engines.codes.start(plan.clone(), level));
        }
        let _ = engines.is_interpreted;
        Self::Interpreter(plan.clone())
    }

    pub(crate) fn program(&self) -> &dyn Program {
        match self {
            Self::Interpreter(plan) => &**plan,
            #[cfg(feature = "jit")]
            Self::Code(job) => job,
        }
    }

    /// Waits until there is machine code; returns whether there is some.
    pub(crate) fn wait(&self) -> bool {
        match self {
            Self::Interpreter(_) => false,
            #[cfg(feature = "jit")]
            Self::Code(job) => job.wait().is_ok(),
        }
    }

    /// Bytes of machine code, and operations that are interpreted beside it, where there is some.
    pub(crate) fn sizes(&self) -> Option<[usize; 2]> {
        match self {
            Self::Interpreter(_) => None,
            #[cfg(feature = "jit")]
            Self::Code(job) if !job.is_ready() => None,
            #[cfg(feature = "jit")]
            Self::Code(job) => job.wait().ok().map(|code| [code.size(), code.calls()]),
        }
    }
}
