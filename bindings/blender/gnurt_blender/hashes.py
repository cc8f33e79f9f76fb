# SPDX-License-Identifier: GPL-3.0-or-later
"""The random number of an object by its name, as pictures of Cycles show it: Jenkins' last mix of a hash by powers of 37.

Source: Bob Jenkins, lookup3 (2006), which is in the public domain. Tests: the node "object info" of `tests/nodes.py`.
"""

MASK = 0xFFFFFFFF
START = (0xDEADBEEF + (2 << 2) + 13) & MASK


def of_name(name):
    """32 bits for a name."""
    made = 0
    for byte in name.encode():
        made = (made * 37 + byte) & MASK
    return mixed((START + made) & MASK, START, START)


def of_number(number):
    """A number from 0 to 1 for a number."""
    return mixed((START + number) & MASK, START, START) / MASK


def murmur(data):
    """MurmurHash3_32 with seed 0 (Austin Appleby, public domain): the ids of Cryptomatte."""
    made = 0
    for start in range(0, len(data), 4):
        part = data[start : start + 4]
        k = int.from_bytes(part, "little") * 0xCC9E2D51 & MASK
        k = (k << 15 | k >> 17) * 0x1B873593 & MASK
        made ^= k
        if len(part) == 4:
            made = ((made << 13 | made >> 19) * 5 + 0xE6546B64) & MASK
    made ^= len(data)
    for shift, factor in ((16, 0x85EBCA6B), (13, 0xC2B2AE35), (16, 1)):
        made = (made ^ made >> shift) * factor & MASK
    return made


def mixed(a, b, c):
    """The last mix of lookup3."""

    def turned(x, bits):
        return (x << bits | x >> (32 - bits)) & MASK

    for bits in ((14, 11, 25), (16, 4, 14)):
        c = ((c ^ b) - turned(b, bits[0])) & MASK
        a = ((a ^ c) - turned(c, bits[1])) & MASK
        b = ((b ^ a) - turned(a, bits[2])) & MASK
    return ((c ^ b) - turned(b, 24)) & MASK
