// SPDX-License-Identifier: GPL-3.0-or-later
// Sums of octaves of gradient noise in 4 dimension(s) [Musgrave, in Texturing and Modeling, chapter 16].
// needs: hash
float b_octaves4(vector p, float w, float detail, float roughness, float lacunarity, float offset, float gain, string kind, int is_normalized)
{
    vector at = p;
    float at_w = w;
    int whole = int(detail);
    float rest = detail - floor(detail), amplitude = 1.0, sum = 0.0, most = 0.0;
    if (kind == "FBM") {
        for (int i = 0; i <= whole; i += 1) {
            sum += amplitude * snoise(point(at), at_w);
            most += amplitude;
            amplitude *= roughness;
            at *= lacunarity; at_w *= lacunarity;
        }
        float value = is_normalized ? 0.5 * sum / most + 0.5 : sum;
        if (rest != 0.0) {
            float more = sum + amplitude * snoise(point(at), at_w);
            value = mix(value, is_normalized ? 0.5 * more / (most + amplitude) + 0.5 : more, rest);
        }
        return value;
    }
    float value = 0.0, weight = 1.0, signal = 0.0;
    if (kind == "MULTIFRACTAL") {
        value = 1.0;
        for (int i = 0; i <= whole; i += 1) {
            value *= amplitude * snoise(point(at), at_w) + 1.0;
            amplitude *= roughness;
            at *= lacunarity; at_w *= lacunarity;
        }
        if (rest != 0.0)
            value *= rest * amplitude * snoise(point(at), at_w) + 1.0;
        return value;
    }
    if (kind == "HETERO_TERRAIN") {
        amplitude = roughness;
        value = offset + snoise(point(at), at_w);
        at *= lacunarity; at_w *= lacunarity;
        for (int i = 1; i <= whole; i += 1) {
            value += (snoise(point(at), at_w) + offset) * amplitude * value;
            amplitude *= roughness;
            at *= lacunarity; at_w *= lacunarity;
        }
        if (rest != 0.0)
            value += rest * ((snoise(point(at), at_w) + offset) * amplitude * value);
        return value;
    }
    if (kind == "HYBRID_MULTIFRACTAL") {
        for (int i = 0; weight > 0.001 && i <= whole; i += 1) {
            weight = min(weight, 1.0);
            signal = (snoise(point(at), at_w) + offset) * amplitude;
            amplitude *= roughness;
            value += weight * signal;
            weight *= gain * signal;
            at *= lacunarity; at_w *= lacunarity;
        }
        if (rest != 0.0 && weight > 0.001) {
            weight = min(weight, 1.0);
            signal = (snoise(point(at), at_w) + offset) * amplitude;
            value += rest * weight * signal;
        }
        return value;
    }
    // Ridges.
    amplitude = roughness;
    signal = offset - fabs(snoise(point(at), at_w));
    signal *= signal;
    value = signal;
    for (int i = 1; i <= whole; i += 1) {
        at *= lacunarity; at_w *= lacunarity;
        weight = clamp(signal * gain, 0.0, 1.0);
        signal = offset - fabs(snoise(point(at), at_w));
        signal *= signal * weight;
        value += signal * amplitude;
        amplitude *= roughness;
    }
    return value;
}
vector b_offset4(float seed) { return vector(100.0 + 100.0 * hashnoise(seed, 0.0), 100.0 + 100.0 * hashnoise(seed, 1.0), 100.0 + 100.0 * hashnoise(seed, 2.0)); }
float b_offset4w(float seed) { return 100.0 + 100.0 * hashnoise(seed, 3.0); }
float b_snoise4(vector p, float w, float seed) { return snoise(point(p + b_offset4(seed)), w + b_offset4w(seed)); }
void b_noise4(vector x, float x_w, float detail, float roughness, float lacunarity, float offset, float gain, float distortion,
    string kind, int is_normalized, int with_color, output float value, output color tint)
{
    vector p = x; float p_w = x_w;
    if (distortion != 0.0) {
        vector own = p; float own_w = p_w;
        p += distortion * vector(b_snoise4(own, own_w, 0.0), b_snoise4(own, own_w, 1.0), b_snoise4(own, own_w, 2.0));
        p_w += distortion * b_snoise4(own, own_w, 3.0);
    }
    value = b_octaves4(p, p_w, detail, roughness, lacunarity, offset, gain, kind, is_normalized);
    tint = color(value);
    if (with_color)
        tint = color(value, b_octaves4(p + b_offset4(4.0), p_w + b_offset4w(4.0), detail, roughness, lacunarity, offset, gain, kind, is_normalized),
            b_octaves4(p + b_offset4(5.0), p_w + b_offset4w(5.0), detail, roughness, lacunarity, offset, gain, kind, is_normalized));
}
