// SPDX-License-Identifier: GPL-3.0-or-later
//! Caustics: light of small lamps that smooth surfaces bring to rough ones, by specular manifold sampling.
//! A rough point searches for a chain of mirrors and smooth glass that ends at a chosen point of a lamp. A walk begins at a
//! chosen point of a smooth surface and corrects its first direction by Newton's method. The light of the chain that it arrives
//! at counts once over the chance to arrive there, which is counted by further walks.
//! Source: [ZGJ20] (unbiased variant), [HDF15]; ray differentials [Ige99] in place of half vectors.
//! A scattered ray that meets some smooth surfaces and then such a lamp is weighed against searches (`chain`). Delta lamps straight
//! through glass are those of `panes`.
//! Space: world. Invariants: the result of a path depends on its ray and key only; without smooth surfaces or lamps nothing
//! changes. Tests: crates/render/tests/caustics.rs.

mod chain;
mod connect;
mod differential;
mod find;
mod known;
mod places;
mod rounds;
mod search;
mod smooth;
mod trace;
mod trials;
mod turn;
mod walk;

pub(crate) use chain::Chain;
pub(crate) use connect::connect;
pub(crate) use find::find;
pub(crate) use known::Caustics;
pub(crate) use places::{Places, Searched};
pub(crate) use rounds::{chance_of, search};
pub(crate) use search::Rough;
pub(crate) use smooth::SmoothPoint;
pub(crate) use turn::turned;
