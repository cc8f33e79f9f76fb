// SPDX-License-Identifier: GPL-3.0-or-later
//! Tests of documents, and of the texts that they become.

mod documents;
mod hostile;
mod library;
mod made;
mod values;
