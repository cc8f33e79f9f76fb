# SPDX-License-Identifier: GPL-3.0-or-later
"""Joins pictures into one animated PNG that plays in a loop: loop.py OUT.png SECONDS-PER-FRAME FRAME.png...

Frames are 8-bit PNG files of one size, as gnurt writes them. All share a palette of 255 colours, by median cut; what stays as it
was in the frame before is left out. Source: PNG, third edition (acTL, fcTL, fdAT); Heckbert 1982 for the palette.
"""
import struct
import sys
import zlib
from fractions import Fraction


def read(path):
    data = open(path, "rb").read()
    at, packed = 8, b""
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at : at + 8])
        body = data[at + 8 : at + 8 + length]
        at += 12 + length
        if kind == b"IHDR":
            width, height, depth, color = struct.unpack(">IIBB", body[:10])
        elif kind == b"IDAT":
            packed += body
    assert depth == 8 and color in (2, 6), f"{path}: 8-bit RGB or RGBA is needed"
    n = 3 if color == 2 else 4
    raw, stride, before, rows = zlib.decompress(packed), width * n, bytes(width * n), []
    for y in range(height):
        start = y * (stride + 1)
        how, row = raw[start], bytearray(raw[start + 1 : start + 1 + stride])
        for x in range(stride):
            left = row[x - n] if x >= n else 0
            up, corner = before[x], before[x - n] if x >= n else 0
            if how == 1:
                add = left
            elif how == 2:
                add = up
            elif how == 3:
                add = (left + up) // 2
            elif how == 4:
                p = left + up - corner
                a, b, c = abs(p - left), abs(p - up), abs(p - corner)
                add = left if a <= b and a <= c else up if b <= c else corner
            else:
                add = 0
            row[x] = (row[x] + add) & 255
        rows.append(bytes(row))
        before = row
    pixels = [tuple(row[i : i + 3]) for row in rows for i in range(0, stride, n)]
    return width, height, pixels


def palette_of(pixels, count):
    boxes = [pixels]
    while len(boxes) < count:
        def spread(box):
            return max((max(p[k] for p in box) - min(p[k] for p in box), k) for k in range(3))
        scored = [(spread(box)[0] * len(box) ** 0.5, i) for i, box in enumerate(boxes) if len(box) > 1]
        if not scored:
            break
        box = boxes.pop(max(scored)[1])
        box.sort(key=lambda p, k=spread(box)[1]: p[k])
        boxes += [box[: len(box) // 2], box[len(box) // 2 :]]
    return [tuple(sum(p[k] for p in box) // len(box) for k in range(3)) for box in boxes]


def main():
    out, seconds, frames = sys.argv[1], Fraction(sys.argv[2]).limit_denominator(1000), [read(p) for p in sys.argv[3:]]
    width, height, _ = frames[0]
    some = [p for _, _, pixels in frames for p in pixels[:: max(1, len(frames) * width * height // 12000)]]
    colors = palette_of(some, 255)
    known = {}

    def nearest(p):
        p = tuple(x & 0xF8 | 4 for x in p)
        if p not in known:
            known[p] = min(range(len(colors)), key=lambda i: sum((a - b) ** 2 for a, b in zip(p, colors[i])))
        return known[p]

    def chunk(kind, body):
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))

    nothing, number, before = len(colors), 0, None
    file = b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 3, 0, 0, 0))
    file += chunk(b"acTL", struct.pack(">II", len(frames), 0))
    file += chunk(b"PLTE", bytes(x for color in colors + [(0, 0, 0)] for x in color))
    file += chunk(b"tRNS", bytes([255] * len(colors) + [0]))
    for _, _, pixels in frames:
        now = [nearest(p) for p in pixels]
        shown = now if before is None else [nothing if a == b else a for a, b in zip(now, before)]
        control = (number, width, height, 0, 0, seconds.numerator, seconds.denominator, 0, int(before is not None))
        file += chunk(b"fcTL", struct.pack(">IIIIIHHBB", *control))
        number += 1
        rows = b"".join(b"\0" + bytes(shown[y * width : (y + 1) * width]) for y in range(height))
        packed = zlib.compress(rows, 9)
        if before is None:
            file += chunk(b"IDAT", packed)
        else:
            file += chunk(b"fdAT", struct.pack(">I", number) + packed)
            number += 1
        before = now
    open(out, "wb").write(file + chunk(b"IEND", b""))


main()
