// SPDX-License-Identifier: GPL-3.0-or-later
// Fibres after Chiang et al. (A Practical and Controllable Hair and Fur Model for Production Path Tracing, 2016).
// Absorption of a fibre of radius 1 under which hair of this colour is seen (equation 9).
color b_hair_of_color(color seen, float around)
{
    float b = around;
    float width = 5.969 + b * (-0.215 + b * (2.532 + b * (-10.73 + b * (5.574 + b * 0.245))));
    color s = log(max(seen, color(1e-5))) / width;
    return s * s;
}
// Absorption by brown and by red melanin.
color b_hair_of_melanin(float melanin, float redness)
{
    float amount = -log(max(1.0 - melanin, 1e-4));
    float red = clamp(redness, 0.0, 1.0);
    return max(amount, 0.0) * ((1.0 - red) * color(0.506, 0.841, 1.653) + red * color(0.343, 0.733, 1.924));
}
// Variance along a fibre (equation 7).
float b_hair_along(float roughness)
{
    float b = clamp(roughness, 0.001, 1.0);
    float root = 0.726 * b + 0.812 * b * b + 3.7 * pow(b, 20.0);
    return root * root;
}
// Scale around it (equation 8).
float b_hair_around(float roughness)
{
    float b = clamp(roughness, 0.001, 1.0);
    return 0.265 * b + 1.194 * b * b + 5.372 * pow(b, 22.0);
}
// A quantity varied from strand to strand by up to this share.
float b_hair_varied(float value, float share, float random)
{
    return value * (1.0 + 2.0 * (random - 0.5) * share);
}
// Cycles' pictures show scales that a positive offset tilts to the root.
closure color b_hair(vector n, vector along, color absorption, float roughness, float around, float coat, float ior, float tilt)
{
    float first = b_hair_along(roughness * (1.0 - clamp(coat, 0.0, 1.0)));
    float v = b_hair_along(roughness), s = b_hair_around(around);
    return chiang_hair_bsdf(n, along, color(1), color(1), color(1), max(ior, 1.0), first, 0.25 * v, 4.0 * v, s, s, s, -tilt, absorption);
}
