// SPDX-License-Identifier: GPL-3.0-or-later
// Distances to the three edges of a triangle: 1 near one of them.
float b_wire(vector bars, float size)
{
    float nearest = min(bars[0], min(bars[1], bars[2]));
    return (nearest < 0.5 * size) ? 1.0 : 0.0;
}
