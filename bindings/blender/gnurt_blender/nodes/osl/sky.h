// SPDX-License-Identifier: GPL-3.0-or-later
// The clear sky of Preetham, Shirley and Smits, A practical analytic model for daylight (1999).
float b_perez(float cos_theta, float gamma, float a, float b, float c, float d, float e)
{
    float cg = cos(gamma);
    return (1.0 + a * exp(b / cos_theta)) * (1.0 + c * exp(d * gamma) + e * cg * cg);
}
color b_preetham(vector at, vector sun, float t)
{
    // As angles: only the height of the vector counts beside its azimuth.
    float high = clamp(at[2], -1.0, 1.0), flat = hypot(at[0], at[1]), wide = sqrt(1.0 - high * high) / max(flat, 1e-9);
    vector d = vector(at[0] * wide, at[1] * wide, high), s = normalize(sun);
    float ct = max(d[2], 0.001);
    float gamma = acos(clamp(dot(d, s), -1.0, 1.0)), ts = acos(clamp(s[2], -1.0, 1.0));
    float chi = (4.0 / 9.0 - t / 120.0) * (M_PI - 2.0 * ts), t2 = t * t, s2 = ts * ts, s3 = s2 * ts;
    float zy = (4.0453 * t - 4.9710) * tan(chi) - 0.2155 * t + 2.4192;
    float zx = (0.00166 * s3 - 0.00375 * s2 + 0.00209 * ts) * t2 + (-0.02903 * s3 + 0.06377 * s2 - 0.03202 * ts + 0.00394) * t
        + (0.11693 * s3 - 0.21196 * s2 + 0.06052 * ts + 0.25886);
    float zz = (0.00275 * s3 - 0.00610 * s2 + 0.00317 * ts) * t2 + (-0.04214 * s3 + 0.08970 * s2 - 0.04153 * ts + 0.00516) * t
        + (0.15346 * s3 - 0.26756 * s2 + 0.06670 * ts + 0.26688);
    float c0 = cos(0.0);
    float y = max(zy, 0.0) * 0.06 * b_perez(ct, gamma, 0.1787 * t - 1.4630, -0.3554 * t + 0.4275, -0.0227 * t + 5.3251, 0.1206 * t - 2.5771, -0.0670 * t + 0.3703)
        / b_perez(c0, ts, 0.1787 * t - 1.4630, -0.3554 * t + 0.4275, -0.0227 * t + 5.3251, 0.1206 * t - 2.5771, -0.0670 * t + 0.3703);
    float x = zx * b_perez(ct, gamma, -0.0193 * t - 0.2592, -0.0665 * t + 0.0008, -0.0004 * t + 0.2125, -0.0641 * t - 0.8989, -0.0033 * t + 0.0452)
        / b_perez(c0, ts, -0.0193 * t - 0.2592, -0.0665 * t + 0.0008, -0.0004 * t + 0.2125, -0.0641 * t - 0.8989, -0.0033 * t + 0.0452);
    float z = zz * b_perez(ct, gamma, -0.0167 * t - 0.2608, -0.0950 * t + 0.0092, -0.0079 * t + 0.2102, -0.0441 * t - 1.6537, -0.0109 * t + 0.0529)
        / b_perez(c0, ts, -0.0167 * t - 0.2608, -0.0950 * t + 0.0092, -0.0079 * t + 0.2102, -0.0441 * t - 1.6537, -0.0109 * t + 0.0529);
    color xyz = color(x / z * y, y, (1.0 - x - z) / z * y);
    color rgb = color(3.2406 * xyz[0] - 1.5372 * xyz[1] - 0.4986 * xyz[2], -0.9689 * xyz[0] + 1.8758 * xyz[1] + 0.0415 * xyz[2],
                      0.0557 * xyz[0] - 0.2040 * xyz[1] + 1.0570 * xyz[2]);
    return max(rgb, color(0));
}
