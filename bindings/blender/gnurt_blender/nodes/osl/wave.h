// SPDX-License-Identifier: GPL-3.0-or-later
// Bands and rings, bent by noise.
// needs: noise3
float b_wave(vector given, string kind, string direction, string profile, float distortion, float detail, float detail_scale,
    float detail_roughness, float phase)
{
    // Borders do not lie at whole numbers.
    vector p = (given + vector(0.000001)) * 0.999999;
    float n;
    if (kind == "BANDS") {
        if (direction == "X") n = p[0] * 20.0;
        else if (direction == "Y") n = p[1] * 20.0;
        else if (direction == "Z") n = p[2] * 20.0;
        else n = (p[0] + p[1] + p[2]) * 10.0;
    } else {
        vector r = p;
        if (direction == "X") r = vector(0, p[1], p[2]);
        else if (direction == "Y") r = vector(p[0], 0, p[2]);
        else if (direction == "Z") r = vector(p[0], p[1], 0);
        n = length(r) * 20.0;
    }
    n += phase;
    if (distortion != 0.0)
        n += distortion * (2.0 * b_octaves3(p * detail_scale, clamp(detail, 0.0, 15.0), clamp(detail_roughness, 0.0, 1.0), 2.0, 0.0, 0.0, "FBM", 1) - 1.0);
    if (profile == "SIN")
        return 0.5 + 0.5 * sin(n - M_PI_2);
    n /= M_2PI;
    if (profile == "SAW")
        return n - floor(n);
    return fabs(n - floor(n + 0.5)) * 2.0;
}
