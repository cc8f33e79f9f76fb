// SPDX-License-Identifier: GPL-3.0-or-later
//! One model file of a 3MF archive: its objects, colours and items.
//! Source: 3MF Core Specification 1.3, sections 3 to 5; Materials and Properties Extension 1.2, section 3.
//! Invariant: corners are in range, and their budget is charged before they are kept. Tests: `tests/solids.rs`.

use std::collections::HashMap;
use std::path::Path;

use gnurt_image::{Excess, srgb};

use super::xml::{Element, Elements, plain};
use crate::affine::Affine;
use crate::io::error::quoted;
use crate::io::source::Access;
use crate::io::{Error, Oddity, Warnings};

/// A model file.
pub(super) struct Model {
    pub(super) metres_per_unit: f64,
    pub(super) objects: HashMap<u32, Part>,
    pub(super) items: Vec<Placed>,
}

/// An object.
pub(super) struct Part {
    pub(super) name: String,
    pub(super) body: Body,
}

/// What an object is made of.
pub(super) enum Body {
    /// Corners, and triangles with their colours, linear.
    Mesh { positions: Vec<[f32; 3]>, triangles: Vec<([u32; 3], Option<[f32; 4]>)> },
    /// Other objects.
    Components(Vec<Placed>),
}

/// An object at a place.
pub(super) struct Placed {
    pub(super) object: u32,
    /// The file that defines it, if another one does.
    pub(super) file: Option<String>,
    pub(super) transform: Affine,
}

/// The object that is read now.
struct Open {
    id: u32,
    name: String,
    /// Group and index of its colour.
    color: (Option<u32>, usize),
    positions: Vec<[f32; 3]>,
    triangles: Vec<([u32; 3], Option<[f32; 4]>)>,
    components: Vec<Placed>,
}

/// Reads a model file; `part` is its name in the archive.
pub(super) fn read(
    text: &str,
    part: &str,
    path: &Path,
    access: &Access,
    warnings: &mut Warnings,
) -> Result<Model, Error> {
    let mut elements = Elements::new(text);
    let mut reader = Reader {
        model: Model { metres_per_unit: 1e-3, objects: HashMap::new(), items: Vec::new() },
        groups: HashMap::new(),
        group: None,
        open: None,
    };
    loop {
        let next = elements.next().map_err(str::to_owned);
        let done = match next {
            Ok(None) => return Ok(reader.model),
            Ok(Some(element)) => reader.element(&element, access, |what| {
                warnings.note(Oddity::NotShown, path, None, what);
            }),
            Err(why) => Err((why, "expected XML")),
        };
        if let Err((problem, remedy)) = done {
            let problem = format!("line {} of {part}: {problem}", elements.line());
            return Err(Error::data(path, None, problem, remedy));
        }
    }
}

/// A fault and its remedy.
type Fault = (String, &'static str);

struct Reader {
    model: Model,
    /// Linear colours of groups.
    groups: HashMap<u32, Vec<[f32; 4]>>,
    group: Option<u32>,
    open: Option<Open>,
}

impl Reader {
    fn element(&mut self, e: &Element<'_>, access: &Access, mut lost: impl FnMut(&str)) -> Result<(), Fault> {
        let hold =
            |bytes: usize| access.budget.hold(bytes).map_err(|excess| (excess.to_string(), Excess::REMEDY));
        if !e.opens {
            match e.name {
                "object" => self.close(),
                "basematerials" | "colorgroup" => self.group = None,
                _ => {}
            }
            return Ok(());
        }
        match e.name {
            "model" => self.model.metres_per_unit = unit(e.get("unit").unwrap_or("millimeter"))?,
            "basematerials" | "colorgroup" => {
                let id = number(e, "id")?;
                self.group = (!e.closes).then_some(id);
                self.groups.insert(id, Vec::new());
            }
            "base" | "color" => {
                let written = e.get("displaycolor").or(e.get("color")).unwrap_or("#FFFFFF");
                if let Some(group) = self.group.and_then(|id| self.groups.get_mut(&id)) {
                    hold(size_of::<[f32; 4]>())?;
                    group.push(color(written)?);
                }
            }
            "texture2dgroup" | "compositematerials" | "multiproperties" | "slicestack" => lost(e.name),
            "object" => {
                let id = number(e, "id")?;
                let name = e.get("name").map_or_else(|| format!("object {id}"), plain);
                hold(size_of::<Part>() + name.len())?;
                let color = (optional(e, "pid")?, optional(e, "pindex")?.unwrap_or(0) as usize);
                let lists = (Vec::new(), Vec::new(), Vec::new());
                let (positions, triangles, components) = lists;
                self.open = Some(Open { id, name, color, positions, triangles, components });
                if e.closes {
                    self.close();
                }
            }
            "vertex" => {
                let Some(open) = &mut self.open else { return Ok(()) };
                hold(size_of::<[f32; 3]>())?;
                let [x, y, z] = ["x", "y", "z"].map(|axis| e.get(axis).and_then(|x| x.trim().parse().ok()));
                let (Some(x), Some(y), Some(z)) = (x, y, z) else {
                    return Err(("vertex without x, y and z".into(), "expected 3 numbers"));
                };
                open.positions.push([x, y, z]);
            }
            "triangle" => self.triangle(e, hold)?,
            "component" => {
                let placed = placed(e)?;
                if let Some(open) = &mut self.open {
                    hold(2 * size_of::<Placed>())?;
                    open.components.push(placed);
                }
            }
            "item" => {
                hold(2 * size_of::<Placed>())?;
                self.model.items.push(placed(e)?);
            }
            _ => {}
        }
        Ok(())
    }

    fn triangle(&mut self, e: &Element<'_>, hold: impl Fn(usize) -> Result<(), Fault>) -> Result<(), Fault> {
        let Some(open) = &mut self.open else { return Ok(()) };
        hold(size_of::<([u32; 3], Option<[f32; 4]>)>() + size_of::<[u32; 3]>())?;
        let corners = [number(e, "v1")?, number(e, "v2")?, number(e, "v3")?];
        if let Some(bad) = corners.iter().find(|&&i| i as usize >= open.positions.len()) {
            return Err((format!("vertex {bad} out of range"), "expected one of the object's vertices"));
        }
        let own = optional(e, "pid")?;
        let index = match optional(e, "p1")? {
            Some(index) => index as usize,
            None => open.color.1,
        };
        let group = own.or(open.color.0).and_then(|id| self.groups.get(&id));
        let color = group.and_then(|group| group.get(index)).copied();
        open.triangles.push((corners, color));
        Ok(())
    }

    fn close(&mut self) {
        let Some(open) = self.open.take() else { return };
        let Open { id, name, positions, triangles, components, .. } = open;
        let body = match components.is_empty() {
            true => Body::Mesh { positions, triangles },
            false => Body::Components(components),
        };
        self.model.objects.insert(id, Part { name, body });
    }
}

fn unit(name: &str) -> Result<f64, Fault> {
    Ok(match name {
        "micron" => 1e-6,
        "millimeter" => 1e-3,
        "centimeter" => 1e-2,
        "inch" => 0.0254,
        "foot" => 0.3048,
        "meter" => 1.0,
        _ => return Err((format!("unit {}", quoted(name)), "valid are micron, millimeter, inch and others")),
    })
}

fn number(e: &Element<'_>, name: &str) -> Result<u32, Fault> {
    optional(e, name)?.ok_or_else(|| (format!("{} without {name}", quoted(e.name)), "expected a number"))
}

fn optional(e: &Element<'_>, name: &str) -> Result<Option<u32>, Fault> {
    let Some(text) = e.get(name) else { return Ok(None) };
    let wrong = || (format!("{name}={} of {}", quoted(text), quoted(e.name)), "expected a whole number");
    text.trim().parse().map(Some).map_err(|_| wrong())
}

fn placed(e: &Element<'_>) -> Result<Placed, Fault> {
    let transform = match e.get("transform") {
        None => Affine::IDENTITY,
        Some(text) => {
            let numbers: Option<Vec<f64>> = text.split_ascii_whitespace().map(|x| x.parse().ok()).collect();
            let numbers = numbers.filter(|all| all.len() == 12 && all.iter().all(|x| x.is_finite()));
            let Some(m) = numbers else {
                return Err((format!("transform {}", quoted(text)), "expected 12 numbers"));
            };
            // Rows of the file are images of the axes.
            Affine { columns: [0, 3, 6, 9].map(|k| [m[k], m[k + 1], m[k + 2]]) }
        }
    };
    Ok(Placed { object: number(e, "objectid")?, file: e.get("path").map(plain), transform })
}

/// `#RRGGBB` or `#RRGGBBAA`, sRGB.
fn color(text: &str) -> Result<[f32; 4], Fault> {
    let digits = text.trim().strip_prefix('#').filter(|digits| digits.is_ascii());
    let part = |k: usize| {
        let pair = digits?.get(2 * k..2 * k + 2)?;
        u8::from_str_radix(pair, 16).ok()
    };
    let (Some(r), Some(g), Some(b)) = (part(0), part(1), part(2)) else {
        return Err((format!("colour {}", quoted(text)), "expected #RRGGBB"));
    };
    let [r, g, b] = [r, g, b].map(|byte| srgb::decode(f32::from(byte) / 255.0));
    Ok([r, g, b, f32::from(part(3).unwrap_or(255)) / 255.0])
}
