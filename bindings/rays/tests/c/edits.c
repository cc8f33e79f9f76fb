/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What gnurt/rays.h says of arrays, threads and processes: arrays go after a commit, parts change, queries go on in a child. */
#include <gnurt/rays.h>

#include <pthread.h>
#include <sys/wait.h>
#include <unistd.h>

#include "check.h"

#define OK(call) CHECK((call) == 0, "%s", gnurt_last_error())

static gnurt_array rows(const void *data, size_t count, enum gnurt_type type)
{
    gnurt_array array = { data, count, 0, type };
    return array;
}

enum { RAYS = 1000 };
static float origins[RAYS][3], t[RAYS];
static uint32_t geometries[RAYS], primitives[RAYS];
static const float up[3] = { 0, 0, 1 };

static gnurt_rays rays(void)
{
    gnurt_rays all;
    memset(&all, 0, sizeof all);
    all.count = RAYS;
    all.origins = rows(origins, RAYS, GNURT_F32);
    all.directions = rows(up, 1, GNURT_F32);
    return all;
}

static int ask(gnurt_scene *scene, unsigned threads)
{
    gnurt_rays all = rays();
    gnurt_hits to = { 0, t, NULL, NULL, primitives, geometries, NULL, NULL };
    gnurt_query query = { threads, 0, NULL, NULL };
    return gnurt_intersect(scene, &all, &query, &to);
}

/* Arrays of a square at a height, which are of no more use once the program has spoilt and freed them. */
struct square {
    float (*corners)[3];
    uint32_t (*faces)[3];
};

static struct square square(float z)
{
    static const float at[4][2] = { { -9, -9 }, { 9, -9 }, { 9, 9 }, { -9, 9 } };
    static const uint32_t of[2][3] = { { 0, 1, 2 }, { 0, 2, 3 } };
    struct square new = { malloc(4 * sizeof *new.corners), malloc(sizeof of) };
    for (int i = 0; i < 4; i++)
        new.corners[i][0] = at[i][0], new.corners[i][1] = at[i][1], new.corners[i][2] = z;
    memcpy(new.faces, of, sizeof of);
    return new;
}

static void spoil(struct square *old)
{
    memset(old->corners, 0xff, 4 * sizeof *old->corners);
    memset(old->faces, 0xff, 2 * sizeof *old->faces);
    free(old->corners);
    free(old->faces);
}

static void arrays_go_after_a_commit(int moves)
{
    gnurt_scene *scene = gnurt_scene_new();
    gnurt_build build = { 0, 0, 0, moves, 1, 0 };
    OK(gnurt_scene_options(scene, &build));
    uint32_t first, second, balls;
    struct square far = square(5), near = square(3);
    float centers[1][3] = { { 0, 0, 50 } }, radii[1] = { 40 };
    OK(gnurt_add_triangles(scene, rows(far.corners, 4, GNURT_F32), rows(far.faces, 2, GNURT_U32), 1, &first));
    OK(gnurt_add_spheres(scene, rows(centers, 1, GNURT_F32), rows(radii, 1, GNURT_F32), 1, &balls));
    OK(gnurt_commit(scene));
    spoil(&far);
    centers[0][0] = radii[0] = NAN;
    OK(gnurt_add_triangles(scene, rows(near.corners, 4, GNURT_F32), rows(near.faces, 2, GNURT_U32), 1, &second));
    OK(gnurt_commit(scene));
    spoil(&near);
    OK(ask(scene, 1));
    CHECK(t[0] == 3 && geometries[0] == second, "the new one is in front: %g", t[0]);
    OK(gnurt_set_mask(scene, second, 0));
    OK(gnurt_commit(scene));
    OK(ask(scene, 1));
    CHECK(t[0] == 5 && geometries[0] == first, "the first one is still there: %g, %u", t[0], geometries[0]);
    /* Its faces are kept, too. */
    struct square nearer = square(4);
    OK(gnurt_set_positions(scene, first, rows(nearer.corners, 4, GNURT_F32)));
    OK(gnurt_commit(scene));
    spoil(&nearer);
    OK(gnurt_commit(scene));
    OK(ask(scene, 1));
    CHECK(t[0] == 4 && geometries[0] == first, "it has moved: %g, %u", t[0], geometries[0]);
    OK(gnurt_remove(scene, first));
    OK(gnurt_commit(scene));
    OK(ask(scene, 1));
    CHECK(fabsf(t[0] - 10) < 1e-4f && geometries[0] == balls, "the ball is left: %g, %u", t[0], geometries[0]);
    gnurt_scene_free(scene);
}

static void a_child_asks(void)
{
    struct square floor = square(2);
    gnurt_scene *scene = gnurt_scene_new();
    OK(gnurt_add_triangles(scene, rows(floor.corners, 4, GNURT_F32), rows(floor.faces, 2, GNURT_U32), 1, NULL));
    OK(gnurt_commit(scene));
    OK(ask(scene, 2));
    CHECK(t[0] == 2, "the parent is answered: %g", t[0]);
    fflush(NULL);
    pid_t child = fork();
    if (child == 0) {
        alarm(20);
        memset(t, 0, sizeof t);
        _exit(ask(scene, 2) == 0 && t[0] == 2 && gnurt_commit(scene) == 0 ? 0 : 1);
    }
    int status = 0;
    CHECK(waitpid(child, &status, 0) == child && WIFEXITED(status) && WEXITSTATUS(status) == 0,
          "the child is answered: status %d (signal %d)", status, WIFSIGNALED(status) ? WTERMSIG(status) : 0);
    OK(ask(scene, 2));
    spoil(&floor);
    gnurt_scene_free(scene);
}

/* Balls of the program at a height, and who has asked for them. */
static float height;
static pthread_t caller;
static int by_caller, by_others;

static void ball_bounds(void *user, uint32_t first, uint32_t count, float (*boxes)[6])
{
    (void)user, (void)first;
    for (uint32_t i = 0; i < count; i++)
        for (int k = 0; k < 6; k++)
            boxes[i][k] = (k < 3 ? -1 : 1) + (k % 3 == 2 ? height : 0);
}

static void ball_intersect(void *user, size_t count, const gnurt_user_ray *all, gnurt_user_hit *hits)
{
    (void)user, (void)count;
    if (pthread_equal(pthread_self(), caller))
        __atomic_add_fetch(&by_caller, 1, __ATOMIC_RELAXED);
    else
        __atomic_add_fetch(&by_others, 1, __ATOMIC_RELAXED);
    hits->t = height - 1 - all->org[2];
}

static void let_pass(void *user, size_t count, const gnurt_candidate *hits, int *accept)
{
    (void)count, (void)hits, (void)accept;
    CHECK(pthread_equal(pthread_self(), caller), "filters are called by the calling thread");
    *(int *)user += 1;
}

static void threads_and_boxes(void)
{
    gnurt_scene *scene = gnurt_scene_new();
    gnurt_user balls = { NULL, 1, ball_bounds, ball_intersect };
    uint32_t id;
    int asked = 0;
    caller = pthread_self();
    OK(gnurt_add_user(scene, &balls, 1, &id));
    OK(gnurt_commit(scene));
    for (height = 0; height < 21; height += 10) {
        OK(gnurt_set_user(scene, id, &balls));
        OK(gnurt_commit(scene));
        for (int threads = 1; threads < 3; threads++) {
            gnurt_rays all = rays();
            gnurt_query query = { threads, 0, NULL, NULL };
            size_t ends[RAYS];
            gnurt_hits to = { 0, t, NULL, NULL, NULL, NULL, NULL, NULL };
            by_caller = by_others = 0;
            OK(gnurt_all_hits(scene, &all, &query, 0, ends, RAYS, &to));
            CHECK(ends[RAYS - 1] == RAYS && t[7] == height + 9, "all are hit at %g: %zu, %g", height, ends[RAYS - 1], t[7]);
            CHECK((by_caller > 0) == (threads == 1) && (by_others > 0) == (threads == 2),
                  "%d threads: asked %d times by this one, %d by others", threads, by_caller, by_others);
            query.filter = let_pass, query.user = &asked;
            by_caller = by_others = 0;
            memset(t, 0, sizeof t);
            OK(gnurt_intersect(scene, &all, &query, &to));
            CHECK(t[7] == height + 9, "with a filter: %g", t[7]);
            CHECK((by_caller > 0) == (threads == 1), "%d threads and a filter: asked %d times by this one", threads, by_caller);
        }
    }
    CHECK(asked > 0, "the filter was asked");
    CHECK(gnurt_set_user(scene, 7, &balls) == -1 && strstr(gnurt_last_error(), "7"), "%s", gnurt_last_error());
    gnurt_scene_free(scene);
}

int main(void)
{
    for (int i = 0; i < RAYS; i++)
        origins[i][0] = origins[i][1] = i * 1e-4f;
    arrays_go_after_a_commit(0);
    arrays_go_after_a_commit(1);
    for (int i = 0; i < RAYS; i++)
        origins[i][2] = -10;
    threads_and_boxes();
    for (int i = 0; i < RAYS; i++)
        origins[i][2] = 0;
    a_child_asks();
    return finish();
}
