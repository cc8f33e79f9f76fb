// SPDX-License-Identifier: GPL-3.0-or-later
// From directions and places to places in a picture, v upwards.
vector b_sphere(vector p)
{
    vector d = 2.0 * p - vector(1);
    float l = length(d);
    if (l <= 0.0)
        return vector(0);
    float turn = (d[0] != 0.0 || d[1] != 0.0) ? (1.0 - atan2(d[0], d[1]) / M_PI) / 2.0 : 0.0;
    return vector(turn, 1.0 - acos(clamp(d[2] / l, -1.0, 1.0)) / M_PI, 0);
}
vector b_tube(vector p)
{
    vector d = 2.0 * p - vector(1);
    float l = sqrt(d[0] * d[0] + d[1] * d[1]);
    if (l <= 0.0)
        return vector(0);
    return vector((1.0 - atan2(d[0] / l, d[1] / l) / M_PI) * 0.5, (d[2] + 1.0) * 0.5, 0);
}
vector b_equirectangular(vector p)
{
    vector d = normalize(p);
    return vector(-atan2(d[1], d[0]) / M_2PI + 0.5, atan2(d[2], hypot(d[0], d[1])) / M_PI + 0.5, 0);
}
// In the picture of a sky: only the height of a vector counts beside its azimuth.
vector b_of_sky(vector p)
{
    return vector(-atan2(p[1], p[0]) / M_2PI + 0.5, asin(clamp(p[2], -1.0, 1.0)) / M_PI + 0.5, 0);
}
vector b_mirror_ball(vector p)
{
    vector d = normalize(p);
    d -= vector(0, 1, 0);
    float l = 2.0 * sqrt(max(-0.5 * d[1], 0.0));
    if (l > 0.0)
        d /= l;
    return vector(0.5 * (d[0] + 1.0), 0.5 * (d[2] + 1.0), 0);
}
// Shares of the three views of a box; `blend` widens the part where they mix.
vector b_box_weights(vector facing, float blend)
{
    vector n = fabs(facing);
    n /= (n[0] + n[1] + n[2]);
    float limit = 0.5 * (1.0 + blend), w = 1.0 - blend;
    if (n[0] > limit * (n[0] + n[1]) && n[0] > limit * (n[0] + n[2]))
        return vector(1, 0, 0);
    if (n[1] > limit * (n[0] + n[1]) && n[1] > limit * (n[1] + n[2]))
        return vector(0, 1, 0);
    if (n[2] > limit * (n[0] + n[2]) && n[2] > limit * (n[1] + n[2]))
        return vector(0, 0, 1);
    if (blend <= 0.0)
        return vector(1, 0, 0);
    if (n[2] < (1.0 - limit) * (n[1] + n[0])) {
        float x = clamp((n[0] / (n[0] + n[1]) - 0.5 * w) / blend, 0.0, 1.0);
        return vector(x, 1.0 - x, 0);
    }
    if (n[0] < (1.0 - limit) * (n[1] + n[2])) {
        float y = clamp((n[1] / (n[1] + n[2]) - 0.5 * w) / blend, 0.0, 1.0);
        return vector(0, y, 1.0 - y);
    }
    if (n[1] < (1.0 - limit) * (n[0] + n[2])) {
        float x = clamp((n[0] / (n[0] + n[2]) - 0.5 * w) / blend, 0.0, 1.0);
        return vector(x, 0, 1.0 - x);
    }
    return vector((2.0 - limit) * n[0] + (limit - 1.0), (2.0 - limit) * n[1] + (limit - 1.0), (2.0 - limit) * n[2] + (limit - 1.0));
}
// Places and shares of the linear taps that make a cubic B-spline [Sigg and Hadwiger, Fast third-order texture filtering, 2005].
void b_spline_axis(float at, float count, output float low, output float high, output float share)
{
    float x = at * count - 0.5, i = floor(x), t = x - i;
    float w0 = (1.0 - t) * (1.0 - t) * (1.0 - t) / 6.0, w1 = (3.0 * t * t * t - 6.0 * t * t + 4.0) / 6.0, w3 = t * t * t / 6.0;
    float w2 = 1.0 - w0 - w1 - w3;
    low = (i - 0.5 + w1 / (w0 + w1)) / count;
    high = (i + 1.5 + w3 / (w2 + w3)) / count;
    share = w2 + w3;
}
void b_spline_taps(vector uv, float width, float height, output vector places[4], output float shares[4])
{
    float x0, x1, sx, y0, y1, sy;
    b_spline_axis(uv[0], width, x0, x1, sx);
    b_spline_axis(uv[1], height, y0, y1, sy);
    places[0] = vector(x0, y0, 0);
    places[1] = vector(x1, y0, 0);
    places[2] = vector(x0, y1, 0);
    places[3] = vector(x1, y1, 0);
    shares[0] = (1.0 - sx) * (1.0 - sy);
    shares[1] = sx * (1.0 - sy);
    shares[2] = (1.0 - sx) * sy;
    shares[3] = sx * sy;
}
