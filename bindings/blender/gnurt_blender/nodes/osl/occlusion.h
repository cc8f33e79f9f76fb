// SPDX-License-Identifier: GPL-3.0-or-later
// The share of directions, weighted by the cosine, in which nothing is nearer than a distance. Directions are
// a lattice over the disc below, even along and around, moved by random numbers as a whole: half the noise of random points in strata.
float b_occlusion(point p, vector n, float far, int samples, int inside, string only)
{
    vector axis = inside ? -n : n;
    vector side = normalize(cross(axis, (fabs(axis[0]) > 0.9) ? vector(0, 1, 0) : vector(1, 0, 0)));
    vector other = cross(axis, side);
    float shift = hashnoise(p, -2.0), turn = hashnoise(p, -1.0);
    int hits = 0;
    for (int i = 0; i < samples; ++i) {
        float r = sqrt((float(i) + shift) / float(samples));
        // Turned by the golden angle from one to the next.
        float a = M_2PI * (turn + 0.618034 * float(i));
        vector d = (r * cos(a)) * side + (r * sin(a)) * other + sqrt(max(1.0 - r * r, 0.0)) * axis;
        hits += trace(p, d, "maxdist", far, "traceset", only);
    }
    return 1.0 - float(hits) / float(samples);
}
