// SPDX-License-Identifier: GPL-3.0-or-later
//! Functions of one number, and those whose arguments the language itself cannot describe. All others are in
//! `include/stdosl.h`.
//! Source: the OSL specification, chapter 7; the arguments are OSL's.

use super::signature::Signature;
use crate::opcode::Opcode;

/// Marks behind the codes: `p` has a format string, `t` takes texture options.
const TABLE: &[(&str, &[&str], &str)] = &[
    ("area", &["fp"], ""),
    ("arraylength", &["i?[]"], ""),
    ("bump", &["xf", "xsf", "xv"], ""),
    ("calculatenormal", &["vp"], ""),
    ("cellnoise", NOISE, ""),
    ("concat", &["sss"], ""),
    ("dict_find", &["iss", "iis"], ""),
    ("dict_next", &["ii"], ""),
    ("dict_value", &["iis?"], ""),
    ("Dx", DERIVATIVE, ""),
    ("Dy", DERIVATIVE, ""),
    ("Dz", DERIVATIVE, ""),
    ("displace", &["xf", "xsf", "xv"], ""),
    ("environment", &["fsv.", "fsvvv.", "csv.", "csvvv.", "vsv.", "vsvvv."], "t"),
    ("error", &["xs*"], "p"),
    ("exit", &["x"], ""),
    ("filterwidth", &["ff", "vp", "vv"], ""),
    ("format", &["ss*"], "p"),
    ("fprintf", &["xss*"], "p"),
    ("getattribute", &["is?", "is?[]", "iss?", "iss?[]", "isi?", "isi?[]", "issi?", "issi?[]"], ""),
    ("getmessage", &["is?", "is?[]", "iss?", "iss?[]"], ""),
    ("gettextureinfo", &["iss?", "iss?[]", "isffs?", "isffs?[]"], ""),
    ("hashnoise", NOISE, ""),
    ("illuminate", &["iipvcff.", "iipvfvcff."], ""),
    ("isconnected", &["i?"], ""),
    ("isconstant", &["i?"], ""),
    ("lightcount", &["i"], ""),
    ("noise", NAMED_NOISE, ""),
    ("pnoise", NAMED_PNOISE, ""),
    ("pointcloud_search", &["ispfi.", "ispfii."], ""),
    ("pointcloud_get", &["isi[]is?[]"], ""),
    ("pointcloud_write", &["isp."], ""),
    ("printf", &["xs*"], "p"),
    ("psnoise", PNOISE, ""),
    ("random", &["f", "c", "p", "v", "n"], ""),
    ("regex_match", &["iss", "isi[]s"], ""),
    ("regex_search", &["iss", "isi[]s"], ""),
    ("setmessage", &["xs?", "xs?[]"], ""),
    ("sincos", &["xfff", "xccc", "xppp", "xvvv", "xnnn"], ""),
    ("snoise", NOISE, ""),
    (
        "spline",
        &[
            "fsff[]", "csfc[]", "psfp[]", "vsfv[]", "nsfn[]", "fsfif[]", "csfic[]", "psfip[]", "vsfiv[]",
            "nsfin[]",
        ],
        "",
    ),
    ("splineinverse", &["fsff[]", "fsfif[]"], ""),
    ("split", &["iss[]si", "iss[]s", "iss[]"], ""),
    ("surfacearea", &["f"], ""),
    ("texture", &["fsff.", "fsffffff.", "csff.", "csffffff.", "vsff.", "vsffffff."], "t"),
    ("texture3d", &["fsp.", "fspvvv.", "csp.", "cspvvv.", "vsp.", "vspvvv."], "t"),
    ("trace", &["ipv.", "cpv."], ""),
    ("warning", &["xs*"], "p"),
];

const DERIVATIVE: &[&str] = &["ff", "vp", "vv", "vn", "cc"];
const NOISE: &[&str] = &["ff", "fff", "fp", "fpf", "cf", "cff", "cp", "cpf", "vf", "vff", "vp", "vpf"];
const PNOISE: &[&str] =
    &["fff", "fffff", "fpp", "fpfpf", "cff", "cffff", "cpp", "cpfpf", "vff", "vffff", "vpp", "vpfpf"];
const NAMED_NOISE: &[&str] = &[
    "fsf.", "fsff.", "fsp.", "fspf.", "csf.", "csff.", "csp.", "cspf.", "vsf.", "vsff.", "vsp.", "vspf.",
    "ff", "fff", "fp", "fpf", "cf", "cff", "cp", "cpf", "vf", "vff", "vp", "vpf",
];
const NAMED_PNOISE: &[&str] = &[
    "fsff.", "fsffff.", "fspp.", "fspfpf.", "csff.", "csffff.", "cspp.", "cspfpf.", "vsff.", "vsffff.",
    "vspp.", "vspfpf.", "fff", "fffff", "fpp", "fpfpf", "cff", "cffff", "cpp", "cpfpf", "vff", "vffff",
    "vpp", "vpfpf",
];

/// Extensions to OSL.
fn is_more(name: &str, code: &str) -> bool {
    matches!((name, code), ("illuminate" | "lightcount", _) | ("trace", "cpv."))
}

/// All of them, or all that OSL has if `strict`; of each name the first is tried first.
pub(super) fn signatures(strict: bool) -> impl Iterator<Item = Signature> {
    let each = Opcode::of_every_number()
        .flat_map(|name| ["ff", "cc", "pp", "vv", "nn"].map(|code| Signature::from_codes(name, code)));
    let rest = TABLE.iter().flat_map(move |(name, codes, marks)| {
        let codes = codes.iter().filter(move |code| !strict || !is_more(name, code));
        codes.map(move |code| Signature {
            printf: marks.contains('p'),
            texture: marks.contains('t'),
            ..Signature::from_codes(name, code)
        })
    });
    each.chain(rest)
}
