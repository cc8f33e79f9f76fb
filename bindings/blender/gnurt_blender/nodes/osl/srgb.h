// SPDX-License-Identifier: GPL-3.0-or-later
// From the values of sRGB to linear light.
float b_decoded1(float x) { return (x <= 0.04045) ? max(x, 0.0) / 12.92 : pow((x + 0.055) / 1.055, 2.4); }
color b_decoded(color c) { return color(b_decoded1(c[0]), b_decoded1(c[1]), b_decoded1(c[2])); }
