// SPDX-License-Identifier: GPL-3.0-or-later
// Hue, saturation and value or lightness, each from 0 to 1.
color b_hsv_of_rgb(color c)
{
    float high = max(c[0], max(c[1], c[2])), low = min(c[0], min(c[1], c[2])), d = high - low;
    float h = 0.0, s = (high != 0.0) ? d / high : 0.0;
    if (s == 0.0)
        return color(0, s, high);
    if (c[0] == high) h = (c[1] - c[2]) / d;
    else if (c[1] == high) h = 2.0 + (c[2] - c[0]) / d;
    else h = 4.0 + (c[0] - c[1]) / d;
    h /= 6.0;
    return color((h < 0.0) ? h + 1.0 : h, s, high);
}
color b_hue(float h)
{
    return clamp(color(fabs(h * 6.0 - 3.0) - 1.0, 2.0 - fabs(h * 6.0 - 2.0), 2.0 - fabs(h * 6.0 - 4.0)), color(0), color(1));
}
color b_rgb_of_hsv(color c)
{
    return ((b_hue(c[0] - floor(c[0])) - color(1)) * c[1] + color(1)) * c[2];
}
color b_hsl_of_rgb(color c)
{
    float high = max(c[0], max(c[1], c[2])), low = min(c[0], min(c[1], c[2])), d = high - low;
    float l = min(0.5 * (high + low), 1.0), h = 0.0, s = 0.0;
    if (d > 0.0) {
        s = (l > 0.5) ? d / (2.0 - high - low) : d / (high + low);
        if (c[0] == high) h = (c[1] - c[2]) / d + ((c[1] < c[2]) ? 6.0 : 0.0);
        else if (c[1] == high) h = (c[2] - c[0]) / d + 2.0;
        else h = (c[0] - c[1]) / d + 4.0;
    }
    return color(h / 6.0, s, l);
}
color b_rgb_of_hsl(color c)
{
    float chroma = (1.0 - fabs(2.0 * c[2] - 1.0)) * c[1];
    return (b_hue(c[0]) - color(0.5)) * chroma + color(c[2]);
}
