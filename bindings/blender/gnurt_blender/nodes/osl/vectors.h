// SPDX-License-Identifier: GPL-3.0-or-later
// Vectors: division that gives 0 for 0, and rotations by Euler angles about x, then y, then z.
vector b_unit(vector v)
{
    float l = length(v);
    return (l > 0.0) ? v / l : vector(0);
}
float b_over1(float a, float b) { return (b != 0.0) ? a / b : 0.0; }
vector b_over(vector a, vector b) { return vector(b_over1(a[0], b[0]), b_over1(a[1], b[1]), b_over1(a[2], b[2])); }
vector b_project(vector a, vector b)
{
    float l = dot(b, b);
    return (l != 0.0) ? (dot(a, b) / l) * b : vector(0);
}
vector b_about_x(vector v, float s, float c) { return vector(v[0], c * v[1] - s * v[2], s * v[1] + c * v[2]); }
vector b_about_y(vector v, float s, float c) { return vector(c * v[0] + s * v[2], v[1], c * v[2] - s * v[0]); }
vector b_about_z(vector v, float s, float c) { return vector(c * v[0] - s * v[1], s * v[0] + c * v[1], v[2]); }
vector b_turned(vector v, vector angles)
{
    vector x = b_about_x(v, sin(angles[0]), cos(angles[0]));
    vector y = b_about_y(x, sin(angles[1]), cos(angles[1]));
    return b_about_z(y, sin(angles[2]), cos(angles[2]));
}
vector b_turned_back(vector v, vector angles)
{
    vector z = b_about_z(v, -sin(angles[2]), cos(angles[2]));
    vector y = b_about_y(z, -sin(angles[1]), cos(angles[1]));
    return b_about_x(y, -sin(angles[0]), cos(angles[0]));
}
vector b_around(vector v, vector axis, float angle)
{
    float l = length(axis);
    if (l == 0.0)
        return v;
    vector k = axis / l;
    float s = sin(angle), c = cos(angle);
    return v * c + cross(k, v) * s + k * (dot(k, v) * (1.0 - c));
}
