// SPDX-License-Identifier: GPL-3.0-or-later
// From one range to another.
float b_range(float x, float from_low, float from_high, float to_low, float to_high, float steps, string how, int limited)
{
    if (from_high == from_low)
        return 0.0;
    float t = (x - from_low) / (from_high - from_low);
    if (how == "STEPPED")
        t = (steps > 0.0) ? floor(t * (steps + 1.0)) / steps : 0.0;
    else if (how == "SMOOTHSTEP") {
        t = clamp(t, 0.0, 1.0);
        t = t * t * (3.0 - 2.0 * t);
    } else if (how == "SMOOTHERSTEP") {
        t = clamp(t, 0.0, 1.0);
        t = t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
    }
    float y = to_low + t * (to_high - to_low);
    if (limited)
        y = (to_low > to_high) ? clamp(y, to_high, to_low) : clamp(y, to_low, to_high);
    return y;
}
