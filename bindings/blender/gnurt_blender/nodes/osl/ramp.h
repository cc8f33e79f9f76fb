// SPDX-License-Identifier: GPL-3.0-or-later
// A ramp of colours by its stops, which ascend.
float b_spline_weight(int k, float t, string how)
{
    float t2 = t * t, t3 = t2 * t;
    float w = 0.0;
    if (how == "CARDINAL") {
        float c = 0.71;
        if (k == 0) w = -c * t3 + 2.0 * c * t2 - c * t;
        else if (k == 1) w = (2.0 - c) * t3 + (c - 3.0) * t2 + 1.0;
        else if (k == 2) w = (c - 2.0) * t3 + (3.0 - 2.0 * c) * t2 + c * t;
        else w = c * t3 - c * t2;
    } else {
        if (k == 0) w = (-t3 + 3.0 * t2 - 3.0 * t + 1.0) / 6.0;
        else if (k == 1) w = (3.0 * t3 - 6.0 * t2 + 4.0) / 6.0;
        else if (k == 2) w = (-3.0 * t3 + 3.0 * t2 + 3.0 * t + 1.0) / 6.0;
        else w = t3 / 6.0;
    }
    return w;
}
void b_ramp(float x, float at[], color colors[], float alphas[], int count, string how, output color c, output float a)
{
    float p = clamp(x, 0.0, 1.0);
    int last = count - 1;
    c = colors[0];
    a = alphas[0];
    if (count == 1)
        return;
    int is_spline = (how == "CARDINAL" || how == "B_SPLINE");
    int i = 0;
    while (i < count && at[i] <= p)
        i += 1;
    // The stops before and after.
    int low = max(i - 1, 0), high = min(i, last);
    if (!is_spline && (i == 0 || i == count)) {
        c = colors[low];
        a = alphas[low];
        if (i == 0) {
            c = colors[0];
            a = alphas[0];
        }
        return;
    }
    float from = (i == 0) ? 0.0 : at[low], to = (i == count) ? 1.0 : at[high];
    float t = (to > from) ? (p - from) / (to - from) : ((i == count) ? 0.0 : 1.0);
    if (is_spline) {
        int k0 = max(low - 1, 0), k3 = min(high + 1, last);
        if (i == count) k3 = last;
        if (i == 0) k0 = 0;
        float w0 = b_spline_weight(0, t, how), w1 = b_spline_weight(1, t, how);
        float w2 = b_spline_weight(2, t, how), w3 = b_spline_weight(3, t, how);
        c = clamp(w0 * colors[k0] + w1 * colors[low] + w2 * colors[high] + w3 * colors[k3], color(0), color(1));
        a = clamp(w0 * alphas[k0] + w1 * alphas[low] + w2 * alphas[high] + w3 * alphas[k3], 0.0, 1.0);
        return;
    }
    if (how == "CONSTANT")
        t = 0.0;
    else if (how == "EASE")
        t = t * t * (3.0 - 2.0 * t);
    c = mix(colors[low], colors[high], t);
    a = mix(alphas[low], alphas[high], t);
}
