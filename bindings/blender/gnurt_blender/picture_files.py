# SPDX-License-Identifier: GPL-3.0-or-later
"""Files of images that are more than one picture: a tile for each unit square of the coordinates, and the frames of a sequence."""

import os
import re
import tempfile

import bpy

# Where tiles are in names of files: their number, or their place from 1 on.
TILE = re.compile(r"<UDIM>|<UVTILE>")


def frame_number(user, frame):
    """The number of the picture that an image user shows at a frame of the scene."""
    number, count = frame - user.frame_start + 1, max(user.frame_duration, 1)
    number = (number - 1) % count + 1 if user.use_cyclic else min(max(number, 1), count)
    return number + user.frame_offset


def of_frame(path, number):
    """The file of a sequence with this number: the last digits of the name are replaced."""
    folder, name = os.path.split(path)
    found = list(re.finditer(r"\d+", os.path.splitext(name)[0]))
    if not found:
        return path
    last = found[-1]
    return os.path.join(folder, f"{name[: last.start()]}{max(number, 0):0{last.end() - last.start()}d}{name[last.end() :]}")


def of_tile(path, number):
    """The file of a tile, from 1001 on."""
    across, up = (number - 1001) % 10, (number - 1001) // 10
    return TILE.sub(lambda found: str(number) if found.group() == "<UDIM>" else f"u{across + 1}_v{up + 1}", path)


def absolute(image):
    return bpy.path.abspath(image.filepath, library=image.library)


class Unpacked:
    """A file with the contents of one that is packed into the scene."""

    def __init__(self, packed):
        self.packed = packed

    def __enter__(self):
        with tempfile.NamedTemporaryFile(suffix=os.path.splitext(self.packed.filepath)[1] or ".png", delete=False) as file:
            file.write(self.packed.packed_file.data)
        self.path = file.name
        return self.path

    def __exit__(self, *_):
        os.unlink(self.path)


def tiles(image):
    """The numbers of the tiles of an image and where they are: a path, or a packed file."""
    packed = {each.tile_number: each for each in image.packed_files}
    return {tile.number: packed.get(tile.number) or of_tile(absolute(image), tile.number) for tile in image.tiles}
