// SPDX-License-Identifier: GPL-3.0-or-later
//! Functions in the shading language that generated texts begin with, where they need them.

/// Functions by name, those before them that they call among them.
pub(crate) const ALL: &[(&str, &str)] = &[
    (
        "gnurt_edge",
        "// 0 before an edge and 1 behind it, smooth over a point's width.
float gnurt_edge(float edge, float x) {
    float width = filterwidth(x);
    return width > 0 ? clamp((x - edge) / width + 0.5, 0.0, 1.0) : (x < edge ? 0.0 : 1.0);
}
",
    ),
    (
        "gnurt_turned",
        "// Rodrigues' formula, in degrees.
vector gnurt_turned(vector v, float degrees_, vector axis) {
    vector k = normalize(axis);
    float a = radians(degrees_);
    return v * cos(a) - cross(k, v) * sin(a) + k * dot(k, v) * (1 - cos(a));
}
",
    ),
    (
        "gnurt_burn",
        "float gnurt_burn(float f, float b) { return abs(f) < 1e-8 ? 0.0 : 1 - (1 - b) / f; }
color gnurt_burn(color f, color b) {
    return color(gnurt_burn(f[0], b[0]), gnurt_burn(f[1], b[1]), gnurt_burn(f[2], b[2]));
}
",
    ),
    (
        "gnurt_dodge",
        "float gnurt_dodge(float f, float b) { return abs(1 - f) < 1e-8 ? 0.0 : b / (1 - f); }
color gnurt_dodge(color f, color b) {
    return color(gnurt_dodge(f[0], b[0]), gnurt_dodge(f[1], b[1]), gnurt_dodge(f[2], b[2]));
}
",
    ),
    (
        "gnurt_fractal2",
        "float gnurt_fractal2_float(float x, float y, int octaves, float lacunarity, float diminish) {
    float sum = 0, weight = 1, scale = 1;
    for (int i = 0; i < octaves; i += 1) {
        sum += weight * (float) snoise(x * scale, y * scale);
        weight *= diminish;
        scale *= lacunarity;
    }
    return sum;
}
vector gnurt_fractal2_vector(float x, float y, int octaves, float lacunarity, float diminish) {
    vector sum = 0;
    float weight = 1, scale = 1;
    for (int i = 0; i < octaves; i += 1) {
        sum += weight * (vector) snoise(x * scale, y * scale);
        weight *= diminish;
        scale *= lacunarity;
    }
    return sum;
}
",
    ),
    (
        "gnurt_fractal3",
        "float gnurt_fractal3_float(point p, int octaves, float lacunarity, float diminish) {
    float sum = 0, weight = 1, scale = 1;
    for (int i = 0; i < octaves; i += 1) {
        sum += weight * (float) snoise(p * scale);
        weight *= diminish;
        scale *= lacunarity;
    }
    return sum;
}
vector gnurt_fractal3_vector(point p, int octaves, float lacunarity, float diminish) {
    vector sum = 0;
    float weight = 1, scale = 1;
    for (int i = 0; i < octaves; i += 1) {
        sum += weight * (vector) snoise(p * scale);
        weight *= diminish;
        scale *= lacunarity;
    }
    return sum;
}
",
    ),
    (
        "gnurt_worley",
        "// Distances to the three closest of the points that cells hold; with style 1 random numbers of the cell that the closest is in.
vector gnurt_worley(point at, float jitter, int style, int dimensions, output point closest) {
    point cell = floor(at);
    vector best = vector(1e6);
    closest = point(0);
    int depth = dimensions == 3 ? 1 : 0;
    for (int k = -depth; k <= depth; k += 1) {
        for (int j = -1; j <= 1; j += 1) {
            for (int i = -1; i <= 1; i += 1) {
                point other = cell + vector(i, j, k);
                vector moved = 0;
                if (dimensions == 3) moved = (vector) cellnoise(other);
                else moved = (vector) cellnoise(other[0], other[1]);
                point there = other + vector(0.5) + (moved - vector(0.5)) * jitter;
                vector way = there - at;
                if (dimensions == 2) way[2] = 0;
                float d = dot(way, way);
                if (d < best[0]) {
                    best = vector(d, best[0], best[1]);
                    closest = there;
                } else if (d < best[1]) {
                    best = vector(best[0], d, best[1]);
                } else if (d < best[2]) {
                    best[2] = d;
                }
            }
        }
    }
    if (style == 1) return dimensions == 3 ? (vector) cellnoise(closest) : (vector) cellnoise(closest[0], closest[1]);
    return sqrt(best);
}
float gnurt_worley_float(point at, float jitter, int style, int dimensions) {
    point closest = 0;
    vector found = gnurt_worley(at, jitter, 0, dimensions, closest);
    if (style == 1) return dimensions == 3 ? (float) cellnoise(closest) : (float) cellnoise(closest[0], closest[1]);
    return found[0];
}
",
    ),
    (
        "gnurt_flake",
        "// The nearest flake at a place, if one is there.
void gnurt_flake(point at, int dimensions, float size, float roughness, float coverage, vector n, vector t, vector b,
        output int id, output float rand, output float presence, output vector bent) {
    id = 0;
    rand = 0;
    presence = 0;
    bent = n;
    point p = at / max(size, 1e-6);
    point cell = floor(p);
    int depth = dimensions == 3 ? 1 : 0;
    for (int k = -depth; k <= depth; k += 1) {
        for (int j = -1; j <= 1; j += 1) {
            for (int i = -1; i <= 1; i += 1) {
                point other = cell + vector(i, j, k);
                vector moved = (vector) cellnoise(other);
                vector way = other + moved - p;
                if (dimensions == 2) way[2] = 0;
                float order = cellnoise(other, 1.0);
                if (order <= coverage && dot(way, way) < 0.75 && order > presence) {
                    presence = order;
                    id = 1 + (int) (16777214 * (float) cellnoise(other, 2.0));
                    rand = cellnoise(other, 3.0);
                    float angle = 2 * M_PI * (float) cellnoise(other, 4.0);
                    float slope = roughness * roughness * sqrt(-log(max(1e-6, 1 - (float) cellnoise(other, 5.0))));
                    bent = normalize(n + slope * (cos(angle) * t + sin(angle) * b));
                }
            }
        }
    }
}
",
    ),
    (
        "gnurt_height_to_normal",
        "// The slope of a height over texture coordinates, as a colour of a normal map.
vector gnurt_height_to_normal(float height, float scale, float s, float t) {
    float rise = scale / 16;
    vector n = cross(vector(Dx(s), Dx(t), Dx(height) * rise), vector(Dy(s), Dy(t), Dy(height) * rise));
    if (dot(n, n) < 1e-24) return vector(0.5, 0.5, 1);
    return normalize(n[2] < 0 ? -n : n) * 0.5 + vector(0.5);
}
",
    ),
    (
        "gnurt_mapped_normal",
        "vector gnurt_mapped_normal(vector map, float x, float y, vector n, vector t, vector b) {
    if (map == vector(0)) return n;
    vector v = 2 * map - vector(1);
    return normalize(t * (v[0] * x) + b * (v[1] * y) + n * v[2]);
}
",
    ),
    (
        "gnurt_cone",
        "// Light within a cone around the normal, full within the inner one; angles are whole ones.
float gnurt_cone(vector n, float inner, float outer) {
    float c = dot(normalize(n), -normalize(I));
    float ends[2] = {cos(radians(inner / 2)), cos(radians(max(inner, outer) / 2))};
    return ends[0] > ends[1] ? smoothstep(ends[1], ends[0], c) : (c >= ends[0] ? 1.0 : 0.0);
}
",
    ),
    (
        "gnurt_edge_color",
        "// Schlick's curve.
color gnurt_edge_color(color f0, color f90, float power) {
    float c = clamp(abs(dot(vector(N), normalize(I))), 0.0, 1.0);
    return f0 + (f90 - f0) * pow(1 - c, power);
}
",
    ),
    (
        "gnurt_darkening_at_82",
        "// What a tint at 82 degrees takes from Schlick's curve, at the view's angle.
color gnurt_darkening_at_82(color f0, color f90, color f82, float power, vector n) {
    float c = clamp(abs(dot(vector(n), normalize(I))), 0.0, 1.0);
    color there = f0 + (f90 - f0) * pow(6.0 / 7.0, power);
    return there * (1 - f82) * (c * pow(1 - c, 6) / (1.0 / 7.0 * pow(6.0 / 7.0, 6)));
}
",
    ),
    (
        "gnurt_artistic_ior",
        "void gnurt_artistic_ior(color reflectivity, color edge, output color n, output color k) {
    color r = clamp(reflectivity, color(0), color(0.99));
    color root = sqrt(r);
    color low = (1 - r) / (1 + r), high = (1 + root) / (1 - root);
    n = high * (1 - edge) + low * edge;
    color beyond = n + 1, within = n - 1;
    k = sqrt(max((r * beyond * beyond - within * within) / (1 - r), color(0)));
}
",
    ),
    (
        "gnurt_melanin",
        "vector gnurt_melanin(float concentration, float redness, color eumelanin, color pheomelanin) {
    float melanin = -log(max(1 - concentration, 0.0001));
    color a = melanin * (1 - redness) * -log(eumelanin) + melanin * redness * -log(pheomelanin);
    return vector(max(a, color(0)));
}
",
    ),
    (
        "gnurt_hair_absorption",
        "vector gnurt_hair_absorption(color c, float b) {
    float width = 5.969 + b * (-0.215 + b * (2.532 + b * (-10.73 + b * (5.574 + b * 0.245))));
    color s = log(min(max(c, color(0.001)), color(0.99))) / width;
    return vector(s * s);
}
",
    ),
    (
        "gnurt_blackbody",
        "// The colour of a black body at luminance 1.
color gnurt_blackbody(float kelvin) {
    color c = blackbody(max(kelvin, 1.0));
    return c / max(luminance(c), 1e-8);
}
",
    ),
    (
        "gnurt_hextiled",
        "float gnurt_hex_random(float x, float y, float which) { return cellnoise(point(x, y, which)); }
// Three turned, scaled and moved copies of a picture, blended where their hexagons meet.
color gnurt_hextiled(string file, string space, float u, float v, float tile_u, float tile_v, float turn, float turn_low,
        float turn_high, float size, float size_low, float size_high, float move, float move_low, float move_high,
        float falloff, float contrast, color weights, int is_normal, output float alpha) {
    float s = u * tile_u, t = v * tile_v;
    // To a grid of equilateral triangles.
    float a = s * 3.4641016 - t * 2, b = t * 4;
    float fa = a - floor(a), fb = b - floor(b);
    float rest = 1 - fa - fb, up = rest < 0 ? 1.0 : 0.0;
    float share[3] = {up ? -rest : rest, up ? 1 - fb : fb, up ? 1 - fa : fa};
    float ca[3] = {floor(a) + up, floor(a) + up, floor(a) + 1 - up};
    float cb[3] = {floor(b) + up, floor(b) + 1 - up, floor(b) + up};
    color found[3];
    float opaque[3] = {1, 1, 1};
    float sum = 0;
    for (int i = 0; i < 3; i += 1) {
        float cs = (ca[i] + cb[i] / 2) / 3.4641016, ct = cb[i] / 4;
        float angle = radians(mix(0.0, mix(turn_low, turn_high, gnurt_hex_random(ca[i], cb[i], 0.5)), turn));
        float scale = mix(1.0, mix(size_low, size_high, gnurt_hex_random(ca[i], cb[i], 1.5)), size);
        float ms = move * mix(move_low, move_high, gnurt_hex_random(ca[i], cb[i], 2.5));
        float mt = move * mix(move_low, move_high, gnurt_hex_random(ca[i], cb[i], 3.5));
        float ds = (s - cs) / scale, dt = (t - ct) / scale;
        float x = cs + ms + cos(angle) * ds + sin(angle) * dt, y = ct + mt + cos(angle) * dt - sin(angle) * ds;
        found[i] = (color) texture(file, x, 1 - y, \"wrap\", \"periodic\", \"colorspace\", space, \"alpha\", opaque[i]);
        if (is_normal) {
            // The slope turns with the picture.
            float nx = found[i][0] * 2 - 1, ny = found[i][1] * 2 - 1;
            found[i] = color(0.5 + 0.5 * (cos(angle) * nx - sin(angle) * ny),
                0.5 + 0.5 * (sin(angle) * nx + cos(angle) * ny), found[i][2]);
        }
        float bright = is_normal ? 1.0 : dot(vector(found[i]), vector(weights));
        share[i] = pow(max(share[i], 0.0), 7.0) * mix(1.0, bright, contrast);
        if (falloff != 0.5) share[i] = pow(share[i], log(clamp(1 - falloff, 0.01, 0.99)) / log(0.5));
        sum += share[i];
    }
    alpha = 0;
    color out = 0;
    for (int i = 0; i < 3; i += 1) {
        float part = sum > 0 ? share[i] / sum : 1 / 3.0;
        out += part * found[i];
        alpha += part * opaque[i];
    }
    return out;
}
",
    ),
];
