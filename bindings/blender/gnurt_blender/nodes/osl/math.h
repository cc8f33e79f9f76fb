// SPDX-License-Identifier: GPL-3.0-or-later
// Numbers as Blender's Math node has them: what has no value is 0.
float b_pow(float a, float b)
{
    if (b == 0.0)
        return 1.0;
    if (a < 0.0) {
        float whole = floor(b);
        if (b != whole)
            return 0.0;
        float p = pow(-a, b);
        return (fmod(fabs(whole), 2.0) == 1.0) ? -p : p;
    }
    return pow(a, b);
}
float b_log(float a, float b) { return (a > 0.0 && b > 0.0) ? log(a) / log(b) : 0.0; }
float b_fmod(float a, float b) { return (b == 0.0) ? 0.0 : fmod(a, b); }
float b_floored(float a, float b) { return (b == 0.0) ? 0.0 : a - floor(a / b) * b; }
float b_wrap(float a, float high, float low)
{
    float range = high - low;
    return (range == 0.0) ? low : a - range * floor((a - low) / range);
}
float b_pingpong(float a, float b)
{
    if (b == 0.0)
        return 0.0;
    float t = (a - b) / (b * 2.0);
    return fabs((t - floor(t)) * b * 2.0 - b);
}
float b_smooth_min(float a, float b, float k)
{
    if (k == 0.0)
        return min(a, b);
    float h = max(k - fabs(a - b), 0.0) / k;
    return min(a, b) - h * h * h * k * (1.0 / 6.0);
}
