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
// Fibres after Huang et al. (A Microfacet-based Hair Scattering Model, 2022), by numbers of Cycles' pictures: slopes as wide as the roughness,
// light beyond the seen width of the section goes through. `across` is the direction of the section's major axis; 0: across the view.
closure color b_rough_hair(vector n, vector view, vector along, vector across, color absorption, float roughness, float aspect, float ior,
    float tilt, float first, float second, float third)
{
    float round = clamp(aspect, 0.01, 1.0), rough = clamp(roughness, 0.001, 1.0);
    // Light of further reflections, which the model leaves out: Cycles' pictures show it in white fibres only.
    float rest = absorption == color(0) && max(max(first, second), third) > 0;
    vector major = across - dot(across, along) * along, shown = n;
    float inside = 1;
    if (dot(major, major) > 0) {
        major = normalize(major);
        // The offset from the middle, over half of the width that is seen.
        vector back = normalize(view - dot(view, along) * along);
        vector side = cross(back, along);
        float a = dot(side, major), b = dot(side, cross(along, major));
        float offset = dot(n, side) / sqrt(a * a + round * round * b * b);
        inside = fabs(offset) < 1.0;
        offset = clamp(offset, -1.0, 1.0);
        shown = offset * side + sqrt(1.0 - offset * offset) * back;
    }
    return inside * huang_hair_bsdf(shown, along, major, color(first), color(second), color(third), color(rest), max(ior, 1.001), rough,
        round, -tilt, float(hashnoise(P)), absorption) + (1.0 - inside) * transparent();
}
