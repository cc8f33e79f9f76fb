// SPDX-License-Identifier: GPL-3.0-or-later
//! The table of operations: names, operands, and the functions of numbers. A function of numbers is one line
//! here; the library declares it, the interpreter and machine code compute it, and passes know it as pure.
//! Source: the operations of OSL's compiler. Tests: `tests/hostile.rs`, crates/jit/tests/chance.rs.

use gnurt_sl_lib::{Number, math};
use std::collections::HashMap;
use std::sync::OnceLock;

/// What is known of an operation.
struct Row {
    name: &'static str,
    /// Result and operands of the shortest form.
    least: usize,
    marks: &'static str,
}

/// A function of numbers.
pub(crate) trait Function {
    /// How many it takes.
    const COUNT: usize;
    /// Its result.
    fn of<N: Number>(x: [N; 3]) -> N;
}

/// Something to do with the type of a function.
pub(crate) trait WithFunction {
    /// Its result.
    type Out;
    /// Does it.
    fn with<F: Function>(self) -> Self::Out;
}

macro_rules! opcodes {
    (
        |$a:ident, $b:ident, $c:ident| {
            $($map:ident $map_name:literal $count:literal $map_marks:literal $body:expr;)*
        }
        $($code:ident $name:literal $least:literal $marks:literal;)*
    ) => {
        /// An operation.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        #[expect(missing_docs, reason = "the table has the names")]
        pub enum Opcode {
            $($map,)*
            $($code,)*
        }

        const ROWS: &[Row] = &[
            $(Row { name: $map_name, least: 1 + $count, marks: $map_marks },)*
            $(Row { name: $name, least: $least, marks: $marks },)*
        ];

        const ALL: &[Opcode] = &[$(Opcode::$map,)* $(Opcode::$code,)*];

        impl Opcode {
            /// Numbers that the function of each component takes; 0 for other operations.
            #[must_use]
            pub const fn arity(self) -> usize {
                match self {
                    $(Self::$map => $count,)*
                    _ => 0,
                }
            }

            /// A function of numbers; their count is its [`arity`](Self::arity).
            pub fn apply<N: Number>(self, [$a, $b, $c]: [N; 3]) -> N {
                match self {
                    $(Self::$map => functions::$map::of([$a, $b, $c]),)*
                    _ => $a,
                }
            }

            /// Does something with the type of its function of numbers; none for other operations.
            pub(crate) fn with_function<W: WithFunction>(self, what: W) -> Option<W::Out> {
                match self {
                    $(Self::$map => Some(what.with::<functions::$map>()),)*
                    _ => None,
                }
            }
        }

        /// Each function of numbers is a type, for code that is made for one of them.
        mod functions {
            use super::{Function, flat, math};
            use gnurt_sl_lib::Number;

            $(
                pub(super) struct $map;

                impl Function for $map {
                    const COUNT: usize = $count;

                    #[inline(always)]
                    fn of<N: Number>([$a, $b, $c]: [N; 3]) -> N {
                        _ = ($b, $c);
                        $body
                    }
                }
            )*
        }
    };
}

fn flat<N: Number>(f: impl FnOnce(N::Real) -> N::Real, x: N) -> N {
    N::lift(f(x.value()))
}

// Marks: `e` is declared by the library for every type of number. `i` has another meaning for ints. `p` is pure:
// results depend on operands only, and nothing is reported. `x` is pure but for reports of a wrong index. `c` is
// computed by the evaluator of numbers. `q` depends on more than operands. `l` is about its operands, without
// their values. `o` has no result in its first operand.
opcodes! {
    |a, b, c| {
        Add "add" 2 "ip" a + b;
        Sub "sub" 2 "ip" a - b;
        Mul "mul" 2 "ip" a * b;
        Div "div" 2 "ip" math::div(a, b);
        Neg "neg" 1 "ip" -a;
        Mod "mod" 2 "ip" math::fmod(a, b);
        Fmod "fmod" 2 "ip" math::fmod(a, b);
        Min "min" 2 "ip" math::min(a, b);
        Max "max" 2 "ip" math::max(a, b);
        Abs "abs" 1 "ip" math::abs(a);
        Fabs "fabs" 1 "eip" math::abs(a);
        Sin "sin" 1 "ep" math::sin(a);
        Cos "cos" 1 "ep" math::cos(a);
        Tan "tan" 1 "ep" math::tan(a);
        Asin "asin" 1 "ep" math::asin(a);
        Acos "acos" 1 "ep" math::acos(a);
        Atan "atan" 1 "ep" math::atan(a);
        Atan2 "atan2" 2 "p" math::atan2(a, b);
        Sinh "sinh" 1 "ep" math::sinh(a);
        Cosh "cosh" 1 "ep" math::cosh(a);
        Tanh "tanh" 1 "ep" math::tanh(a);
        Exp "exp" 1 "ep" math::exp(a);
        Exp2 "exp2" 1 "ep" math::exp2(a);
        Expm1 "expm1" 1 "ep" math::expm1(a);
        Log "log" 1 "ep" math::log(a);
        Log2 "log2" 1 "ep" math::log2(a);
        Log10 "log10" 1 "ep" math::log10(a);
        Logb "logb" 1 "ep" flat(math::logb, a);
        Pow "pow" 2 "p" math::pow(a, b);
        Sqrt "sqrt" 1 "ep" math::sqrt(a);
        InverseSqrt "inversesqrt" 1 "ep" math::inversesqrt(a);
        Cbrt "cbrt" 1 "ep" math::cbrt(a);
        Erf "erf" 1 "p" math::erf(a);
        Erfc "erfc" 1 "p" math::erfc(a);
        Sign "sign" 1 "ep" flat(math::sign, a);
        Floor "floor" 1 "ep" flat(math::floor, a);
        Ceil "ceil" 1 "ep" flat(math::ceil, a);
        Round "round" 1 "ep" flat(math::round, a);
        Trunc "trunc" 1 "ep" flat(math::trunc, a);
        Step "step" 2 "p" N::lift(math::step(a.value(), b.value()));
        Mix "mix" 3 "p" math::mix(a, b, c);
        Select "select" 3 "p" math::select(a, b, c.value());
        Smoothstep "smoothstep" 3 "p" math::smoothstep(a, b, c);
        Clamp "clamp" 3 "p" math::clamp(a, b, c);
    }
    BitAnd "bitand" 3 "ip";
    BitOr "bitor" 3 "ip";
    Xor "xor" 3 "ip";
    Shl "shl" 3 "ip";
    Shr "shr" 3 "ip";
    And "and" 3 "ip";
    Or "or" 3 "ip";
    Compl "compl" 2 "ip";
    Eq "eq" 3 "cp";
    Neq "neq" 3 "cp";
    Lt "lt" 3 "cp";
    Gt "gt" 3 "cp";
    Le "le" 3 "cp";
    Ge "ge" 3 "cp";
    IsNan "isnan" 2 "cp";
    IsInf "isinf" 2 "cp";
    IsFinite "isfinite" 2 "cp";
    Assign "assign" 2 "cp";
    ArrayCopy "arraycopy" 2 "cp";
    Int "int" 2 "cp";
    Float "float" 2 "cp";
    Aref "aref" 3 "cx";
    Aassign "aassign" 3 "cx";
    Compref "compref" 3 "cx";
    Compassign "compassign" 3 "cx";
    Mxcompref "mxcompref" 4 "cx";
    Mxcompassign "mxcompassign" 4 "cx";
    ArrayLength "arraylength" 2 "cpl";
    IsConnected "isconnected" 2 "cql";
    IsConstant "isconstant" 2 "cql";
    Color "color" 2 "cp";
    Point "point" 2 "cp";
    Vector "vector" 2 "cp";
    Normal "normal" 2 "cp";
    Matrix "matrix" 2 "cp";
    Transpose "transpose" 2 "cp";
    Dot "dot" 3 "cp";
    Cross "cross" 3 "cp";
    Length "length" 2 "cp";
    Distance "distance" 3 "cp";
    Normalize "normalize" 2 "cp";
    Sincos "sincos" 3 "cpo";
    Dx "Dx" 2 "cp";
    Dy "Dy" 2 "cp";
    Dz "Dz" 2 "cp";
    Filterwidth "filterwidth" 2 "cp";
    Area "area" 2 "cp";
    Transform "transform" 1 "cq";
    TransformV "transformv" 1 "cq";
    TransformN "transformn" 1 "q";
    TransformU "transformu" 1 "q";
    Noise "noise" 2 "cp";
    Snoise "snoise" 2 "cp";
    Pnoise "pnoise" 2 "cp";
    Psnoise "psnoise" 2 "cp";
    Cellnoise "cellnoise" 2 "cp";
    Hashnoise "hashnoise" 2 "cp";
    Hash "hash" 2 "cp";
    CalculateNormal "calculatenormal" 2 "q";
    Spline "spline" 4 "p";
    SplineInverse "splineinverse" 4 "p";
    Determinant "determinant" 2 "p";
    GetMatrix "getmatrix" 0 "q";
    TransformC "transformc" 4 "p";
    Blackbody "blackbody" 2 "p";
    WavelengthColor "wavelength_color" 2 "p";
    Luminance "luminance" 2 "p";
    Random "random" 1 "q";
    Printf "printf" 1 "qo";
    Error "error" 1 "qo";
    Warning "warning" 1 "qo";
    Fprintf "fprintf" 1 "qo";
    Format "format" 1 "";
    Concat "concat" 1 "";
    Strlen "strlen" 2 "";
    Getchar "getchar" 3 "";
    Startswith "startswith" 3 "";
    Endswith "endswith" 3 "";
    Substr "substr" 3 "";
    Stoi "stoi" 2 "";
    Stof "stof" 2 "";
    Split "split" 0 "";
    RegexSearch "regex_search" 0 "";
    RegexMatch "regex_match" 0 "";
    SetMessage "setmessage" 0 "qo";
    GetMessage "getmessage" 1 "q";
    GetAttribute "getattribute" 1 "q";
    RayType "raytype" 2 "q";
    Backfacing "backfacing" 1 "q";
    SurfaceArea "surfacearea" 1 "q";
    Trace "trace" 0 "q";
    LightCount "lightcount" 1 "q";
    Illuminate "illuminate" 0 "q";
    Texture "texture" 0 "q";
    Environment "environment" 0 "q";
    Texture3d "texture3d" 0 "q";
    GetTextureInfo "gettextureinfo" 0 "q";
    DictFind "dict_find" 0 "q";
    DictNext "dict_next" 0 "q";
    DictValue "dict_value" 0 "q";
    PointcloudSearch "pointcloud_search" 0 "q";
    PointcloudGet "pointcloud_get" 0 "q";
    PointcloudWrite "pointcloud_write" 0 "q";
    Closure "closure" 1 "";
    Bump "bump" 0 "co";
    Displace "displace" 0 "co";
    Nop "nop" 0 "co";
    End "end" 0 "co";
    UseParam "useparam" 0 "co";
    Break "break" 0 "qo";
    Continue "continue" 0 "qo";
    Return "return" 0 "qo";
    Exit "exit" 0 "qo";
    If "if" 0 "qo";
    For "for" 0 "qo";
    While "while" 0 "qo";
    DoWhile "dowhile" 0 "qo";
    FunctionCall "functioncall" 0 "qo";
    FunctionCallNr "functioncall_nr" 0 "qo";
    Unknown "" 0 "q";
}

impl Opcode {
    const fn row(self) -> &'static Row {
        &ROWS[self as usize]
    }

    const fn has(self, mark: u8) -> bool {
        let marks = self.row().marks.as_bytes();
        let mut i = 0;
        while i < marks.len() {
            if marks[i] == mark {
                return true;
            }
            i += 1;
        }
        false
    }

    /// Its name in the text form.
    #[must_use]
    pub const fn name(self) -> &'static str {
        self.row().name
    }

    /// The operation of a name; [`Unknown`](Self::Unknown) if there is none.
    #[must_use]
    pub fn named(name: &str) -> Self {
        static BY_NAME: OnceLock<HashMap<&str, Opcode>> = OnceLock::new();
        let all = BY_NAME.get_or_init(|| ALL.iter().map(|&code| (code.name(), code)).collect());
        all.get(name).copied().unwrap_or(Self::Unknown)
    }

    /// Result and operands of the shortest form.
    #[must_use]
    pub const fn least_operands(self) -> usize {
        self.row().least
    }

    /// Whether it makes its results of its operands and does nothing else. Named spaces and operands that are
    /// spaces are the renderer's.
    #[must_use]
    pub const fn is_pure(self) -> bool {
        self.has(b'p')
    }

    /// Whether it takes an index, and reports one that is out of range; otherwise it is pure.
    #[must_use]
    pub const fn is_indexed(self) -> bool {
        self.has(b'x')
    }

    /// Whether it depends on more than its operands.
    #[must_use]
    pub const fn asks(self) -> bool {
        self.has(b'q')
    }

    /// Whether the evaluator computes it, for numbers.
    #[must_use]
    pub const fn is_computed(self) -> bool {
        self.arity() > 0 || self.has(b'c') || self.has(b'i')
    }

    /// Whether it has a meaning of its own for ints.
    #[must_use]
    pub const fn is_for_ints(self) -> bool {
        self.has(b'i')
    }

    /// Whether it is about operands, whose values are not needed.
    #[must_use]
    pub const fn is_about_operands(self) -> bool {
        self.has(b'l')
    }

    /// Operands that every use of it writes, by bits.
    #[must_use]
    pub const fn results(self) -> u64 {
        match self {
            Self::Sincos => 6,
            _ if self.has(b'o') => 0,
            _ => 1,
        }
    }

    /// Whether it is noise.
    #[must_use]
    pub const fn is_noise(self) -> bool {
        let is_periodic = matches!(self, Self::Pnoise | Self::Psnoise);
        is_periodic || matches!(self, Self::Noise | Self::Snoise | Self::Cellnoise | Self::Hashnoise)
    }

    /// Whether it does nothing while a point is shaded.
    #[must_use]
    pub const fn is_nothing(self) -> bool {
        matches!(self, Self::Bump | Self::Displace | Self::Nop | Self::End | Self::UseParam)
    }

    /// Functions that the library declares for every type of number.
    pub(crate) fn of_every_number() -> impl Iterator<Item = &'static str> {
        ALL.iter().filter(|code| code.has(b'e')).map(|code| code.name())
    }
}
