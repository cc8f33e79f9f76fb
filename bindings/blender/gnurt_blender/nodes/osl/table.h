// SPDX-License-Identifier: GPL-3.0-or-later
// Tables of evenly spaced values, linear between them.
float b_table(float x, float values[], int count)
{
    float at = clamp(x, 0.0, 1.0) * (count - 1);
    int i = min(int(at), count - 2);
    return mix(values[i], values[i + 1], at - i);
}
color b_table(float x, color values[], int count)
{
    float at = clamp(x, 0.0, 1.0) * (count - 1);
    int i = min(int(at), count - 2);
    return mix(values[i], values[i + 1], at - i);
}
// The same over a range; beyond it the ends go on, straight ahead or even.
float b_curve(float x, float values[], int count, float low, float high, int ahead)
{
    float at = (x - low) / (high - low) * (count - 1);
    if (ahead && at < 0.0)
        return values[0] + at * (values[1] - values[0]);
    if (ahead && at > count - 1)
        return values[count - 1] + (at - (count - 1)) * (values[count - 1] - values[count - 2]);
    at = clamp(at, 0.0, count - 1.0);
    int i = min(int(at), count - 2);
    return mix(values[i], values[i + 1], at - i);
}
