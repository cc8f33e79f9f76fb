# SPDX-License-Identifier: GPL-3.0-or-later
"""Voronoi's cells in one to four dimensions, as functions of the shading language: one text for each feature that is used.

A point is a vector and a number `w`; the first axes of it count. [Worley, A cellular texture basis function, 1996]
"""


HEAD = """
float b_cells{d}_length(vector v, float w, string metric, float exponent)
{{
    vector a = fabs(v);
    float b = fabs(w);
    if (metric == "MANHATTAN")
        return a[0] + a[1] + a[2] + b;
    if (metric == "CHEBYCHEV")
        return max(max(a[0], a[1]), max(a[2], b));
    if (metric == "MINKOWSKI")
        return pow(pow(a[0], exponent) + pow(a[1], exponent) + pow(a[2], exponent) + pow(b, exponent), 1.0 / exponent);
    return sqrt(dot(v, v) + w * w);
}}
void b_cells{d}_point(vector cell, float cell_w, float randomness, output vector at, output float at_w)
{{
    at_w = 0.0;
    {point}
    at *= randomness;
    at_w *= randomness;
}}
color b_cells{d}_color(vector cell, float cell_w) {{ return {color}; }}
"""

# By dimension: the point of a cell, and its colour. Up to Blender 4 they are those of the language's hash.
POINTS = {
    1: "at = vector(b_hash1(cell[0]), 0, 0);",
    2: "at = b_cell2(cell);",
    3: "at = b_cell3(cell);",
    4: "b_cell4(cell, cell_w, at, at_w);",
}
COLORS = {
    1: "b_hash1c(cell[0])",
    2: "color(b_cell3(vector(cell[0], cell[1], 0)))",
    3: "color(b_cell3(cell))",
    4: "b_cell4c(cell, cell_w)",
}
OLD_POINTS = {
    **POINTS,
    2: "at = b_hash2v(cell[0], cell[1]);",
    3: "at = b_hash3v(cell);",
    4: "b_hash4v(cell, cell_w, at, at_w);",
}
OLD_COLORS = {**COLORS, 2: "b_hash2c(cell[0], cell[1])", 3: "b_hash3c(cell)", 4: "b_hash4c(cell, cell_w)"}


def loops(dimensions, reach, body):
    """Nested loops over the neighbours of a cell; `o` is the way there, `ow` that along w."""
    lines, names = [], ["x", "y", "z", "q"]
    order = [3, 2, 1, 0][-dimensions:] if dimensions < 4 else [3, 2, 1, 0]
    for axis in order:
        lines.append(f"for (int {names[axis]} = -{reach}; {names[axis]} <= {reach}; {names[axis]} += 1)")
    parts = [names[axis] if axis < dimensions else "0" for axis in range(3)]
    lines.append("{")
    lines.append(f"vector o = vector({', '.join(parts)}); float ow = {'q' if dimensions == 4 else '0'};")
    lines.append(body)
    lines.append("}")
    return "\n        ".join(lines)


START = """
    vector cell = floor(p);
    float cell_w = floor(w);
    vector local = p - cell;
    float local_w = w - cell_w;
"""


def octave(dimensions, feature):
    """The body of one octave: distance, color, where, where_w from p and w."""
    d = dimensions
    get = f"vector q1; float q1w; b_cells{d}_point(cell + o, cell_w + ow, randomness, q1, q1w); q1 += o; q1w += ow;"
    length = f"b_cells{d}_length(q1 - local, q1w - local_w, metric, exponent)"
    if feature in {"F1", "F2"}:
        body = get + f"""
            float l = {length};
            if (l < best) {{
                second = best; second_o = best_o; second_ow = best_ow; second_q = best_q; second_qw = best_qw;
                best = l; best_o = o; best_ow = ow; best_q = q1; best_qw = q1w;
            }} else if (l < second) {{
                second = l; second_o = o; second_ow = ow; second_q = q1; second_qw = q1w;
            }}"""
        which = "best" if feature == "F1" else "second"
        return START + f"""
    float best = 1e30, second = 1e30, best_ow = 0, best_qw = 0, second_ow = 0, second_qw = 0;
    vector best_o = vector(0), best_q = vector(0), second_o = vector(0), second_q = vector(0);
        {loops(d, 1, body)}
    distance = {which};
    tint = b_cells{d}_color(cell + {which}_o, cell_w + {which}_ow);
    where = {which}_q + cell;
    where_w = {which}_qw + cell_w;
"""
    if feature == "SMOOTH_F1":
        body = get + f"""
            float l = {length};
            float h = is_first ? 1.0 : smoothstep(0.0, 1.0, 0.5 + 0.5 * (smoothed - l) / smoothness);
            is_first = 0;
            float correction = smoothness * h * (1.0 - h);
            smoothed = mix(smoothed, l, h) - correction;
            correction /= 1.0 + 3.0 * smoothness;
            color own = b_cells{d}_color(cell + o, cell_w + ow);
            smooth_color = mix(smooth_color, own, h) - color(correction);
            smooth_at = mix(smooth_at, q1, h) - vector(correction);
            smooth_at_w = mix(smooth_at_w, q1w, h) - correction;"""
        return START + f"""
    float smoothed = 0, smooth_at_w = 0;
    color smooth_color = color(0);
    vector smooth_at = vector(0);
    int is_first = 1;
        {loops(d, 2, body)}
    distance = smoothed;
    tint = smooth_color;
    where = smooth_at + cell;
    where_w = smooth_at_w + cell_w;
"""
    nearest = get + """
            vector v = q1 - local; float vw = q1w - local_w;
            float l = dot(v, v) + vw * vw;
            if (l < best) { best = l; best_v = v; best_vw = vw; best_o = o; best_ow = ow; best_q = q1; best_qw = q1w; }"""
    first = START + f"""
    float best = 1e30, best_vw = 0, best_ow = 0, best_qw = 0;
    vector best_v = vector(0), best_o = vector(0), best_q = vector(0);
        {loops(d, 1, nearest)}
    tint = color(0); where = vector(0); where_w = 0.0;
"""
    if feature == "DISTANCE_TO_EDGE":
        edges = get + """
            vector v = q1 - local, across = v - best_v; float vw = q1w - local_w, across_w = vw - best_vw;
            float l = dot(across, across) + across_w * across_w;
            if (l > 0.0001) {
                float s = sqrt(l);
                edge = min(edge, (dot(0.5 * (best_v + v), across) + 0.5 * (best_vw + vw) * across_w) / s);
            }"""
        return first + f"""
    float edge = 1e30;
        {loops(d, 1, edges)}
    distance = edge;
"""
    # The radius of the sphere around a point that touches that of its neighbour.
    neighbours = """
            if (o == vector(0) && ow == 0.0)
                continue;
            vector c = cell + best_o; float cw = cell_w + best_ow;
            vector q1; float q1w;
            b_cells%d_point(c + o, cw + ow, randomness, q1, q1w);
            vector v = q1 + o + best_o - best_q; float vw = q1w + ow + best_ow - best_qw;
            float l = dot(v, v) + vw * vw;
            if (l < radius) radius = l;""" % d
    return first + f"""
    float radius = 1e30;
        {loops(d, 1, neighbours)}
    distance = 0.5 * sqrt(radius);
"""


WHOLE = """
void b_cells{d}_{feature}(vector given, float given_w, float detail, float roughness, float lacunarity, float smoothness, float exponent,
    float randomness, string metric, int is_normalized, output float result, output color color_result, output vector at_result,
    output float at_w_result)
{{
    float amplitude = 1.0, most = 0.0, scale = 1.0;
    result = {start};
    color_result = color(0);
    at_result = vector(0);
    at_w_result = 0.0;
    int is_plain = (detail == 0.0 || roughness == 0.0), last = {last};
    for (int i = 0; i <= last; i += 1) {{
        float distance, where_w;
        color tint;
        vector where;
        b_cells{d}_{feature}_octave(given * scale, given_w * scale, smoothness, exponent, randomness, metric, distance, tint, where, where_w);
        if (is_plain) {{
            most = {plain_most};
            result = distance;
            color_result = tint;
            at_result = where;
            at_w_result = where_w;
            break;
        }}
        float share = (i <= detail) ? 1.0 : detail - floor(detail);
        {accumulate}
        scale *= lacunarity;
        amplitude *= roughness;
    }}
    if (is_normalized) {{
        {normalize}
    }}
}}
"""

SUM = """
        most += share * amplitude;
        result += share * distance * amplitude;
        color_result += share * tint * amplitude;
        at_result = mix(at_result, mix(at_result, where / scale, amplitude), share);
        at_w_result = mix(at_w_result, mix(at_w_result, where_w / scale, amplitude), share);"""
EDGE = """
        most = mix(most, mix(most, (0.5 + 0.5 * randomness) / scale, amplitude), share);
        result = mix(result, mix(result, min(result, distance / scale), amplitude), share);"""


def is_old():
    import bpy

    return bpy.app.version < (5, 0, 0)


def functions(code, dimensions, feature):
    """Adds the functions of a feature to the shader; the name to call."""
    d = dimensions
    name = f"b_cells{d}_{feature}"
    if name in code.extra:
        return name
    if f"cells{d}" not in code.extra:
        code.extra[f"cells{d}"] = HEAD.format(
            d=d, point=(OLD_POINTS if is_old() else POINTS)[d], color=(OLD_COLORS if is_old() else COLORS)[d]
        )
    text = (
        f"void {name}_octave(vector p, float w, float smoothness, float exponent, float randomness, string metric, "
        "output float distance, output color tint, output vector where, output float where_w)\n{\n" + octave(d, feature) + "}\n"
    )
    ones = {1: "vector(1, 0, 0), 0.0", 2: "vector(1, 1, 0), 0.0", 3: "vector(1), 0.0", 4: "vector(1), 1.0"}[d]
    longest = f"b_cells{d}_length({ones}, metric, exponent) * (0.5 + 0.5 * randomness)"
    times = "2.0 * " if feature == "F2" else ""
    is_edge = feature == "DISTANCE_TO_EDGE"
    text += WHOLE.format(
        d=d,
        feature=feature,
        start="8.0" if is_edge else "0.0",
        last="0" if feature == "N_SPHERE_RADIUS" else "int(ceil(detail))",
        plain_most="0.5 + 0.5 * randomness" if is_edge else "1.0",
        accumulate=EDGE if is_edge else SUM,
        normalize="result /= most;" if is_edge else f"result /= most * {times}{longest};\n        color_result /= most;",
    )
    code.extra[name] = text
    return name


