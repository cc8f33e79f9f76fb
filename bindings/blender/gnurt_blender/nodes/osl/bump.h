// SPDX-License-Identifier: GPL-3.0-or-later
// Normals from heights [Mikkelsen, Bump mapping unparametrized surfaces, 2010] and from maps.
vector b_bump(vector n, float height, float hx, float hy, float distance, float strength)
{
    vector px = Dx(P), py = Dy(P);
    vector rx = cross(py, n), ry = cross(n, px);
    float det = dot(px, rx);
    vector gradient = hx * rx + hy * ry;
    float size = fabs(det);
    vector turned = size * n - distance * sign(det) * gradient;
    float l = length(turned);
    if (l <= 0.0 || size <= 0.0)
        return n;
    float s = max(strength, 0.0);
    vector mixed = s * (turned / l) + (1.0 - s) * n;
    float m = length(mixed);
    return (m > 0.0) ? mixed / m : n;
}
// `tangent` and `smooth` are on the side of the mesh's normal.
vector b_normal_map(vector own, float strength, vector tangent, float side, vector smooth)
{
    vector t = tangent;
    if (dot(t, t) == 0.0)
        return smooth;
    vector b = side * cross(smooth, t);
    vector scaled = vector(own[0] * strength, own[1] * strength, mix(1.0, own[2], clamp(strength, 0.0, 1.0)));
    vector made = scaled[0] * t + scaled[1] * b + scaled[2] * smooth;
    float l = length(made);
    return (l > 0.0) ? made / l : smooth;
}
// The normal of a surface of the normal n whose points move by offsets that change by ox and oy.
vector b_relief(vector n, vector ox, vector oy)
{
    vector px = Dx(P), py = Dy(P);
    vector before = cross(px, py);
    vector after = cross(px + ox, py + oy);
    float l = length(after);
    if (dot(before, before) <= 0.0 || l <= 0.0)
        return n;
    return sign(dot(before, n)) * after / l;
}
