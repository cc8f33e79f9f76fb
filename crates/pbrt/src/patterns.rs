// SPDX-License-Identifier: GPL-3.0-or-later
//! Functions in the shading language that textures call: noise in octaves, boards, dots, marble.
//! Source: Perlin's sums as the file-format page and [PJH23] chapter 10 describe them. Differs: the noise itself is the
//! shading language's, so patterns have the same statistics and other places; octaves do not depend on the ray's width.

/// Their text.
pub(crate) const FUNCTIONS: &str = r#"
float pbrt_mean (color c) { return (c[0] + c[1] + c[2]) / 3; }
float pbrt_hair_variance (float b)
{
    float root = 0.726 * b + 0.812 * b * b + 3.7 * pow (b, 20);
    return root * root;
}
float pbrt_hair_scale (float b) { return 0.265 * b + 1.194 * b * b + 5.372 * pow (b, 22); }
color pbrt_hair_absorption (color c, float b)
{
    float by = 5.969 + b * (-0.215 + b * (2.532 + b * (-10.73 + b * (5.574 + 0.245 * b))));
    color root = log (clamp (c, color (1e-4), color (1))) / by;
    return root * root;
}
float pbrt_fbm (point at, float omega, int octaves)
{
    float sum = 0, scale = 1, share = 1;
    for (int i = 0; i < octaves; ++i) {
        float value = noise ("perlin", scale * at);
        sum += share * value;
        scale *= 1.99;
        share *= omega;
    }
    return sum;
}
float pbrt_turbulence (point at, float omega, int octaves)
{
    float sum = 0, scale = 1, share = 1;
    for (int i = 0; i < octaves; ++i) {
        float value = noise ("perlin", scale * at);
        sum += share * fabs (value);
        scale *= 1.99;
        share *= omega;
    }
    return sum;
}
float pbrt_board (float x) { return mod (floor (x), 2); }
float pbrt_dot (float s, float t)
{
    float cs = floor (s + 0.5), ct = floor (t + 0.5);
    float inside = 0;
    float here = noise ("perlin", point (cs + 0.5, ct + 0.5, 0.5));
    if (here > 0) {
        float right = noise ("perlin", point (cs + 1.5, ct + 2.8, 0.5));
        float up = noise ("perlin", point (cs + 4.5, ct + 9.8, 0.5));
        float ds = s - cs - 0.15 * right, dt = t - ct - 0.15 * up;
        inside = ds * ds + dt * dt < 0.35 * 0.35 ? 1 : 0;
    }
    return inside;
}
color pbrt_marble (float phase)
{
    color c[9] = { color (0.58, 0.58, 0.6), color (0.58, 0.58, 0.6), color (0.58, 0.58, 0.6), color (0.5, 0.5, 0.5),
        color (0.6, 0.59, 0.58), color (0.58, 0.58, 0.6), color (0.58, 0.58, 0.6), color (0.2, 0.2, 0.33),
        color (0.58, 0.58, 0.6) };
    float t = (0.5 + 0.5 * sin (phase)) * 6;
    int first = min (int (floor (t)), 5);
    t -= first;
    float r = 1 - t;
    return 1.5 * (r * r * r * c[first] + 3 * r * r * t * c[first + 1] + 3 * r * t * t * c[first + 2]
        + t * t * t * c[first + 3]);
}
float pbrt_fresnel (float cosine, float eta)
{
    float ratio = eta;
    float s = max (0, 1 - cosine * cosine) / (ratio * ratio);
    float result = 1;
    if (s < 1) {
        float ct = sqrt (1 - s);
        float a = (ratio * cosine - ct) / (ratio * cosine + ct);
        float b = (cosine - ratio * ct) / (cosine + ratio * ct);
        result = 0.5 * (a * a + b * b);
    }
    return result;
}
"#;
