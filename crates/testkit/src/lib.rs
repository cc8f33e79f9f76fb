// SPDX-License-Identifier: GPL-3.0-or-later
//! Oracles, scene makers and assertions for tests; never published.
