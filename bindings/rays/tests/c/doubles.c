/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Scenes in double precision: a cube a hundred million from the origin, by itself and shown by an instance. */
#include <gnurt/rays.h>

#include "check.h"

#define OK(call) CHECK((call) == 0, "%s", gnurt_last_error())

#define FAR 1e8
static double corners[8][3];
static const uint32_t faces[12][3] = { { 0, 2, 1 }, { 1, 2, 3 }, { 4, 5, 6 }, { 5, 7, 6 }, { 0, 1, 4 }, { 1, 5, 4 },
                                       { 2, 6, 3 }, { 3, 6, 7 }, { 0, 4, 2 }, { 2, 4, 6 }, { 1, 3, 5 }, { 3, 7, 5 } };

static gnurt_array rows(const void *data, size_t count, enum gnurt_type type)
{
    gnurt_array array = { data, count, 0, type };
    return array;
}

static const gnurt_build in_doubles = { 0, 0, 0, 0, 1, 1 };

/* A ray from below through the cube at (x, y) above its corner. */
static void ask(const gnurt_scene *scene, double x, double y, double at, uint32_t instance)
{
    double origin[3] = { at + x, at + y, at - 2 };
    const double up[3] = { 0, 0, 0.5 };
    gnurt_rays rays;
    memset(&rays, 0, sizeof rays);
    rays.count = 1;
    rays.origins = rows(origin, 1, GNURT_F64);
    rays.directions = rows(up, 1, GNURT_F64);
    double t, u, v, normal[3];
    uint32_t prim, geom, inst, path[2], count;
    gnurt_hits64 to = { 0, &t, &u, &v, &prim, &geom, &inst, normal };
    OK(gnurt_intersect64(scene, &rays, NULL, &to, 2, path));
    CHECK(t == 4, "%.17g", t);
    CHECK(geom == 0 && prim < 2, "triangle %u of %u", prim, geom);
    CHECK(inst == instance && path[0] == instance && path[1] == GNURT_NONE, "instance %u", inst);
    CHECK(normal[0] == 0 && normal[1] == 0 && normal[2] == -1, "%g %g %g", normal[0], normal[1], normal[2]);
    float single;
    gnurt_hits floats = { 0, &single, NULL, NULL, NULL, NULL, NULL, NULL };
    OK(gnurt_intersect(scene, &rays, NULL, &floats));
    CHECK(single == 4, "%g", (double)single);
    uint8_t occluded = 0;
    OK(gnurt_occluded(scene, &rays, NULL, &occluded));
    CHECK(occluded == 1, "%d", occluded);
    OK(gnurt_crossings(scene, &rays, NULL, &count));
    CHECK(count == 2, "in and out, not %u", count);
    double all[9];
    size_t end = 0;
    gnurt_hits64 list = { 0, all, NULL, NULL, NULL, NULL, NULL, NULL };
    OK(gnurt_all_hits64(scene, &rays, NULL, 0, &end, 9, &list));
    CHECK(end >= 2 && all[0] == 4 && all[end - 1] == 6, "%zu hits up to %g", end, all[end - 1]);
    double points[2][3] = { { at + x, at + y, at + 0.25 }, { at + 0.5, at + 0.5, at - 0.125 } }, distances[2], nearest[2][3];
    uint8_t contained[2];
    OK(gnurt_contains(scene, rows(points, 2, GNURT_F64), NULL, contained));
    CHECK(contained[0] == 1 && contained[1] == 0, "%d %d", contained[0], contained[1]);
    OK(gnurt_signed_distances(scene, rows(points, 2, GNURT_F64), NULL, distances));
    CHECK(distances[0] <= 0 && distances[1] == 0.125, "%.17g %.17g", distances[0], distances[1]);
    double far[2];
    gnurt_hits64 near = { 0, far, NULL, NULL, NULL, NULL, NULL, NULL };
    OK(gnurt_closest_points64(scene, rows(points, 2, GNURT_F64), 1, NULL, nearest, &near));
    CHECK(far[1] == 0.125 && nearest[1][2] == at, "%.17g at %.17g", far[1], nearest[1][2]);
}

int main(void)
{
    for (int i = 0; i < 8; i++)
        for (int k = 0; k < 3; k++)
            corners[i][k] = FAR + (i >> k & 1);
    gnurt_scene *scene = gnurt_scene_new(), *outer = gnurt_scene_new(), *floats = gnurt_scene_new();
    OK(gnurt_scene_options(scene, &in_doubles));
    OK(gnurt_add_triangles(scene, rows(corners, 8, GNURT_F64), rows(faces, 12, GNURT_U32), ~0u, NULL));
    OK(gnurt_commit(scene));
    /* Insides, edges between triangles, and a corner. */
    ask(scene, 0.25, 0.625, FAR, GNURT_NONE);
    ask(scene, 0.5, 0.5, FAR, GNURT_NONE);
    OK(gnurt_scene_options(outer, &in_doubles));
    static const double place[12] = { 1, 0, 0, 0, 1, 0, 0, 0, 1, -FAR, -FAR, -FAR };
    OK(gnurt_add_instance(outer, scene, place, ~0u, NULL));
    OK(gnurt_commit(outer));
    ask(outer, 0.25, 0.625, 0, 0);
    ask(outer, 0.5, 0.5, 0, 0);
    gnurt_facts facts;
    OK(gnurt_scene_facts(scene, &facts));
    CHECK(facts.primitives == 12 && facts.left_out == 0 && facts.bytes > 0, "%llu", (unsigned long long)facts.primitives);
    CHECK(facts.lower[0] < FAR && facts.upper[0] > FAR, "%g to %g", (double)facts.lower[0], (double)facts.upper[0]);
    /* Precisions do not mix, and are chosen first. */
    OK(gnurt_commit(floats));
    CHECK(gnurt_add_instance(outer, floats, place, ~0u, NULL) == -1, "floats in doubles");
    CHECK(gnurt_add_instance(floats, scene, place, ~0u, NULL) == -1, "doubles in floats");
    static const gnurt_build in_floats = { 0, 0, 0, 0, 1, 0 }, moving = { 0, 0, 0, 1, 1, 1 };
    CHECK(gnurt_scene_options(scene, &in_floats) == -1, "a scene with geometry keeps its precision");
    CHECK(gnurt_scene_options(scene, &moving) == -1, "nothing is refitted");
    CHECK(gnurt_add_spheres(scene, rows(corners, 1, GNURT_F64), rows(corners, 1, GNURT_F64), ~0u, NULL) == -1, "no spheres");
    /* Other positions. */
    for (int i = 0; i < 8; i++)
        corners[i][2] += 2;
    OK(gnurt_set_positions(scene, 0, rows(corners, 8, GNURT_F64)));
    OK(gnurt_commit(scene));
    OK(gnurt_scene_facts(scene, &facts));
    CHECK(facts.left_out == 0, "all are there");
    gnurt_scene_free(outer);
    gnurt_scene_free(scene);
    gnurt_scene_free(floats);
    return finish();
}
