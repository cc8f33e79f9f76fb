// SPDX-License-Identifier: GPL-3.0-or-later
// Random numbers from numbers: those of the language's `hashnoise`, which Cycles' pictures show.
float b_hash1(float x) { return hashnoise(x); }
float b_hash2(float x, float y) { return hashnoise(x, y); }
float b_hash3(vector p) { return hashnoise(point(p)); }
float b_hash4(vector p, float w) { return hashnoise(point(p), w); }
color b_hash1c(float x) { return color(hashnoise(x), hashnoise(x, 1.0), hashnoise(x, 2.0)); }
color b_hash2c(float x, float y) { return color(hashnoise(x, y), hashnoise(point(x, y, 1.0)), hashnoise(point(x, y, 2.0))); }
color b_hash3c(vector p) { return color(hashnoise(point(p)), hashnoise(point(p), 1.0), hashnoise(point(p), 2.0)); }
color b_hash4c(vector p, float w)
{
    return color(hashnoise(point(p), w), hashnoise(point(p[2], p[0], w), p[1]), hashnoise(point(w, p[2], p[1]), p[0]));
}
vector b_hash2v(float x, float y) { return vector(hashnoise(x, y), hashnoise(point(x, y, 1.0)), 0); }
vector b_hash3v(vector p) { return vector(b_hash3c(p)); }
void b_hash4v(vector p, float w, output vector at, output float at_w)
{
    at = vector(hashnoise(point(p), w), hashnoise(point(w, p[0], p[1]), p[2]), hashnoise(point(p[2], w, p[0]), p[1]));
    at_w = hashnoise(point(p[1], p[2], w), p[0]);
}
