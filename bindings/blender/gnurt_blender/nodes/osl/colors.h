// SPDX-License-Identifier: GPL-3.0-or-later
// Changes of colours.
// needs: hsv
color b_hue_saturation(color c, float hue, float saturation, float value, float factor)
{
    color x = b_hsv_of_rgb(c);
    float h = x[0] + hue + 0.5;
    color y = b_rgb_of_hsv(color(h - floor(h), clamp(x[1] * saturation, 0.0, 1.0), x[2] * value));
    return max(mix(c, y, factor), color(0));
}
color b_bright_contrast(color c, float bright, float contrast)
{
    return max((1.0 + contrast) * c + color(bright - 0.5 * contrast), color(0));
}
float b_gamma1(float x, float g) { return (x > 0.0) ? pow(x, g) : x; }
color b_gamma(color c, float g) { return color(b_gamma1(c[0], g), b_gamma1(c[1], g), b_gamma1(c[2], g)); }
