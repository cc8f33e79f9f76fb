// SPDX-License-Identifier: GPL-3.0-or-later
// Numbers of surfaces.
// The reflectance of a dielectric at normal incidence.
float b_f0(float ior)
{
    float r = (ior - 1.0) / (ior + 1.0);
    return r * r;
}
// The exponent with which Schlick's curve has the mean of Fresnel's, by a rational fit of that mean over f0 (index 1 to 3).
float b_power(float f0)
{
    float root = sqrt(clamp(f0, 0.0, 0.25));
    float ior = (1.0 + root) / (1.0 - root);
    // The mean over all directions, weighted by the cosine, minus f0, over 1 - f0.
    float mean = (ior - 1.0) / (4.08567 + 1.00071 * ior);
    float rest = (mean - root * root) / (1.0 - root * root);
    return (rest > 0.001) ? clamp(0.5 * (sqrt(1.0 + 8.0 / rest) - 3.0), 1.0, 12.0) : 5.0;
}
// The reflectance of a metal that has `edge` times Schlick's at 82 degrees, at the angle of the view [Kutz et al., Novel aspects of the Adobe
// Standard Material, 2021].
color b_f82(color base, color edge, vector n, vector i)
{
    float at = 1.0 / 7.0, c = min(fabs(dot(n, i)), 1.0), d = 1.0 - c;
    color schlick = base + (color(1) - base) * pow(1.0 - at, 5.0);
    color b = schlick * (color(1) - edge) / (at * pow(1.0 - at, 6.0));
    return clamp(base + (color(1) - base) * (d * d * d * d * d) - b * (c * d * d * d * d * d * d), color(0), color(1));
}
// Absorption of a clear layer along the refracted ways in and out; the way in counts as the mean of all.
color b_coat_tint(color tint, float weight, float ior, vector n, vector i)
{
    float c = fabs(dot(n, i));
    float inner = sqrt(max(1.0 - (1.0 - c * c) / (ior * ior), 1e-4));
    return mix(color(1), pow(tint, 1.0 / inner), weight);
}
// The direction of anisotropy in the plane of the normal, turned by a share of a circle.
vector b_turned_tangent(vector tangent, vector n, float turn)
{
    vector t = tangent - dot(tangent, n) * n;
    float l = length(t);
    if (l == 0.0)
        return tangent;
    t /= l;
    float a = turn * M_2PI;
    return cos(a) * t + sin(a) * cross(n, t);
}
// One over the share of light that Fresnel's equations send through.
float b_whole_refraction(vector n, vector i, float eta)
{
    float c = fabs(dot(n, i));
    float g = eta * eta - 1.0 + c * c;
    if (g <= 0.0)
        return 0.0;
    g = sqrt(g);
    float a = (g - c) / (g + c), b = ((g + c) * c - 1.0) / ((g - c) * c + 1.0);
    return 1.0 / max(1.0 - 0.5 * a * a * (1.0 + b * b), 0.05);
}
// The index of a reflectance at normal incidence.
float b_index(float f0)
{
    float root = sqrt(clamp(f0, 0.0, 0.98));
    return (1.0 + root) / (1.0 - root);
}
// A tint of rough glass: light that goes between facets more than once is tinted more than once. The share is fitted to pictures.
color b_between_facets(color tint, float alpha, vector n, vector i)
{
    float share = min(alpha * alpha * (0.7 + 3.1 * (1.0 - fabs(dot(n, i)))), 0.8);
    return tint * (color(1) - share * (color(1) - min(tint, color(1))));
}
// Shares by which pictures of Cycles are darker than these models: rough gloss, and rough diffuse surfaces that are neither black nor white.
float b_gloss(float alpha) { return 1.0 - 0.4 * alpha * alpha; }
color b_rough(color albedo, float roughness, vector n, vector i)
{
    color a = clamp(albedo, color(0), color(1));
    return color(1) - roughness * (0.015 + 0.22 * fabs(dot(n, i))) * a * (color(1) - a);
}
// Schlick's reflectance.
color b_schlick(color f0, color f90, vector n, vector i)
{
    float c = 1.0 - min(fabs(dot(n, i)), 1.0);
    return f0 + (f90 - f0) * (c * c * c * c * c);
}
