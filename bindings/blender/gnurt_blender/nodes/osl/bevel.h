// SPDX-License-Identifier: GPL-3.0-or-later
// The mean normal of the surface within a radius, weighted by the cube of what is left of the radius, as Cycles' pictures show.
// Chords through the ball around the point find the surface, along three axes [King et al., BSSRDF Importance Sampling, 2013].
// Density of a distance from an axis, by that cube on a disc.
float b_bevel_density(float distance, float radius)
{
    float x = max(1.0 - distance / radius, 0.0);
    return x * x * x * (10.0 / M_PI) / (radius * radius);
}
// The share of the radius under which this share of samples are.
float b_bevel_distance(float share)
{
    float x = 0.3;
    for (int i = 0; i < 6; ++i) {
        float y = 1.0 - x;
        float cube = y * y * y;
        x = clamp(x + (cube * y * (1.0 + 4.0 * x) - share) / max(20.0 * x * cube, 1e-4), 0.001, 0.999);
    }
    return x;
}
float b_bevel_off_axis(vector way, vector axis) { return length(way - dot(way, axis) * axis); }
vector b_bevel(point p, vector n, vector ng, int is_back, float radius, int samples, string only)
{
    if (radius <= 0.0)
        return n;
    vector axes[3];
    axes[0] = ng;
    axes[1] = normalize(cross(ng, (fabs(ng[0]) > 0.9) ? vector(0, 1, 0) : vector(1, 0, 0)));
    axes[2] = cross(ng, axes[1]);
    vector sum = 0;
    for (int i = 0; i < samples; ++i) {
        float pick = (float(i) + hashnoise(p, float(4 * i))) / float(samples);
        int k = (pick < 0.5) ? 0 : ((pick < 0.75) ? 1 : 2);
        vector axis = axes[k], side = axes[(k + 1) % 3], other = axes[(k + 2) % 3];
        float r = radius * b_bevel_distance(hashnoise(p, float(4 * i + 1)));
        float a = M_2PI * hashnoise(p, float(4 * i + 2));
        float reach = sqrt(max(radius * radius - r * r, 0.0));
        point start = p + (r * cos(a)) * side + (r * sin(a)) * other + reach * axis;
        float near = 0.0;
        for (int hit = 0; hit < 6; ++hit) {
            if (trace(start, -axis, "mindist", near, "maxdist", 2.0 * reach, "traceset", only) == 0)
                break;
            point there = 0;
            normal smooth = 0, flat = 0;
            float far = 0.0;
            int back = 0;
            getmessage("trace", "hitdist", far);
            getmessage("trace", "P", there);
            getmessage("trace", "N", smooth);
            getmessage("trace", "Ng", flat);
            getmessage("trace", "backfacing", back);
            vector way = there - p;
            float density = 0.5 * b_bevel_density(b_bevel_off_axis(way, axes[0]), radius) * fabs(dot(flat, axes[0]))
                + 0.25 * b_bevel_density(b_bevel_off_axis(way, axes[1]), radius) * fabs(dot(flat, axes[1]))
                + 0.25 * b_bevel_density(b_bevel_off_axis(way, axes[2]), radius) * fabs(dot(flat, axes[2]));
            if (density > 0.0)
                sum += (back ? -1.0 : 1.0) * (b_bevel_density(length(way), radius) / density) * smooth;
            near = far + 1e-4 * radius + 1e-6;
        }
    }
    if (is_back)
        sum = -sum;
    return (dot(sum, sum) > 0.0) ? normalize(sum) : n;
}
