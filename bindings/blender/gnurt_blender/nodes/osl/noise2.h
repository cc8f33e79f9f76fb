// SPDX-License-Identifier: GPL-3.0-or-later
// Sums of octaves of gradient noise in 2 dimension(s) [Musgrave, in Texturing and Modeling, chapter 16].
// needs: hash
float b_octaves2(vector p, float detail, float roughness, float lacunarity, float offset, float gain, string kind, int is_normalized)
{
    vector at = p;
    int whole = int(detail);
    float rest = detail - floor(detail), amplitude = 1.0, sum = 0.0, most = 0.0;
    if (kind == "FBM") {
        for (int i = 0; i <= whole; i += 1) {
            sum += amplitude * snoise(at[0], at[1]);
            most += amplitude;
            amplitude *= roughness;
            at *= lacunarity;
        }
        float value = is_normalized ? 0.5 * sum / most + 0.5 : sum;
        if (rest != 0.0) {
            float more = sum + amplitude * snoise(at[0], at[1]);
            value = mix(value, is_normalized ? 0.5 * more / (most + amplitude) + 0.5 : more, rest);
        }
        return value;
    }
    float value = 0.0, weight = 1.0, signal = 0.0;
    if (kind == "MULTIFRACTAL") {
        value = 1.0;
        for (int i = 0; i <= whole; i += 1) {
            value *= amplitude * snoise(at[0], at[1]) + 1.0;
            amplitude *= roughness;
            at *= lacunarity;
        }
        if (rest != 0.0)
            value *= rest * amplitude * snoise(at[0], at[1]) + 1.0;
        return value;
    }
    if (kind == "HETERO_TERRAIN") {
        amplitude = roughness;
        value = offset + snoise(at[0], at[1]);
        at *= lacunarity;
        for (int i = 1; i <= whole; i += 1) {
            value += (snoise(at[0], at[1]) + offset) * amplitude * value;
            amplitude *= roughness;
            at *= lacunarity;
        }
        if (rest != 0.0)
            value += rest * ((snoise(at[0], at[1]) + offset) * amplitude * value);
        return value;
    }
    if (kind == "HYBRID_MULTIFRACTAL") {
        for (int i = 0; weight > 0.001 && i <= whole; i += 1) {
            weight = min(weight, 1.0);
            signal = (snoise(at[0], at[1]) + offset) * amplitude;
            amplitude *= roughness;
            value += weight * signal;
            weight *= gain * signal;
            at *= lacunarity;
        }
        if (rest != 0.0 && weight > 0.001) {
            weight = min(weight, 1.0);
            signal = (snoise(at[0], at[1]) + offset) * amplitude;
            value += rest * weight * signal;
        }
        return value;
    }
    // Ridges.
    amplitude = roughness;
    signal = offset - fabs(snoise(at[0], at[1]));
    signal *= signal;
    value = signal;
    for (int i = 1; i <= whole; i += 1) {
        at *= lacunarity;
        weight = clamp(signal * gain, 0.0, 1.0);
        signal = offset - fabs(snoise(at[0], at[1]));
        signal *= signal * weight;
        value += signal * amplitude;
        amplitude *= roughness;
    }
    return value;
}
vector b_offset2(float seed) { return vector(100.0 + 100.0 * hashnoise(seed, 0.0), 100.0 + 100.0 * hashnoise(seed, 1.0), 0); }
float b_snoise2(vector p) { return snoise(p[0], p[1]); }
void b_noise2(float x, float y, float detail, float roughness, float lacunarity, float offset, float gain, float distortion,
    string kind, int is_normalized, int with_color, output float value, output color tint)
{
    vector p = vector(x, y, 0);
    if (distortion != 0.0) {
        p += distortion * vector(b_snoise2(p + b_offset2(0.0)), b_snoise2(p + b_offset2(1.0)), 0);
    }
    value = b_octaves2(p, detail, roughness, lacunarity, offset, gain, kind, is_normalized);
    tint = color(value);
    if (with_color)
        tint = color(value, b_octaves2(p + b_offset2(2.0), detail, roughness, lacunarity, offset, gain, kind, is_normalized),
            b_octaves2(p + b_offset2(3.0), detail, roughness, lacunarity, offset, gain, kind, is_normalized));
}
