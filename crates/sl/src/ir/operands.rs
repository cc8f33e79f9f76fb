// SPDX-License-Identifier: GPL-3.0-or-later
//! Least numbers of operands of operations: compiled shaders come from outside, and code after the check may
//! rely on these.
//! Source: the operations of OSL's compiler. Tests: `tests/hostile.rs::operations_may_lack_operands`.

/// Result and arguments of the shortest form; 0 for unknown names, and for operations that check by
/// themselves.
pub(super) fn least_operands(name: &str) -> usize {
    match name {
        "mxcompref" | "mxcompassign" | "mix" | "select" | "smoothstep" | "clamp" | "transformc"
        | "spline" | "splineinverse" => 4,
        "add" | "sub" | "mul" | "div" | "mod" | "fmod" | "min" | "max" | "pow" | "atan2" | "step" | "eq"
        | "neq" | "lt" | "gt" | "le" | "ge" | "and" | "or" | "bitand" | "bitor" | "xor" | "shl" | "shr"
        | "aref" | "aassign" | "compref" | "compassign" | "dot" | "cross" | "distance" | "sincos"
        | "getchar" | "startswith" | "endswith" | "substr" => 3,
        "neg" | "compl" | "sin" | "cos" | "tan" | "asin" | "acos" | "atan" | "sinh" | "cosh" | "tanh"
        | "exp" | "exp2" | "expm1" | "log" | "log2" | "log10" | "logb" | "sqrt" | "inversesqrt" | "cbrt"
        | "erf" | "erfc" | "abs" | "fabs" | "sign" | "floor" | "ceil" | "round" | "trunc" | "isnan"
        | "isinf" | "isfinite" | "assign" | "arraycopy" | "arraylength" | "int" | "float" | "color"
        | "point" | "vector" | "normal" | "matrix" | "blackbody" | "wavelength_color" | "luminance"
        | "determinant" | "transpose" | "length" | "normalize" | "Dx" | "Dy" | "Dz" | "filterwidth"
        | "area" | "calculatenormal" | "noise" | "snoise" | "pnoise" | "psnoise" | "cellnoise"
        | "hashnoise" | "hash" | "strlen" | "stoi" | "stof" | "raytype" | "isconnected" | "isconstant" => 2,
        "transform" | "transformv" | "transformn" | "transformu" | "getmessage" | "getattribute"
        | "backfacing" | "surfacearea" | "lightcount" | "random" | "concat" | "format" | "printf"
        | "error" | "warning" | "fprintf" | "closure" => 1,
        _ => 0,
    }
}
