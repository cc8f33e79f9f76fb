// SPDX-License-Identifier: GPL-3.0-or-later
//! Identifiers of the shading language for names of documents.

/// Words of the language, and its functions and variables that generated texts use.
const TAKEN: &str = " and break closure color continue do else emit float for if illuminance illuminate int matrix normal \
     not or output point public return string struct vector void while shader surface displacement volume light \
     generic camera environment pixel bool case catch char class const delete default double enum extern friend goto inline long \
     new operator private protected short signed sizeof static switch template this throw try typedef uniform \
     union unsigned varying virtual abs floor ceil round sign sqrt pow exp log sin cos tan asin acos atan2 \
     min max clamp mix mod smoothstep dot cross normalize radians transform transformc determinant transpose \
     snoise cellnoise texture getattribute backfacing Dx Dy filterwidth blackbody luminance transparent layer result \
     oren_nayar_diffuse_bsdf burley_diffuse_bsdf dielectric_bsdf conductor_bsdf generalized_schlick_bsdf \
     translucent_bsdf subsurface_bssrdf sheen_bsdf chiang_hair_bsdf uniform_edf anisotropic_vdf \
     P I N Ng u v dPdu dPdv time Ci true false ";

/// The identifier of a name.
pub(crate) fn identifier(name: &str) -> String {
    let mut out: String =
        name.chars().take(200).map(|c| if c.is_ascii_alphanumeric() || c == '_' { c } else { '_' }).collect();
    // Those of variables begin with an underscore.
    if !out.starts_with(|c: char| c.is_ascii_alphabetic()) {
        out.insert(0, 'p');
    }
    if TAKEN.split(' ').any(|word| *word == *out) {
        out.push('_');
    }
    out
}
