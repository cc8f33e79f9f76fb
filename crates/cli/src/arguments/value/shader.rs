// SPDX-License-Identifier: GPL-3.0-or-later
//! Values that name shaders with their parameters, and values with a shader among other choices: cameras,
//! surroundings. See docs/reference/cli.md. Tests: `tests`.

use std::path::PathBuf;

use gnurt::BUILTIN;
use gnurt::Surroundings;
use gnurt::scene::builtin::SKIES;

use super::eye::point;
use crate::nearest::unknown;

/// A shader for the material of a name, or for all by `*`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct ShaderChoice {
    pub(crate) material: String,
    /// Of the shader's class.
    pub(crate) class: String,
    /// The plugin that has the class; none for built-in ones.
    pub(crate) file: Option<PathBuf>,
    /// Names and values.
    pub(crate) parameters: Vec<(String, String)>,
}

/// The camera, and its shader.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum CameraChoice {
    /// The scene's of this name or number.
    Named(String),
    /// A shader that replaces a material; the first one where its `material`, a camera here, is empty.
    Script(ShaderChoice),
}

/// A radiance, a sky of the program, or a file; `FILE.osl[:NAME=VALUE...]` if that is a shader.
pub(crate) fn surroundings(text: &str) -> Result<Surroundings, String> {
    if let Some(name) = text.strip_prefix(BUILTIN) {
        let names: Vec<&str> = SKIES.iter().map(|sky| sky.name).collect();
        return Surroundings::sky(name).ok_or_else(|| unknown("built-in sky", name, &names));
    }
    if text.is_empty() {
        return Err("give a picture, a radiance like 1,1,1 or builtin:day".into());
    }
    let first = pieces(text, ':')[0];
    let is_script = split_plain(first, '=').is_none() && gnurt_plugins::is_script(first);
    match point(text) {
        Ok(radiance) if radiance.iter().any(|&x| x < 0.0) => {
            Err("light is not negative; give R,G,B of 0 or more".into())
        }
        Ok(radiance) => Ok(Surroundings::Uniform(radiance)),
        Err(_) if is_script => match shader(text)? {
            ShaderChoice { class, file: None, parameters, .. } => {
                Ok(Surroundings::Shader(class.into(), parameters))
            }
            _ => Ok(Surroundings::Picture(text.into())),
        },
        Err(_) => Ok(Surroundings::Picture(text.into())),
    }
}

/// `MATERIAL=CLASS[@FILE][:NAME=VALUE...]`. A backslash before `:`, `=`, `@` or a backslash makes it a letter like any other.
pub(crate) fn shader(text: &str) -> Result<ShaderChoice, String> {
    const RIGHT: &str = "give MATERIAL=CLASS, MATERIAL=FILE.osl, MATERIAL=FILE.mtlx[:NODE], or MATERIAL=CLASS@FILE for a plugin's, and parameters as :NAME=VALUE; \
                         within names \\ stands before :, = and @";
    let mut parts = pieces(text, ':').into_iter().peekable();
    let first = parts.next().unwrap_or_default();
    // A light's file determines its kind.
    let of_no_material = split_plain(first, '=').is_none() && gnurt_plugins::is_script(first);
    let (material, class) =
        if of_no_material { ("", first) } else { split_plain(first, '=').ok_or(RIGHT)? };
    let (class, file) =
        split_plain(class, '@').map_or((class, None), |(class, file)| (class, Some(unescaped(file))));
    if material.is_empty() != of_no_material
        || class.is_empty()
        || file.as_ref().is_some_and(String::is_empty)
    {
        return Err(RIGHT.into());
    }
    // A document has nodes, whose names may have colons.
    let mut class = unescaped(class);
    if class.ends_with(".mtlx") {
        let is_parameter = |part: &&str| split_plain(part, '=').is_some();
        while let Some(part) = parts.next_if(|part| !is_parameter(part)) {
            class = format!("{class}:{}", unescaped(part));
        }
    }
    let pair = |part: &str| match split_plain(part, '=') {
        Some((name, value)) if !name.is_empty() && !value.is_empty() => {
            Ok((unescaped(name), unescaped(value)))
        }
        _ => Err(format!("'{part}' is not a parameter; {RIGHT}")),
    };
    let parameters = parts.map(pair).collect::<Result<_, _>>()?;
    Ok(ShaderChoice { material: unescaped(material), class, file: file.map(PathBuf::from), parameters })
}

/// `[NAME=]FILE.osl[:NAME=VALUE...]`, or else a name or a number.
pub(crate) fn camera(text: &str) -> Result<CameraChoice, String> {
    let first = pieces(text, ':')[0];
    let file = split_plain(first, '=').map_or(first, |(_, file)| file);
    if gnurt_plugins::is_script(file) {
        shader(text).map(CameraChoice::Script)
    } else {
        Ok(CameraChoice::Named(text.to_owned()))
    }
}

/// `FILE.osl[:NAME=VALUE...]`.
pub(crate) fn pixel_shader(text: &str) -> Result<ShaderChoice, String> {
    let choice = shader(text).ok().filter(|choice| choice.material.is_empty());
    choice.ok_or_else(|| {
        "give FILE.osl, and parameters as :NAME=VALUE; within names \\ stands before :, = and @".to_owned()
    })
}

/// Characters with a meaning in `--shader`, unless escaped by a backslash.
const SHADER_SIGNS: [char; 4] = [':', '=', '@', '\\'];

/// The parts before and after the first unescaped `sign`.
fn split_plain(text: &str, sign: char) -> Option<(&str, &str)> {
    let mut letters = text.char_indices().peekable();
    while let Some((at, letter)) = letters.next() {
        if letter == '\\' && letters.peek().is_some_and(|(_, next)| SHADER_SIGNS.contains(next)) {
            letters.next();
        } else if letter == sign {
            return Some((&text[..at], &text[at + sign.len_utf8()..]));
        }
    }
    None
}

/// The pieces between signs without a backslash before them.
fn pieces(mut text: &str, sign: char) -> Vec<&str> {
    let mut pieces = Vec::new();
    while let Some((piece, rest)) = split_plain(text, sign) {
        pieces.push(piece);
        text = rest;
    }
    pieces.push(text);
    pieces
}

/// The text without the backslashes that take a sign's meaning away; all others stay.
fn unescaped(text: &str) -> String {
    let mut letters = text.chars().peekable();
    let mut plain = String::new();
    while let Some(letter) = letters.next() {
        let sign = letters.next_if(|next| letter == '\\' && SHADER_SIGNS.contains(next));
        plain.push(sign.unwrap_or(letter));
    }
    plain
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shaders_of_files_with_any_name() {
        let choice = |material: &str, class: &str, file: Option<&str>, parameters: &[(&str, &str)]| {
            let pair = |(name, value): &(&str, &str)| ((*name).to_owned(), (*value).to_owned());
            let parameters = parameters.iter().map(pair).collect();
            let (material, class) = (material.to_owned(), class.to_owned());
            Ok(ShaderChoice { material, class, file: file.map(PathBuf::from), parameters })
        };
        for (text, expected) in [
            ("*=Phong", choice("*", "Phong", None, &[])),
            ("a=b@c.so:d=1,2:e=@f.png", choice("a", "b", Some("c.so"), &[("d", "1,2"), ("e", "@f.png")])),
            // Signs that have no meaning at their position need no backslash.
            ("a=b@x@y=z.so:d=e=f", choice("a", "b", Some("x@y=z.so"), &[("d", "e=f")])),
            (
                r"Glass\:001=b@2026\:01\@home.so:d=@a\:b.png",
                choice("Glass:001", "b", Some("2026:01@home.so"), &[("d", "@a:b.png")]),
            ),
            (r"x\=y=Phong", choice("x=y", "Phong", None, &[])),
            (r"a=b@C\:\dir\c.dll", choice("a", "b", Some(r"C:\dir\c.dll"), &[])),
            (r"a=b@dir\\:d=1", choice("a", "b", Some(r"dir\"), &[("d", "1")])),
        ] {
            assert_eq!(shader(text), expected, "'{text}'");
        }
        for bad in ["", "a", "=b", "a=", "a=b@", "a=b:", "a=b::c=d", "a=b:c", "a=b:=c", "a=b:c=", r"a\=b"] {
            assert!(shader(bad).is_err(), "'{bad}' is none");
        }
    }
}
