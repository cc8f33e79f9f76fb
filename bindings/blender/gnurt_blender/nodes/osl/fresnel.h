// SPDX-License-Identifier: GPL-3.0-or-later
// Fresnel's equations for unpolarised light at a dielectric; the eta is the index beyond over the index on this side.
float b_fresnel(float cosine, float eta)
{
    float c = fabs(cosine);
    float g = eta * eta - 1.0 + c * c;
    if (g <= 0.0)
        return 1.0;
    g = sqrt(g);
    float a = (g - c) / (g + c);
    float b = ((g + c) * c - 1.0) / ((g - c) * c + 1.0);
    return 0.5 * a * a * (1.0 + b * b);
}
float b_fresnel_node(float ior, vector n, vector i, int back)
{
    float eta = max(ior, 1e-5);
    return b_fresnel(dot(i, n), back ? 1.0 / eta : eta);
}
float b_layer_fresnel(float blend, vector n, vector i, int back)
{
    float eta = max(1.0 - blend, 1e-5);
    return b_fresnel(dot(i, n), back ? eta : 1.0 / eta);
}
float b_layer_facing(float blend, vector n, vector i)
{
    float facing = fabs(dot(i, n));
    if (blend != 0.5) {
        float b = clamp(blend, 0.0, 1.0 - 1e-5);
        facing = pow(facing, (b < 0.5) ? 2.0 * b : 0.5 / (1.0 - b));
    }
    return 1.0 - facing;
}
