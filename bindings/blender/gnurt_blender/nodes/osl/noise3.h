// SPDX-License-Identifier: GPL-3.0-or-later
// Sums of octaves of gradient noise in 3 dimension(s) [Musgrave, in Texturing and Modeling, chapter 16].
// needs: hash
float b_octaves3(vector p, float detail, float roughness, float lacunarity, float offset, float gain, string kind, int is_normalized)
{
    vector at = p;
    int whole = int(detail);
    float rest = detail - floor(detail), amplitude = 1.0, sum = 0.0, most = 0.0;
    if (kind == "FBM") {
        for (int i = 0; i <= whole; i += 1) {
            sum += amplitude * snoise(point(at));
            most += amplitude;
            amplitude *= roughness;
            at *= lacunarity;
        }
        float value = is_normalized ? 0.5 * sum / most + 0.5 : sum;
        if (rest != 0.0) {
            float more = sum + amplitude * snoise(point(at));
            value = mix(value, is_normalized ? 0.5 * more / (most + amplitude) + 0.5 : more, rest);
        }
        return value;
    }
    float value = 0.0, weight = 1.0, signal = 0.0;
    if (kind == "MULTIFRACTAL") {
        value = 1.0;
        for (int i = 0; i <= whole; i += 1) {
            value *= amplitude * snoise(point(at)) + 1.0;
            amplitude *= roughness;
            at *= lacunarity;
        }
        if (rest != 0.0)
            value *= rest * amplitude * snoise(point(at)) + 1.0;
        return value;
    }
    if (kind == "HETERO_TERRAIN") {
        amplitude = roughness;
        value = offset + snoise(point(at));
        at *= lacunarity;
        for (int i = 1; i <= whole; i += 1) {
            value += (snoise(point(at)) + offset) * amplitude * value;
            amplitude *= roughness;
            at *= lacunarity;
        }
        if (rest != 0.0)
            value += rest * ((snoise(point(at)) + offset) * amplitude * value);
        return value;
    }
    if (kind == "HYBRID_MULTIFRACTAL") {
        for (int i = 0; weight > 0.001 && i <= whole; i += 1) {
            weight = min(weight, 1.0);
            signal = (snoise(point(at)) + offset) * amplitude;
            amplitude *= roughness;
            value += weight * signal;
            weight *= gain * signal;
            at *= lacunarity;
        }
        if (rest != 0.0 && weight > 0.001) {
            weight = min(weight, 1.0);
            signal = (snoise(point(at)) + offset) * amplitude;
            value += rest * weight * signal;
        }
        return value;
    }
    // Ridges.
    amplitude = roughness;
    signal = offset - fabs(snoise(point(at)));
    signal *= signal;
    value = signal;
    for (int i = 1; i <= whole; i += 1) {
        at *= lacunarity;
        weight = clamp(signal * gain, 0.0, 1.0);
        signal = offset - fabs(snoise(point(at)));
        signal *= signal * weight;
        value += signal * amplitude;
        amplitude *= roughness;
    }
    return value;
}
vector b_offset3(float seed) { return vector(100.0 + 100.0 * hashnoise(seed, 0.0), 100.0 + 100.0 * hashnoise(seed, 1.0), 100.0 + 100.0 * hashnoise(seed, 2.0)); }
void b_noise3(vector x, float detail, float roughness, float lacunarity, float offset, float gain, float distortion,
    string kind, int is_normalized, int with_color, output float value, output color tint)
{
    vector p = x;
    if (distortion != 0.0) {
        p += distortion * vector(snoise(point(p + b_offset3(0.0))), snoise(point(p + b_offset3(1.0))), snoise(point(p + b_offset3(2.0))));
    }
    value = b_octaves3(p, detail, roughness, lacunarity, offset, gain, kind, is_normalized);
    tint = color(value);
    if (with_color)
        tint = color(value, b_octaves3(p + b_offset3(3.0), detail, roughness, lacunarity, offset, gain, kind, is_normalized),
            b_octaves3(p + b_offset3(4.0), detail, roughness, lacunarity, offset, gain, kind, is_normalized));
}
