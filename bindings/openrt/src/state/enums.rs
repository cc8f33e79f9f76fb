// SPDX-License-Identifier: GPL-3.0-or-later
//! The constants of `openrt/types.h` as types, so that the rest of the library matches on names.
//! Values as openrt/types.h has them. Tests: `tests::codes_come_back`; tests/c/scene.c.

use super::error::{Error, Result};

macro_rules! codes {
    ($($(#[$doc:meta])* $name:ident { $($variant:ident = $code:literal),* $(,)? })*) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[repr(u32)]
        pub(crate) enum $name { $($variant = $code),* }

        impl $name {
            /// All of them.
            #[cfg(test)]
            #[allow(dead_code, reason = "tests take some groups")]
            pub(crate) const ALL: &[Self] = &[$(Self::$variant),*];

            /// The constant of this value; [`Error::InvalidEnum`] if it is none of this group.
            pub(crate) fn from_code(code: u32) -> Result<Self> {
                match code {
                    $($code => Ok(Self::$variant),)*
                    _ => Err(Error::InvalidEnum),
                }
            }

            /// Its value in C.
            #[allow(dead_code, reason = "some are only compared")]
            pub(crate) fn code(self) -> u32 {
                self as u32
            }
        }
    )*};
}

codes! {
    /// The primitives of a block's vertices.
    Primitive {
        Triangles = 0x100,
        TriangleStrip = 0x101,
        TriangleFan = 0x102,
        Quads = 0x103,
        QuadStrip = 0x104,
        Polygon = 0x105,
    }
    /// How an object is opened.
    ObjectMode { Define = 0x200, DefineAndInstantiate = 0x201, Update = 0x202 }
    /// The layout of pixels in the frame buffer.
    FrameFormat {
        Bgr32 = 0x300,
        Rgb32 = 0x301,
        Rgba32 = 0x302,
        Bgra32 = 0x303,
        Rgb8 = 0x310,
        Rgba8 = 0x311,
        Bgr8 = 0x312,
        Bgra8 = 0x313,
    }
    /// Whether a frame's start clears its lists.
    SceneMode { Retained = 0x600, Immediate = 0x601 }
    /// A matrix stack.
    MatrixMode { Modelview = 0x1700, Projection = 0x1701, Texture = 0x1702 }
    /// A texture target.
    TextureTarget { Texture2d = 0x0DE1 }
    /// The channels of texels in memory.
    TexelFormat { Rgb = 0x1907, Rgba = 0x1908, Luminance = 0x1909, Bgr = 0x80E0, Bgra = 0x80E1 }
    /// The type of a channel in memory.
    TexelType {
        Byte = 0x1400,
        UnsignedByte = 0x1401,
        Short = 0x1402,
        UnsignedShort = 0x1403,
        Int = 0x1404,
        UnsignedInt = 0x1405,
        Float = 0x1406,
    }
    /// A parameter of a texture.
    TextureParameter { MagFilter = 0x2800, MinFilter = 0x2801, WrapS = 0x2802, WrapT = 0x2803 }
    /// How points between texel centres are read.
    TextureFilter { Nearest = 0x2600, Linear = 0x2601 }
    /// How points that cover more than a texel are read.
    MinifyFilter {
        Nearest = 0x2600,
        Linear = 0x2601,
        NearestMipmapNearest = 0x2700,
        LinearMipmapNearest = 0x2701,
        NearestMipmapLinear = 0x2702,
        LinearMipmapLinear = 0x2703,
    }
    /// Wrapping outside of a texture.
    TextureWrap { Clamp = 0x2900, Repeat = 0x2901, ClampToEdge = 0x812F, MirroredRepeat = 0x8370 }
    /// Strings that programs can query.
    StringName { Vendor = 0x1F00, Renderer = 0x1F01, Version = 0x1F02, Extensions = 0x1F03 }
    /// Numbers that programs can query.
    StateName {
        ObjectCount = 0x0700,
        TriangleCount = 0x0701,
        InstanceCount = 0x0702,
        SampleCount = 0x0703,
        CurrentColor = 0x0B00,
        CurrentNormal = 0x0B02,
        CurrentTextureCoords = 0x0B03,
        MatrixMode = 0x0BA0,
        ModelviewMatrix = 0x0BA6,
        ProjectionMatrix = 0x0BA7,
        TextureMatrix = 0x0BA8,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_come_back() {
        for &primitive in Primitive::ALL {
            assert_eq!(Primitive::from_code(primitive.code()), Ok(primitive), "{primitive:?}");
        }
        assert_eq!(FrameFormat::from_code(0x304), Err(Error::InvalidEnum), "between two formats");
        assert_eq!(ObjectMode::from_code(0x100), Err(Error::InvalidEnum), "of another group");
    }
}
