// SPDX-License-Identifier: GPL-3.0-or-later
// Patterns that several surfaces share. Include it after nothing: the language brings its own library.
#ifndef GNURT_PATTERNS_H
#define GNURT_PATTERNS_H

// How much of a pattern with features of this size is left where pixels are this wide: 1 for none lost, 0 for all.
float detail_left (float pixel_width, float feature_size)
{
    return 1 - smoothstep (0.3 * feature_size, feature_size, pixel_width);
}

// The largest change of a point from pixel to pixel.
float width_of (point p)
{
    vector w = filterwidth (p);
    return max (w[0], max (w[1], w[2]));
}

// Octaves of noise, each twice as fine and `gain` times as high, in about [-1, 1]. Octaves that pixels are too wide for fade out.
float fbm (point p, int octaves, float gain)
{
    float sum = 0, height = 1, total = 0, frequency = 1;
    float width = width_of (p);
    for (int i = 0; i < octaves; ++i) {
        sum += height * detail_left (width * frequency, 1) * snoise (p * frequency);
        total += height;
        height *= gain;
        frequency *= 2;
    }
    return sum / max (total, 1e-6);
}

// As fbm, but of absolute values: creases instead of hills, in about [0, 1].
float turbulence (point p, int octaves)
{
    float sum = 0, height = 1, total = 0, frequency = 1;
    float width = width_of (p);
    for (int i = 0; i < octaves; ++i) {
        // What fades out leaves its mean.
        sum += height * mix (0.3, fabs (snoise (p * frequency)), detail_left (width * frequency, 1));
        total += height;
        height *= 0.5;
        frequency *= 2;
    }
    return sum / max (total, 1e-6);
}

// Points scattered one to a cell: the distances to the nearest and the second one, and a number of the nearest one's own.
void cells (point p, float jitter, output float nearest, output float second, output float own)
{
    nearest = 1e6;
    second = 1e6;
    own = 0;
    point corner = point (floor (p[0]), floor (p[1]), floor (p[2]));
    for (int i = -1; i <= 1; ++i)
        for (int j = -1; j <= 1; ++j)
            for (int k = -1; k <= 1; ++k) {
                point cell = corner + vector (i, j, k);
                vector place = vector (0.5) + jitter * ((vector) noise ("cell", cell) - vector (0.5));
                float d = distance (p, cell + place);
                if (d < nearest) {
                    second = nearest;
                    nearest = d;
                    own = (float) noise ("cell", cell + vector (0.5), 7);
                } else if (d < second) {
                    second = d;
                }
            }
}

// The shading normal of a surface that is raised by `height`, in units of the scene, along its normal.
normal raised (float height)
{
    vector plain = normalize (calculatenormal (P));
    vector raised_one = normalize (calculatenormal (P + height * normalize (N)));
    return normalize (N + raised_one - plain);
}

// A clear layer over a base: its Fresnel reflection takes away what the base does not get.
closure color coated (closure color base, normal n, float roughness, float ior)
{
    return layer (dielectric_bsdf (n, vector (0), color (1), color (0), roughness, roughness, ior, "ggx"), base);
}

#endif
