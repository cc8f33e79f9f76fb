# SPDX-License-Identifier: GPL-3.0-or-later
"""Images of Blender as textures: pixels in linear light, or as they are stored for data."""

import bpy
import numpy as np


def pixels(image, warn):
    """(array, colour space) for `gnurt.Scene.add_texture`, the upper row first; None where there are no pixels.

    The space "coded" is that of bytes in sRGB which are to be decoded after they are interpolated.
    """
    width, height = image.size
    channels = image.channels
    if width == 0 or height == 0 or not image.has_data and len(image.pixels) == 0:
        warn(f"image '{image.name}': has no pixels")
        return None
    values = np.empty(width * height * channels, np.float32)
    image.pixels.foreach_get(values)
    values = values.reshape(height, width, channels)[::-1]
    if image.is_float:
        # Blender keeps these in linear light.
        return np.ascontiguousarray(values), "linear"
    if is_coded(image, warn):
        # Cycles interpolates the stored values and decodes the result: the shader does so, too.
        return np.round(values * 255).astype(np.uint8), "coded"
    return np.ascontiguousarray(values), "linear"


def movie_pixels(image, number, warn):
    """The same of one picture of a movie, from 1 on.

    Blender's call for the pixels of an image has no number of a picture: it returns the one that was read last. A texture reads
    the picture of its own user when it is evaluated.
    """
    movie = image.original
    try:
        texture = bpy.data.textures.new("frame", "IMAGE")
    except (AttributeError, RuntimeError):
        # Blender may forbid new data at this moment.
        warn(f"image '{image.name}': its movie shows one picture")
        return pixels(movie, warn)
    try:
        texture.image = movie
        user = texture.image_user
        user.use_auto_refresh = False
        user.frame_current = number
        texture.evaluate((0, 0, 0))
        return pixels(movie, warn)
    finally:
        bpy.data.textures.remove(texture)


def is_coded(image, warn):
    """Whether the stored bytes are in sRGB."""
    space = image.colorspace_settings.name
    if space in {"sRGB", "Filmic sRGB", "AgX Base sRGB"}:
        if space != "sRGB":
            warn(f"image '{image.name}': colour space '{space}' is read as sRGB")
        return True
    if not (space.startswith("Non-Color") or space.startswith("Linear Rec.709") or space in {"Raw", "Linear"}):
        warn(f"image '{image.name}': colour space '{space}' is read as linear")
    return False
