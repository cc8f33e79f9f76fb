// SPDX-License-Identifier: GPL-3.0-or-later
// Ways of blending two colours, as Blender's manual names them: a below, b above, t of b.
// needs: hsv
color b_darken(float t, color a, color b) { return mix(a, min(a, b), t); }
color b_multiply(float t, color a, color b) { return mix(a, a * b, t); }
float b_burn1(float t, float a, float b)
{
    float x = 1.0 - t + t * b;
    if (x <= 0.0)
        return 0.0;
    return clamp(1.0 - (1.0 - a) / x, 0.0, 1.0);
}
color b_burn(float t, color a, color b) { return color(b_burn1(t, a[0], b[0]), b_burn1(t, a[1], b[1]), b_burn1(t, a[2], b[2])); }
color b_lighten(float t, color a, color b) { return mix(a, max(a, b), t); }
color b_screen(float t, color a, color b) { return color(1) - (color(1 - t) + t * (color(1) - b)) * (color(1) - a); }
float b_dodge1(float t, float a, float b)
{
    if (a == 0.0)
        return 0.0;
    float x = 1.0 - t * b;
    return (x <= 0.0) ? 1.0 : min(a / x, 1.0);
}
color b_dodge(float t, color a, color b) { return color(b_dodge1(t, a[0], b[0]), b_dodge1(t, a[1], b[1]), b_dodge1(t, a[2], b[2])); }
color b_add(float t, color a, color b) { return a + t * b; }
float b_overlay1(float t, float a, float b)
{
    return (a < 0.5) ? a * (1.0 - t + 2.0 * t * b) : 1.0 - (1.0 - t + 2.0 * t * (1.0 - b)) * (1.0 - a);
}
color b_overlay(float t, color a, color b) { return color(b_overlay1(t, a[0], b[0]), b_overlay1(t, a[1], b[1]), b_overlay1(t, a[2], b[2])); }
color b_soft_light(float t, color a, color b)
{
    color screened = color(1) - (color(1) - b) * (color(1) - a);
    return (1.0 - t) * a + t * ((color(1) - a) * b * a + a * screened);
}
color b_linear_light(float t, color a, color b) { return a + t * (2.0 * b - color(1)); }
color b_difference(float t, color a, color b) { return mix(a, fabs(a - b), t); }
color b_exclusion(float t, color a, color b) { return max(mix(a, a + b - 2.0 * a * b, t), color(0)); }
color b_subtract(float t, color a, color b) { return a - t * b; }
float b_divide1(float t, float a, float b) { return (b != 0.0) ? (1.0 - t) * a + t * a / b : a; }
color b_divide(float t, color a, color b) { return color(b_divide1(t, a[0], b[0]), b_divide1(t, a[1], b[1]), b_divide1(t, a[2], b[2])); }
color b_hue(float t, color a, color b)
{
    color x = b_hsv_of_rgb(b);
    if (x[1] == 0.0)
        return a;
    color y = b_hsv_of_rgb(a);
    return mix(a, b_rgb_of_hsv(color(x[0], y[1], y[2])), t);
}
color b_saturation(float t, color a, color b)
{
    color y = b_hsv_of_rgb(a);
    if (y[1] == 0.0)
        return a;
    color x = b_hsv_of_rgb(b);
    return b_rgb_of_hsv(color(y[0], mix(y[1], x[1], t), y[2]));
}
color b_value(float t, color a, color b)
{
    color y = b_hsv_of_rgb(a), x = b_hsv_of_rgb(b);
    return b_rgb_of_hsv(color(y[0], y[1], mix(y[2], x[2], t)));
}
color b_color(float t, color a, color b)
{
    color x = b_hsv_of_rgb(b);
    if (x[1] == 0.0)
        return a;
    color y = b_hsv_of_rgb(a);
    return mix(a, b_rgb_of_hsv(color(x[0], x[1], y[2])), t);
}
