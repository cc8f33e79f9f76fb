// SPDX-License-Identifier: GPL-3.0-or-later
//! Objects (rtGenObjects, rtNewObject, rtCreateObject, rtEndObject, rtInstantiateObject, rtNestObject,
//! rtRemoveObject, rtIsObject).
//! Source: \[DWBS03\], the paper's Figure 1; display lists of OpenGL 1.x. Tests: tests/c/scene.c, tests/c/errors.c.

use crate::context::Context;
use crate::state::block::Assembly;
use crate::state::enums::ObjectMode;
use crate::state::error::{Error, Result};
use crate::state::object::{Definition, Nested, OpenObject};

impl Context {
    /// rtGenObjects.
    pub(crate) fn gen_objects(&mut self, count: i32) -> Result<u32> {
        self.outside_block()?;
        self.no_open_object()?;
        self.objects.reserve(count)
    }

    /// rtNewObject with two arguments.
    pub(crate) fn new_object(&mut self, id: u32, mode: u32) -> Result<u32> {
        self.outside_block()?;
        self.no_open_object()?;
        let mode = ObjectMode::from_code(mode)?;
        self.objects.ids.check(id)?;
        self.open_object(id, mode);
        Ok(id)
    }

    /// rtCreateObject: rtNewObject with one argument.
    pub(crate) fn create_object(&mut self, mode: u32) -> Result<u32> {
        self.outside_block()?;
        self.no_open_object()?;
        let mode = ObjectMode::from_code(mode)?;
        let id = self.objects.reserve(1)?;
        self.open_object(id, mode);
        Ok(id)
    }

    /// The function `rtNewObject` as programs without its prototype call it: the first argument may be the mode.
    pub(crate) fn new_object_either_form(&mut self, first: u32, second: u32) -> Result<u32> {
        let is_mode = first == ObjectMode::Define.code() || first == ObjectMode::DefineAndInstantiate.code();
        if is_mode { self.create_object(first) } else { self.new_object(first, second) }
    }

    fn open_object(&mut self, id: u32, mode: ObjectMode) {
        self.bound.restart_values();
        self.open = Some(OpenObject { id, mode, assembly: Assembly::default(), nested: Vec::new() });
    }

    /// rtEndObject.
    pub(crate) fn end_object(&mut self) -> Result<()> {
        self.outside_block()?;
        let open = self.open.take().ok_or(Error::InvalidOperation)?;
        self.close(open).map(|_| ())
    }

    /// rtInstantiateObject.
    pub(crate) fn instantiate_object(&mut self, id: u32) -> Result<u32> {
        self.outside_block()?;
        match self.open.take() {
            None => {
                self.objects.ids.check(id)?;
                self.add_instance(id)
            }
            Some(open) if open.id == id => match self.close(open)? {
                Some(instance) => Ok(instance),
                None => self.add_instance(id),
            },
            Some(other) => {
                self.open = Some(other);
                Err(Error::InvalidOperation)
            }
        }
    }

    /// rtNestObject.
    pub(crate) fn nest_object(&mut self, id: u32, mask: u32) -> Result<()> {
        self.outside_block()?;
        let object_from_nested = self.modelview();
        let open = self.open.as_mut().ok_or(Error::InvalidOperation)?;
        self.objects.ids.check(id)?;
        if open.id == id {
            return Err(Error::InvalidOperation);
        }
        open.nested.push(Nested { object: id, object_from_nested, mask });
        Ok(())
    }

    /// Stores the contents of an open object. Returns the instance, if its mode creates one.
    fn close(&mut self, open: OpenObject) -> Result<Option<u32>> {
        let (geometry, nested) = (open.assembly.geometry, open.nested);
        if open.mode == ObjectMode::Update {
            let known = self.objects.get(open.id);
            let known_vertices = known.map_or(0, |known| known.vertices_given);
            let objects = |nested: &[Nested]| nested.iter().map(|nested| nested.object).collect::<Vec<_>>();
            let known_objects = known.map_or_else(Vec::new, |known| objects(&known.nested));
            if geometry.vertices_given != known_vertices || objects(&nested) != known_objects {
                return Err(Error::InvalidOperation);
            }
        }
        if !self.objects.may_hold(open.id, &nested) {
            return Err(Error::InvalidOperation);
        }
        self.objects.define(open.id, Definition::of(geometry, nested));
        match open.mode {
            ObjectMode::DefineAndInstantiate => self.add_instance(open.id).map(Some),
            ObjectMode::Define | ObjectMode::Update => Ok(None),
        }
    }

    /// rtRemoveObject.
    pub(crate) fn remove_object(&mut self, id: u32) -> Result<()> {
        self.outside_block()?;
        self.no_open_object()?;
        self.objects.remove(id)
    }

    /// rtIsObject.
    pub(crate) fn is_object(&self, id: u32) -> Result<bool> {
        self.outside_block()?;
        Ok(self.objects.ids.exists(id))
    }
}
