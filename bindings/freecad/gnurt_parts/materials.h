// SPDX-License-Identifier: GPL-3.0-or-later
// The Render workbench's materials as closures. `n` is the normal, `t` the direction of texture coordinate u.

// Texture coordinates turned, scaled and moved as the workbench defines it.
point fc_place (float s, float t, float scale, float angle, float move_u, float move_v)
{
    float c = scale * cos (angle), d = scale * sin (angle);
    return point (c * s - d * t + move_u, d * s + c * t + move_v, 0);
}

// A normal map with green upwards, along turned texture coordinates.
vector fc_normal (vector n, color texel, float strength, float angle, vector along_u, vector along_v)
{
    vector t = cos (angle) * along_u - sin (angle) * along_v;
    t = normalize (t - dot (t, n) * n);
    vector b = cross (n, t) * (dot (cross (n, t), along_v) < 0 ? -1.0 : 1.0);
    vector own = vector (2 * texel[0] - 1, 2 * texel[1] - 1, 2 * texel[2] - 1);
    return normalize (strength * own[0] * t + strength * own[1] * b + max (own[2], 0.01) * n);
}

closure color fc_diffuse (vector n, vector t, color base)
{
    return base * diffuse (n);
}

closure color fc_glass (vector n, vector t, color tint, float ior)
{
    return dielectric_bsdf (n, t, 1, tint, 0, 0, ior, "ggx");
}

closure color fc_mixed (vector n, vector t, color base, color tint, float ior, float transparency)
{
    float share = clamp (transparency, 0, 1);
    return (1 - share) * fc_diffuse (n, t, base) + share * fc_glass (n, t, tint, ior);
}

// A clear coat over flakes of metal in paint.
closure color fc_carpaint (vector n, vector t, color base)
{
    closure color flakes = generalized_schlick_bsdf (n, t, 1, 0, 0.2, 0.2, base, 1, 5, "ggx");
    return layer (dielectric_bsdf (n, t, 1, 0, 0, 0, 1.5, "ggx"), 0.4 * flakes + 0.6 * base * diffuse (n));
}

// The power leaves both sides of the mesh.
closure color fc_emission (vector n, vector t, color tint, float power)
{
    return power / (M_PI * surfacearea ()) * tint * emission ();
}

// Burley, Physically based shading at Disney (2012). Light below the surface is diffuse.
closure color fc_disney (vector n, vector t, color base, float subsurface, float metallic, float specular,
    float specular_tint, float roughness, float anisotropic, float sheen, float sheen_tint, float coat, float gloss)
{
    float aspect = sqrt (1 - 0.9 * clamp (anisotropic, 0, 1));
    float alpha = roughness * roughness, ax = min (alpha / aspect, 1), ay = alpha * aspect;
    float luminance = 0.2126 * base[0] + 0.7152 * base[1] + 0.0722 * base[2];
    color hue = luminance > 0 ? base / luminance : color (1);
    color normal_incidence = 0.08 * specular * mix (color (1), hue, specular_tint);
    float metal = clamp (metallic, 0, 1);
    closure color body = (1 - metal)
        * layer (generalized_schlick_bsdf (n, t, 1, 0, ax, ay, min (normal_incidence, color (1)), 1, 5, "ggx"),
            base * diffuse (n));
    if (metal > 0)
        body += metal * generalized_schlick_bsdf (n, t, 1, 0, ax, ay, base, 1, 5, "ggx");
    if (sheen > 0)
        body = layer (sheen_bsdf (n, clamp (sheen * mix (color (1), hue, sheen_tint), color (0), color (1)), 0.09), body);
    if (coat > 0) {
        float width = mix (0.1, 0.001, clamp (gloss, 0, 1));
        body = layer (0.25 * min (coat, 1) * dielectric_bsdf (n, t, 1, 0, width, width, 1.5, "ggx"), body);
    }
    return body;
}

closure color fc_substance_pbr (vector n, vector t, color base, float roughness, float metallic, float specular)
{
    return fc_disney (n, t, base, 0, metallic, specular, 0, roughness, 0, 0, 0, 0, 0);
}
