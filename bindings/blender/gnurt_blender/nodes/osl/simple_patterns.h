// SPDX-License-Identifier: GPL-3.0-or-later
// Checkers, gradients, and magic: sines and cosines of each other.
float b_checker(vector given)
{
    // Borders do not lie at whole numbers.
    vector p = floor((given + vector(0.000001)) * 0.999999);
    vector odd = fabs(p) - 2.0 * floor(0.5 * fabs(p));
    return ((odd[0] == odd[1]) == (odd[2] != 0.0)) ? 1.0 : 0.0;
}
float b_gradient(vector p, string kind)
{
    float r = 0.0;
    if (kind == "LINEAR") r = p[0];
    else if (kind == "QUADRATIC") {
        r = max(p[0], 0.0);
        r = r * r;
    } else if (kind == "EASING") {
        float t = clamp(p[0], 0.0, 1.0);
        r = t * t * (3.0 - 2.0 * t);
    } else if (kind == "DIAGONAL") r = 0.5 * (p[0] + p[1]);
    else if (kind == "RADIAL") r = atan2(p[1], p[0]) / M_2PI + 0.5;
    else {
        r = max(0.999999 - length(p), 0.0);
        if (kind == "QUADRATIC_SPHERE")
            r = r * r;
    }
    return clamp(r, 0.0, 1.0);
}
color b_magic(vector given, int depth, float strength)
{
    vector p = mod(given, M_2PI);
    float x = sin((p[0] + p[1] + p[2]) * 5.0), y = cos((-p[0] + p[1] - p[2]) * 5.0), z = -cos((-p[0] - p[1] + p[2]) * 5.0);
    float d = strength;
    if (depth > 0) {
        x *= d; y *= d; z *= d;
        y = -cos(x - y + z) * d;
        if (depth > 1) x = cos(x - y - z) * d;
        if (depth > 2) z = sin(-x - y - z) * d;
        if (depth > 3) x = -cos(-x + y - z) * d;
        if (depth > 4) y = -sin(-x + y + z) * d;
        if (depth > 5) y = -cos(-x + y + z) * d;
        if (depth > 6) x = cos(x + y + z) * d;
        if (depth > 7) z = sin(x + y - z) * d;
        if (depth > 8) x = -cos(-x - y + z) * d;
        if (depth > 9) y = -sin(x - y + z) * d;
    }
    if (d != 0.0) {
        x /= 2.0 * d; y /= 2.0 * d; z /= 2.0 * d;
    }
    return color(0.5 - x, 0.5 - y, 0.5 - z);
}
