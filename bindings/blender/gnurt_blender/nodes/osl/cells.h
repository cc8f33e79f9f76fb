// SPDX-License-Identifier: GPL-3.0-or-later
// Random numbers of cells by integers [Jarzynski and Olano, Hash functions for GPU rendering, 2020], with shifts that keep the sign, as
// pictures of Cycles 5.0 show them.
float b_unit_of(int x) { return float(x & 2147483647) / 2147483647.0; }
vector b_cell2(vector c)
{
    int x = int(c[0]) * 1664525 + 1013904223, y = int(c[1]) * 1664525 + 1013904223;
    x += y * 1664525;
    y += x * 1664525;
    x = x ^ (x >> 16);
    y = y ^ (y >> 16);
    x += y * 1664525;
    y += x * 1664525;
    return vector(b_unit_of(x), b_unit_of(y), 0);
}
vector b_cell3(vector c)
{
    int x = int(c[0]) * 1664525 + 1013904223, y = int(c[1]) * 1664525 + 1013904223, z = int(c[2]) * 1664525 + 1013904223;
    x += y * z;
    y += z * x;
    z += x * y;
    x = x ^ (x >> 16);
    y = y ^ (y >> 16);
    z = z ^ (z >> 16);
    x += y * z;
    y += z * x;
    z += x * y;
    return vector(b_unit_of(x), b_unit_of(y), b_unit_of(z));
}
void b_cell4(vector c, float cw, output vector at, output float at_w)
{
    int x = int(c[0]) * 1664525 + 1013904223, y = int(c[1]) * 1664525 + 1013904223, z = int(c[2]) * 1664525 + 1013904223;
    int w = int(cw) * 1664525 + 1013904223;
    x += y * w;
    y += z * x;
    z += x * y;
    w += y * z;
    x = x ^ (x >> 16);
    y = y ^ (y >> 16);
    z = z ^ (z >> 16);
    w = w ^ (w >> 16);
    x += y * w;
    y += z * x;
    z += x * y;
    w += y * z;
    at = vector(b_unit_of(x), b_unit_of(y), b_unit_of(z));
    at_w = b_unit_of(w);
}
color b_cell4c(vector c, float cw)
{
    vector at;
    float at_w;
    b_cell4(c, cw, at, at_w);
    return color(at[0], at[1], at[2]);
}
