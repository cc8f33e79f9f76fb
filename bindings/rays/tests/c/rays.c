/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What gnurt/rays.h does, checked by the definition. */
#include <gnurt/rays.h>

#include "check.h"

enum { TRIANGLES = 200, RAYS = 500 };

/* Rows with gaps: a vertex is three floats and something else, a ray is one struct. */
struct vertex {
    float at[3], other;
};
struct asked {
    double org[3];
    float dir[3], far;
    uint32_t mask;
};
struct found {
    float t, u, v, normal[3];
    uint32_t prim, geom, inst;
};

static struct vertex soup[3 * TRIANGLES];
static uint64_t soup_indices[TRIANGLES][3];
static struct asked asked[RAYS];
static struct found found[RAYS];

static gnurt_array rows(const void *data, size_t count, size_t stride, enum gnurt_type type)
{
    gnurt_array array = { data, count, stride, type };
    return array;
}

#define OK(call) CHECK((call) == 0, "%s", gnurt_last_error())
#define REFUSED(call, word) CHECK((call) == -1 && strstr(gnurt_last_error(), word), "%s", gnurt_last_error())

static const double identity[12] = { 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0 };

static gnurt_hits places(struct found *to)
{
    gnurt_hits hits = { sizeof *to, &to->t, &to->u, &to->v, &to->prim, &to->geom, &to->inst, to->normal };
    return hits;
}

static gnurt_rays rays(size_t count)
{
    gnurt_rays all;
    memset(&all, 0, sizeof all);
    all.count = count;
    all.origins = rows(asked->org, count, sizeof *asked, GNURT_F64);
    all.directions = rows(asked->dir, count, sizeof *asked, GNURT_F32);
    all.t_far = rows(&asked->far, count, sizeof *asked, GNURT_F32);
    all.masks = rows(&asked->mask, count, sizeof *asked, GNURT_U32);
    return all;
}

static gnurt_scene *new_soup(void)
{
    for (int i = 0; i < TRIANGLES; i++) {
        float at[3] = { number(), number(), number() };
        for (int corner = 0; corner < 3; corner++) {
            for (int k = 0; k < 3; k++)
                soup[3 * i + corner].at[k] = at[k] + 0.3f * (number() - 0.5f);
            soup[3 * i + corner].other = NAN;
            soup_indices[i][corner] = 3 * i + corner;
        }
    }
    for (int i = 0; i < RAYS; i++) {
        float org[3] = { 3 * number() - 1, 3 * number() - 1, -1 };
        for (int k = 0; k < 3; k++) {
            asked[i].org[k] = org[k];
            asked[i].dir[k] = number() - org[k];
        }
        asked[i].far = i % 3 ? INFINITY : 1;
        asked[i].mask = i % 10 ? 2 : 4;
    }
    gnurt_scene *scene = gnurt_scene_new();
    uint32_t id = 9;
    OK(gnurt_add_triangles(scene, rows(soup, 3 * TRIANGLES, sizeof *soup, GNURT_F32),
                           rows(soup_indices, TRIANGLES, 0, GNURT_U64), 3, &id));
    CHECK(id == 0, "ids are given from 0 on");
    OK(gnurt_commit(scene));
    return scene;
}

static double meets_soup(int ray, int p)
{
    float org[3] = { asked[ray].org[0], asked[ray].org[1], asked[ray].org[2] };
    double t = meets(soup[3 * p].at, soup[3 * p + 1].at, soup[3 * p + 2].at, org, asked[ray].dir);
    return t >= 0 && t <= asked[ray].far && (asked[ray].mask & 3) ? t : INFINITY;
}

/* Lets even triangles pass, and counts how large its batches are. */
static size_t calls, asked_for;
static void even(void *user, size_t count, const gnurt_candidate *candidates, int *accept)
{
    CHECK(user == &calls && count > 0, "its pointer");
    calls++, asked_for += count;
    for (size_t i = 0; i < count; i++) {
        CHECK(accept[i] == 1 && candidates[i].ray < RAYS && candidates[i].geom_id == 0, "a candidate");
        accept[i] = candidates[i].prim_id % 2 == 0;
    }
}

static void triangles(void)
{
    gnurt_scene *scene = new_soup();
    gnurt_rays all = rays(RAYS);
    gnurt_hits to = places(found);
    uint8_t occluded[RAYS];
    size_t ends[RAYS];
    gnurt_query filtered = { 1, 0, even, &calls };
    for (int pass = 0; pass < 4; pass++) {
        /* All processors, one thread that knows of coherence, and a filter; then a tree of another kind. */
        gnurt_query query = { pass == 1, pass == 1, NULL, NULL };
        gnurt_query *how = pass == 2 ? &filtered : &query;
        if (pass == 3) {
            gnurt_build build = { 1, 1, 0, 0, 1, 0 };
            OK(gnurt_scene_options(scene, &build));
            OK(gnurt_commit(scene));
        }
        memset(found, 0xff, sizeof found);
        OK(gnurt_intersect(scene, &all, how, &to));
        OK(gnurt_occluded(scene, &all, how, occluded));
        static struct found each[64 * RAYS];
        gnurt_hits into = places(each);
        OK(gnurt_all_hits(scene, &all, how, 0, ends, 64 * RAYS, &into));
        int hits = 0;
        for (int i = 0; i < RAYS; i++) {
            double best = INFINITY;
            int prim = -1, count = 0;
            for (int p = 0; p < TRIANGLES; p += pass == 2 ? 2 : 1) {
                double t = meets_soup(i, p);
                count += t < INFINITY;
                if (t < best)
                    best = t, prim = p;
            }
            CHECK((int)found[i].prim == prim && occluded[i] == (prim >= 0), "pass %d, ray %d: %u, not %d", pass, i,
                  found[i].prim, prim);
            CHECK((int)(ends[i] - (i ? ends[i - 1] : 0)) == count, "pass %d, ray %d: %d hits", pass, i, count);
            for (size_t k = i ? ends[i - 1] + 1 : 1; k < ends[i]; k++)
                CHECK(each[k].t >= each[k - 1].t, "hits are in order");
            CHECK(found[i].inst == GNURT_NONE && found[i].geom == (prim < 0 ? GNURT_NONE : 0), "ids of ray %d", i);
            if (prim < 0) {
                CHECK(found[i].t == INFINITY && found[i].normal[0] == 0, "a miss");
                continue;
            }
            hits++;
            CHECK(fabs(found[i].t - best) < 1e-5 * best, "ray %d: %g, not %g", i, found[i].t, best);
            double e1[3], e2[3], n[3];
            for (int k = 0; k < 3; k++) {
                e1[k] = soup[3 * prim + 1].at[k] - soup[3 * prim].at[k];
                e2[k] = soup[3 * prim + 2].at[k] - soup[3 * prim].at[k];
            }
            cross(e1, e2, n);
            double along = (n[0] * found[i].normal[0] + n[1] * found[i].normal[1] + n[2] * found[i].normal[2]);
            CHECK(fabs(along - sqrt(dot(n, n))) < 1e-6, "normal of ray %d", i);
        }
        CHECK(hits > RAYS / 8 && hits < RAYS, "%d of %d rays hit", hits, RAYS);
    }
    CHECK(calls < 100 && asked_for > 100, "filters get batches: %zu calls for %zu hits", calls, asked_for);
    size_t few[RAYS];
    OK(gnurt_all_hits(scene, &all, NULL, 1, few, 0, NULL));
    CHECK(few[RAYS - 1] < ends[RAYS - 1], "at most one of each, and only counted");
    gnurt_facts facts;
    OK(gnurt_scene_facts(scene, &facts));
    CHECK(facts.primitives == TRIANGLES && facts.left_out == 0 && facts.bytes > 1000, "facts");
    gnurt_scene_free(scene);
}

static void ball_bounds(void *user, uint32_t first, uint32_t count, float (*boxes)[6])
{
    const float *radii = user;
    for (uint32_t i = 0; i < count; i++)
        for (int k = 0; k < 6; k++)
            boxes[i][k] = (k < 3 ? -1 : 1) * radii[first + i] + (k % 3 == 0 ? 10.0f * (first + i) : 0);
}

static void ball_intersect(void *user, size_t count, const gnurt_user_ray *all, gnurt_user_hit *hits)
{
    for (size_t i = 0; i < count; i++) {
        const gnurt_user_ray *r = &all[i];
        float radius = ((const float *)user)[r->prim_id], o[3] = { r->org[0] - 10.0f * r->prim_id, r->org[1], r->org[2] };
        float a = 0, h = 0, c = -radius * radius;
        for (int k = 0; k < 3; k++)
            a += r->dir[k] * r->dir[k], h += o[k] * r->dir[k], c += o[k] * o[k];
        float d = h * h - a * c;
        if (d >= 0)
            hits[i].t = (-h - sqrtf(d)) / a, hits[i].u = 0.5f, hits[i].v = 0.25f;
    }
}

/* A strand of two straight segments, a bent one of each basis between the same points, and discs. */
static void strands(void)
{
    static const float strand[3][4] = { { -2, 0, 0, 0.5f }, { 0, 0, 0, 0.5f }, { 2, 0, 0, 0.5f } };
    static const uint32_t firsts[2] = { 0, 1 };
    static const float normals[3][3] = { { 0, 0, -1 }, { 0, 0, -1 }, { 0, 0, -1 } };
    const gnurt_array none = { NULL, 0, 0, GNURT_F32 };
    float from[3][3] = { { -1, 0.3f, -7 }, { 1, 0, -7 }, { 0, 0.6f, -7 } }, dir[3] = { 0, 0, 1 };
    gnurt_rays all;
    memset(&all, 0, sizeof all);
    all.count = 3;
    all.origins = rows(from, 3, 0, GNURT_F32);
    all.directions = rows(dir, 1, 0, GNURT_F32);
    struct found got[3];
    gnurt_hits to = places(got);
    for (int form = GNURT_FLAT; form <= GNURT_ORIENTED; form++) {
        gnurt_curves curves = { GNURT_LINEAR, (enum gnurt_form)form, rows(strand, 3, 0, GNURT_F32), rows(firsts, 2, 0, GNURT_U32), none, none, none };
        gnurt_scene *scene = gnurt_scene_new();
        if (form == GNURT_ORIENTED) {
            REFUSED(gnurt_add_curves(scene, &curves, 1, NULL), "normals: 0 rows; 3 are expected");
            curves.normals = rows(normals, 3, 0, GNURT_F32);
        }
        uint32_t id;
        OK(gnurt_add_curves(scene, &curves, 1, &id));
        OK(gnurt_commit(scene));
        OK(gnurt_intersect(scene, &all, NULL, &to));
        float depth = form == GNURT_ROUND ? 7 - 0.4f : 7;
        CHECK(fabsf(got[0].t - depth) < 1e-5f && got[0].prim == 0 && got[0].geom == id, "%d: %g %u", form, got[0].t, got[0].prim);
        CHECK(fabsf(got[0].u - 0.5f) < 1e-5f && got[1].prim == 1, "%d: along: %g", form, got[0].u);
        CHECK(got[2].t == INFINITY, "%d: beside it", form);
        float moved[3][4];
        memcpy(moved, strand, sizeof moved);
        for (int i = 0; i < 3; i++)
            moved[i][2] = 3;
        REFUSED(gnurt_set_positions(scene, id, rows(moved, 2, 0, GNURT_F32)), "positions: 2 for 3 vertices");
        OK(gnurt_set_positions(scene, id, rows(moved, 3, 0, GNURT_F32)));
        OK(gnurt_commit(scene));
        OK(gnurt_intersect(scene, &all, NULL, &to));
        CHECK(fabsf(got[0].t - depth - 3) < 1e-5f, "%d: it has moved: %g", form, got[0].t);
        gnurt_scene_free(scene);
    }
    /* The line from -1 to 1 in the form of each cubic. */
    static const float lines[4][4][4] = {
        { { -1, 0, 0, 0.5f }, { -1 / 3.f, 0, 0, 0.5f }, { 1 / 3.f, 0, 0, 0.5f }, { 1, 0, 0, 0.5f } },
        { { -3, 0, 0, 0.5f }, { -1, 0, 0, 0.5f }, { 1, 0, 0, 0.5f }, { 3, 0, 0, 0.5f } },
        { { -3, 0, 0, 0.5f }, { -1, 0, 0, 0.5f }, { 1, 0, 0, 0.5f }, { 3, 0, 0, 0.5f } },
        { { -1, 0, 0, 0.5f }, { 1, 0, 0, 0.5f }, { 0, 0, 0, 0 }, { 0, 0, 0, 0 } },
    };
    static const float tangents[4][4] = { { 2, 0, 0, 0 }, { 2, 0, 0, 0 }, { 0, 0, 0, 0 }, { 0, 0, 0, 0 } };
    from[0][0] = 0.5f;
    for (int basis = GNURT_BEZIER; basis <= GNURT_HERMITE; basis++) {
        size_t count = basis == GNURT_HERMITE ? 2 : 4;
        gnurt_curves curves = { (enum gnurt_basis)basis, GNURT_ROUND, rows(lines[basis - 1], count, 0, GNURT_F32), rows(firsts, 1, 0, GNURT_U32), none, none, none };
        if (basis == GNURT_HERMITE)
            curves.tangents = rows(tangents, count, 0, GNURT_F32);
        gnurt_scene *scene = gnurt_scene_new();
        OK(gnurt_add_curves(scene, &curves, 1, NULL));
        OK(gnurt_commit(scene));
        OK(gnurt_intersect(scene, &all, NULL, &to));
        CHECK(fabsf(got[0].t - 6.6f) < 1e-4f && fabsf(got[0].u - 0.75f) < 1e-4f, "%d: %g at %g", basis, got[0].t, got[0].u);
        gnurt_scene_free(scene);
    }
    static const float centers[1][3] = { { 0, 0, 0 } }, radius[1] = { 0.55f }, tilted[1][3] = { { 0, 1, -1 } };
    from[0][0] = 0, from[1][0] = 0.5f;
    for (int has_normal = 0; has_normal < 2; has_normal++) {
        gnurt_scene *scene = gnurt_scene_new();
        REFUSED(gnurt_add_discs(scene, rows(centers, 1, 0, GNURT_F32), none, none, 1, NULL), "radii: 0 for 1 centres");
        OK(gnurt_add_discs(scene, rows(centers, 1, 0, GNURT_F32), rows(radius, 1, 0, GNURT_F32),
                           has_normal ? rows(tilted, 1, 0, GNURT_F32) : none, 1, NULL));
        OK(gnurt_commit(scene));
        OK(gnurt_intersect(scene, &all, NULL, &to));
        CHECK(fabsf(got[0].t - (has_normal ? 7.3f : 7)) < 1e-5f && got[1].t == 7 && got[2].t == INFINITY, "%d: discs: %g %g %g", has_normal,
              got[0].t, got[1].t, got[2].t);
        gnurt_scene_free(scene);
    }
    gnurt_scene *scene = gnurt_scene_new();
    REFUSED(gnurt_add_curves(scene, NULL, 1, NULL), "curves: a null pointer");
    gnurt_scene_free(scene);
}

/* A quad, spheres and balls of the program's, in a scene, in another, in a third; then edits. */
static void scenes_in_scenes(void)
{
    static const double corners[4][3] = { { -2, -2, 5 }, { 22, -2, 5 }, { 22, 2, 5 }, { -2, 2, 5 } };
    static const uint32_t quad[4] = { 0, 1, 2, 3 };
    static float centers[2][3] = { { 0, 0, 0 }, { 10, 0, 0 } };
    static const float radii[2] = { 1, 2 };
    gnurt_scene *scene[3] = { NULL, gnurt_scene_new(), gnurt_scene_new() };
    for (int user = 0; user < 2; user++) {
        gnurt_user balls = { (void *)radii, 2, ball_bounds, ball_intersect };
        uint32_t ids[3];
        gnurt_scene *inner = scene[0] = gnurt_scene_new();
        OK(gnurt_add_quads(inner, rows(corners, 4, 0, GNURT_F64), rows(quad, 1, 0, GNURT_U32), 1, &ids[0]));
        if (user)
            OK(gnurt_add_user(inner, &balls, 1, &ids[1]));
        else
            OK(gnurt_add_spheres(inner, rows(centers, 2, 0, GNURT_F32), rows(radii, 2, 0, GNURT_F32), 1, &ids[1]));
        OK(gnurt_commit(inner));
        double place[12], far[12];
        memcpy(place, identity, sizeof place);
        memcpy(far, identity, sizeof far);
        place[9] = 100, far[10] = 1e7;
        gnurt_scene *middle = gnurt_scene_new(), *outer = gnurt_scene_new();
        OK(gnurt_add_instance(middle, inner, place, 3, &ids[2]));
        OK(gnurt_commit(middle));
        uint32_t shown, nothing;
        OK(gnurt_add_spheres(outer, rows(centers, 1, 0, GNURT_F32), rows(radii, 1, 0, GNURT_F32), 1, &nothing));
        OK(gnurt_add_instance(outer, middle, far, 1, &shown));
        OK(gnurt_commit(outer));
        double from[3][3] = { { 110, 1e7, -7 }, { 105, 1e7, -7 }, { 50, 1e7, -7 } };
        float dir[3] = { 0, 0, 1 };
        gnurt_rays all;
        memset(&all, 0, sizeof all);
        all.count = 3;
        all.origins = rows(from, 3, 0, GNURT_F64);
        all.directions = rows(dir, 1, 0, GNURT_F32);
        struct found got[3];
        gnurt_hits to = places(got);
        OK(gnurt_intersect(outer, &all, NULL, &to));
        CHECK(got[0].t == 5 && got[0].geom == ids[1] && got[0].prim == 1 && got[0].inst == shown, "%d: %g %u %u %u", user,
              got[0].t, got[0].geom, got[0].prim, got[0].inst);
        CHECK(got[1].t == 12 && got[1].geom == ids[0] && got[1].inst == shown && fabsf(got[1].normal[2]) == 1, "%d: %g %u", user,
              got[1].t, got[1].geom);
        CHECK(got[2].t == INFINITY && got[2].inst == GNURT_NONE, "%d: nothing there", user);
        if (user == 0)
            CHECK(got[0].normal[2] == -1, "a sphere's normal: %g", got[0].normal[2]);
        uint32_t paths[3][3];
        OK(gnurt_intersect_paths(outer, &all, NULL, &to, 3, paths[0]));
        CHECK(paths[0][0] == shown && paths[0][1] == ids[2] && paths[0][2] == GNURT_NONE && paths[2][0] == GNURT_NONE,
              "%d: the way is %u %u %u", user, paths[0][0], paths[0][1], paths[0][2]);
        OK(gnurt_intersect_paths(outer, &all, NULL, &to, 1, paths[0]));
        CHECK(paths[0][0] == shown && paths[0][1] == shown && paths[0][2] == GNURT_NONE, "%d: the outermost alone", user);
        REFUSED(gnurt_intersect_paths(outer, &all, NULL, &to, 1, NULL), "paths: a null pointer");
        /* Hidden, then seen again elsewhere. */
        OK(gnurt_set_mask(outer, shown, 0));
        OK(gnurt_commit(outer));
        OK(gnurt_intersect(outer, &all, NULL, &to));
        CHECK(got[0].t == INFINITY, "%d: it is hidden", user);
        far[11] = 3;
        OK(gnurt_set_mask(outer, shown, 1));
        OK(gnurt_set_place(outer, shown, far));
        OK(gnurt_commit(outer));
        OK(gnurt_intersect(outer, &all, NULL, &to));
        CHECK(got[0].t == 8, "%d: it has moved: %g", user, got[0].t);
        OK(gnurt_remove(inner, ids[1]));
        OK(gnurt_commit(inner));
        OK(gnurt_set_shown(middle, ids[2], inner));
        OK(gnurt_commit(middle));
        OK(gnurt_intersect(outer, &all, NULL, &to));
        CHECK(got[0].t == 8, "%d: what is shown was not committed anew", user);
        OK(gnurt_set_shown(outer, shown, middle));
        OK(gnurt_commit(outer));
        OK(gnurt_intersect(outer, &all, NULL, &to));
        CHECK(got[0].t == 15 && got[0].geom == ids[0], "%d: the balls are gone: %g", user, got[0].t);
        REFUSED(gnurt_remove(inner, ids[1]), "geometry or instance 1 does not exist");
        gnurt_scene_free(inner);
        gnurt_scene_free(outer);
        gnurt_scene_free(middle);
    }
    gnurt_scene_free(scene[1]);
    gnurt_scene_free(scene[2]);
}

/* A cube, whose inside, distances and crossings are known; then it moves. */
static void solids(void)
{
    float corners[8][3];
    static const uint32_t faces[12][3] = { { 0, 2, 1 }, { 1, 2, 3 }, { 4, 5, 6 }, { 5, 7, 6 }, { 0, 1, 4 }, { 1, 5, 4 },
                                           { 2, 6, 3 }, { 3, 6, 7 }, { 0, 4, 2 }, { 2, 4, 6 }, { 1, 3, 5 }, { 3, 7, 5 } };
    for (int i = 0; i < 8; i++)
        for (int k = 0; k < 3; k++)
            corners[i][k] = i >> k & 1;
    gnurt_scene *cube = gnurt_scene_new();
    gnurt_build build = { 0, 0, 0, 1, 1, 0 };
    OK(gnurt_scene_options(cube, &build));
    OK(gnurt_add_triangles(cube, rows(corners, 8, 0, GNURT_F32), rows(faces, 12, 0, GNURT_U32), 1, NULL));
    for (int step = 0; step < 3; step++) {
        for (int i = 0; i < 8; i++)
            corners[i][0] = (i & 1) + (float)step;
        if (step)
            OK(gnurt_set_positions(cube, 0, rows(corners, 8, 0, GNURT_F32)));
        OK(gnurt_commit(cube));
        enum { POINTS = 300 };
        static double points[POINTS][3], distances[POINTS], nearest[POINTS][3];
        static uint8_t contained[POINTS];
        static struct found near[POINTS];
        gnurt_hits to = places(near);
        for (int i = 0; i < POINTS; i++)
            for (int k = 0; k < 3; k++)
                points[i][k] = 2 * number() - 0.5 + (k == 0 ? step : 0);
        gnurt_array all = rows(points, POINTS, 0, GNURT_F64);
        OK(gnurt_contains(cube, all, NULL, contained));
        OK(gnurt_signed_distances(cube, all, NULL, distances));
        OK(gnurt_closest_points(cube, all, INFINITY, NULL, nearest, &to));
        for (int i = 0; i < POINTS; i++) {
            double outside = 0, inside = INFINITY;
            for (int k = 0; k < 3; k++) {
                double x = points[i][k] - (k == 0 ? step : 0), beside = fmax(fmax(-x, x - 1), 0);
                outside += beside * beside;
                inside = fmin(inside, fmin(x, 1 - x));
            }
            double want = outside > 0 ? sqrt(outside) : -inside;
            CHECK(fabs(distances[i] - want) < 1e-12, "%g, not %g", distances[i], want);
            CHECK(contained[i] == (want <= 0), "point %d", i);
            double off[3] = { nearest[i][0] - points[i][0], nearest[i][1] - points[i][1], nearest[i][2] - points[i][2] };
            CHECK(fabs(sqrt(dot(off, off)) - fabs(want)) < 1e-12 && fabs(near[i].t - fabs(want)) < 1e-6, "nearest of %d", i);
        }
        /* Through the diagonal of faces, and through corners. */
        double from[2][3] = { { step + 0.5, 0.5, -1 }, { step - 1, -1, -1 } };
        float dir[2][3] = { { 0, 0, 1 }, { 1, 1, 1 } };
        uint32_t counts[2];
        gnurt_rays through;
        memset(&through, 0, sizeof through);
        through.count = 2;
        through.origins = rows(from, 2, 0, GNURT_F64);
        through.directions = rows(dir, 2, 0, GNURT_F32);
        OK(gnurt_crossings(cube, &through, NULL, counts));
        CHECK(counts[0] == 2 && counts[1] == 2, "crossings: %u, %u", counts[0], counts[1]);
    }
    gnurt_scene_free(cube);
}

/* Few rays are traced without lists; answers are those of many in one call. */
static void few(void)
{
    enum { MOST = 12 };
    for (int kind = 0; kind < 4; kind++) {
        gnurt_scene *shown = new_soup(), *scene = shown;
        static float floats[RAYS][3];
        for (int i = 0; i < RAYS; i++)
            for (int k = 0; k < 3; k++)
                floats[i][k] = (float)asked[i].org[k];
        if (kind == 1) { /* an instance in a scene */
            scene = gnurt_scene_new();
            double place[12] = { 1, 0, 0, 0, 1, 0, 0, 0, 1, 0.25, 0.1, 0.3 };
            OK(gnurt_add_instance(scene, shown, place, ~0u, NULL));
            OK(gnurt_commit(scene));
        } else if (kind == 2) {
            gnurt_build build = { 1, 0, 0, 0, 1, 1 }; /* doubles */
            scene = gnurt_scene_new();
            OK(gnurt_scene_options(scene, &build));
            OK(gnurt_add_triangles(scene, rows(soup, 3 * TRIANGLES, sizeof *soup, GNURT_F32),
                                   rows(soup_indices, TRIANGLES, 0, GNURT_U64), 3, NULL));
            OK(gnurt_commit(scene));
        }
        gnurt_rays all = rays(RAYS);
        if (kind == 3)
            all.origins = rows(floats, RAYS, 0, GNURT_F32);
        static struct found few_found[RAYS];
        uint8_t any[RAYS], few_any[RAYS];
        uint32_t path[RAYS], few_path[RAYS];
        gnurt_hits to = places(found);
        memset(found, 0xff, sizeof found), memset(few_found, 0xfe, sizeof few_found);
        OK(gnurt_intersect_paths(scene, &all, NULL, &to, 1, path));
        OK(gnurt_occluded(scene, &all, NULL, any));
        size_t count = 1;
        int hits = 0;
        for (size_t from = 0; from < RAYS; from += count, count = count % MOST + 1) {
            size_t some = count < RAYS - from ? count : RAYS - from;
            gnurt_rays part = all;
            part.count = some;
            gnurt_array *arrays[] = { &part.origins, &part.directions, &part.t_far, &part.masks };
            for (int k = 0; k < 4; k++) {
                size_t wide = arrays[k] == &part.origins && kind == 3 ? sizeof *floats : sizeof *asked;
                arrays[k]->data = (const char *)arrays[k]->data + from * wide;
                arrays[k]->count = some;
            }
            gnurt_hits into = places(few_found + from);
            OK(gnurt_intersect_paths(scene, &part, NULL, &into, 1, few_path + from));
            OK(gnurt_occluded(scene, &part, NULL, few_any + from));
        }
        for (int i = 0; i < RAYS; i++) {
            hits += found[i].t < INFINITY;
            CHECK(!memcmp(&found[i], &few_found[i], sizeof *found), "kind %d, ray %d: %g and %g", kind, i, found[i].t,
                  few_found[i].t);
            CHECK(any[i] == few_any[i] && path[i] == few_path[i], "kind %d, ray %d: any hit, path", kind, i);
        }
        CHECK(hits > 50, "%d hits", hits);
        if (scene != shown)
            gnurt_scene_free(scene);
        gnurt_scene_free(shown);
    }
}

/* Grids are the same as their cells as quads, bit for bit: a part of the vertices, and every second row once more. */
static void grids(void)
{
    enum { COLUMNS = 17, ROWS = 12, CELLS = 15 * 11 + 16 * 5 };
    static float heights[ROWS * COLUMNS][3];
    static uint32_t quads[CELLS][4];
    uint64_t given[2][4] = { { 0, COLUMNS, COLUMNS - 1, ROWS }, { 0, 2 * COLUMNS, COLUMNS, ROWS / 2 } };
    int count = 0;
    for (int i = 0; i < ROWS * COLUMNS; i++) {
        heights[i][0] = (i % COLUMNS) / 16.0f, heights[i][1] = (i / COLUMNS) / 11.0f;
        heights[i][2] = 0.3f * number();
    }
    for (int g = 0; g < 2; g++)
        for (uint64_t y = 0; y + 1 < given[g][3]; y++)
            for (uint64_t x = 0; x + 1 < given[g][2]; x++) {
                uint32_t a = (uint32_t)(y * given[g][1] + x), b = a + (uint32_t)given[g][1];
                uint32_t corners[4] = { a, a + 1, b + 1, b };
                memcpy(quads[count++], corners, sizeof corners);
            }
    CHECK(count == CELLS, "%d cells", count);
    gnurt_scene_free(new_soup()); /* its rays */
    gnurt_rays all = rays(RAYS);
    all.masks.data = NULL;
    static struct found expected[RAYS];
    gnurt_scene *scenes[2];
    for (int k = 0; k < 2; k++) {
        scenes[k] = gnurt_scene_new();
        uint32_t id = 9;
        if (k == 0)
            OK(gnurt_add_quads(scenes[k], rows(heights, ROWS * COLUMNS, 0, GNURT_F32), rows(quads, CELLS, 0, GNURT_U32), 1, &id));
        else
            OK(gnurt_add_grids(scenes[k], rows(heights, ROWS * COLUMNS, 0, GNURT_F32), rows(given, 2, 0, GNURT_U64), 1, &id));
        CHECK(id == 0, "the first");
    }
    for (int step = 0; step < 2; step++) {
        int hits = 0;
        for (int k = 0; k < 2; k++) {
            OK(gnurt_commit(scenes[k]));
            struct found *to = k ? found : expected;
            memset(to, 0, sizeof found);
            gnurt_hits into = places(to);
            OK(gnurt_intersect(scenes[k], &all, NULL, &into));
            gnurt_facts facts;
            OK(gnurt_scene_facts(scenes[k], &facts));
            CHECK(facts.primitives == 2 * CELLS && facts.left_out == 0, "%d halves of cells", (int)facts.primitives);
        }
        for (int i = 0; i < RAYS; i++) {
            hits += expected[i].t < INFINITY;
            CHECK(!memcmp(&expected[i], &found[i], sizeof *found), "step %d, ray %d: %g and %g", step, i, expected[i].t, found[i].t);
        }
        CHECK(hits > 100, "%d hits", hits);
        for (int i = 0; i < ROWS * COLUMNS; i++)
            heights[i][2] = -heights[i][2];
        for (int k = 0; k < 2; k++)
            OK(gnurt_set_positions(scenes[k], 0, rows(heights, ROWS * COLUMNS, 0, GNURT_F32)));
    }
    uint32_t wrong[2][4] = { { 0, 2, 2, 2 }, { 0, 2, 70000, 2 } };
    REFUSED(gnurt_add_grids(scenes[1], rows(heights, 4, 0, GNURT_F32), rows(wrong, 2, 0, GNURT_U32), 1, NULL),
            "grids: row 1 has 70000 columns of vertices; 65535 is the most");
    REFUSED(gnurt_add_grids(scenes[1], rows(heights, 4, 0, GNURT_F32), rows(wrong, 2, 0, GNURT_F32), 1, NULL), "grids: type 0");
    /* Cells without a vertex are left out. */
    wrong[1][2] = 3;
    OK(gnurt_remove(scenes[1], 0));
    OK(gnurt_add_grids(scenes[1], rows(heights, 4, 0, GNURT_F32), rows(wrong, 2, 0, GNURT_U32), 1, NULL));
    OK(gnurt_commit(scenes[1]));
    gnurt_facts facts;
    OK(gnurt_scene_facts(scenes[1], &facts));
    CHECK(facts.primitives == 4 && facts.left_out == 1, "%d halves, %d left out", (int)facts.primitives, (int)facts.left_out);
    for (int k = 0; k < 2; k++)
        gnurt_scene_free(scenes[k]);
}

static void errors(void)
{
    gnurt_scene *scene = gnurt_scene_new();
    struct found one;
    gnurt_hits to = places(&one);
    gnurt_rays none = rays(1);
    REFUSED(gnurt_intersect(scene, &none, NULL, &to), "not committed");
    REFUSED(gnurt_commit(NULL), "scene: a null pointer");
    REFUSED(gnurt_add_triangles(scene, rows(soup, 3, 16, GNURT_U32), rows(soup_indices, 1, 0, GNURT_U64), 1, NULL),
            "positions: type 2");
    REFUSED(gnurt_add_triangles(scene, rows(soup, 3, 16, GNURT_F32), rows(NULL, 1, 0, GNURT_U32), 1, NULL),
            "indices: 1 rows at a null pointer");
    REFUSED(gnurt_add_spheres(scene, rows(soup, 3, 16, GNURT_F32), rows(soup, 2, 0, GNURT_F32), 1, NULL), "radii: 2");
    double bad[12] = { NAN };
    REFUSED(gnurt_add_instance(scene, scene, identity, 1, NULL), "shown: it is not committed");
    OK(gnurt_commit(scene));
    REFUSED(gnurt_add_instance(scene, scene, bad, 1, NULL), "place");
    OK(gnurt_intersect(scene, &none, NULL, &to));
    CHECK(one.t == INFINITY, "nothing is in it");
    none.count = 2;
    REFUSED(gnurt_occluded(scene, &none, NULL, NULL), "occluded");
    none.origins.count = 3;
    REFUSED(gnurt_intersect(scene, &none, NULL, &to), "origins: 3 rows for 2 rays");
    REFUSED(gnurt_set_place(scene, 7, identity), "7");
    gnurt_build build = { 5, 0, 0, 0, 0, 0 };
    REFUSED(gnurt_scene_options(scene, &build), "quality: 5");
    /* A triangle without a vertex is left out. */
    uint32_t far[2][3] = { { 0, 1, 2 }, { 0, 1, 77 } };
    OK(gnurt_add_triangles(scene, rows(soup, 3, 16, GNURT_F32), rows(far, 2, 0, GNURT_U32), 1, NULL));
    OK(gnurt_commit(scene));
    gnurt_facts facts;
    OK(gnurt_scene_facts(scene, &facts));
    CHECK(facts.primitives == 1 && facts.left_out == 1, "%d left out", (int)facts.left_out);
    gnurt_scene_free(scene);
    gnurt_scene_free(NULL);
}

int main(void)
{
    CHECK(gnurt_rays_version() > 0 && gnurt_last_error()[0] == 0, "nothing is wrong yet");
    triangles();
    strands();
    scenes_in_scenes();
    solids();
    few();
    grids();
    errors();
    return finish();
}
