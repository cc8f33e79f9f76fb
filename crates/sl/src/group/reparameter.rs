// SPDX-License-Identifier: GPL-3.0-or-later
//! Changes values of parameters that were declared to change.
//! The rules are OSL's.

use super::layers::Group;
use super::value::Value;

impl Group {
    /// Gives a parameter a new value; the owner of the plan makes it again, or changes its memory.
    ///
    /// # Errors
    /// The parameter cannot be changed.
    pub fn reparameter(&mut self, layer: &str, param: &str, value: &Value) -> Result<(), String> {
        let number = self.find(layer).ok_or_else(|| format!("ReParameter: no layer \"{layer}\""))?;
        let layer = &mut self.layers[number];
        let id = layer.shader.find(param).ok_or_else(|| format!("ReParameter: no parameter \"{param}\""))?;
        if !layer.interactive(id) && !layer.interpolated(id) {
            return Err(format!("ReParameter: \"{param}\" is not interactive"));
        }
        let (_, data) = value
            .fit(layer.shader.symbol(id).ty)
            .ok_or_else(|| format!("ReParameter: \"{param}\": wrong type"))?;
        layer.values.insert(id, data);
        Ok(())
    }
}
