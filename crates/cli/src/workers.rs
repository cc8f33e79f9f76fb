// SPDX-License-Identifier: GPL-3.0-or-later
//! Threads and instruction set of a command. Tests: `tests/program/arguments.rs`.

use crate::arguments::MachineArguments;
use crate::environment::Environment;
use crate::failure::Failure;

/// Options take precedence over the environment, which takes precedence over the machine's properties.
pub(crate) fn machine(
    arguments: &MachineArguments,
    environment: &Environment,
) -> Result<(gnurt::ThreadPool, gnurt::simd::Level), Failure> {
    let threads = arguments.threads.or(environment.threads).unwrap_or(0);
    let pool = gnurt::thread_pool(threads).map_err(Failure::data)?;
    Ok((pool, arguments.isa.or(environment.isa).unwrap_or_default()))
}
