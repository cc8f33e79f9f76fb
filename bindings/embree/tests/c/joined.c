/* SPDX-License-Identifier: GPL-3.0-or-later */
/* When scenes are built, what functions of the program may ask meanwhile, and what is told of mistakes. With an argument: only a
 * mistake that is told on a standard error that cannot be written. */
#include <gnurt/embree.h>

#include <pthread.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "check.h"

static RTCDevice device;

static void expect(enum RTCError code, const char *what)
{
    enum RTCError found = rtcGetDeviceError(device);
    CHECK(found == code, "%s: %s", what, rtcGetErrorString(found));
}

static RTCGeometry square(float z)
{
    RTCGeometry mesh = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_QUAD);
    float(*p)[3] = rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, 4);
    unsigned *indices = rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT4, 16, 1);
    float at[4][3] = { { -9, -9, z }, { 9, -9, z }, { 9, 9, z }, { -9, 9, z } };
    memcpy(p, at, sizeof at);
    for (int i = 0; i < 4; i++)
        indices[i] = i;
    rtcCommitGeometry(mesh);
    return mesh;
}

static float distance(RTCScene scene)
{
    struct RTCRayHit r;
    memset(&r, 0, sizeof r);
    r.ray.dir_z = 1, r.ray.tfar = INFINITY, r.ray.mask = -1;
    rtcIntersect1(scene, &r, NULL);
    return r.ray.tfar;
}

/* How often a scene was built: the end of each build is told. */
static int builds;
static bool count_builds(void *user, double done)
{
    (void)user;
    if (done >= 1)
        __atomic_add_fetch(&builds, 1, __ATOMIC_RELAXED);
    return true;
}

static int built(RTCScene scene)
{
    builds = 0;
    rtcSetSceneProgressMonitorFunction(scene, count_builds, NULL);
    rtcCommitScene(scene);
    return builds;
}

enum { THREADS = 8, MANY = 2000 };

static void *join_and_ask(void *scene)
{
    rtcJoinCommitScene(scene);
    for (int i = 0; i < MANY; i++)
        if (distance(scene) != 3)
            return scene;
    return NULL;
}

/* As programs build scenes while they render: all threads join, and ask at once. */
static void several_threads_join(void)
{
    RTCScene scene = rtcNewScene(device);
    RTCGeometry mesh = square(3);
    rtcAttachGeometry(scene, mesh);
    rtcSetSceneProgressMonitorFunction(scene, count_builds, NULL);
    for (int round = 0; round < 4; round++) {
        pthread_t threads[THREADS];
        builds = 0;
        rtcCommitGeometry(mesh);
        for (int i = 0; i < THREADS; i++)
            pthread_create(&threads[i], NULL, join_and_ask, scene);
        for (int i = 0; i < THREADS; i++) {
            void *wrong;
            pthread_join(threads[i], &wrong);
            CHECK(!wrong, "thread %d gets a wrong answer", i);
        }
        CHECK(builds == 1, "round %d: %d threads build %d times", round, THREADS, builds);
    }
    rtcReleaseGeometry(mesh);
    rtcReleaseScene(scene);
}

static void what_is_an_edit(void)
{
    RTCScene scene = rtcNewScene(device), outer = rtcNewScene(device);
    RTCGeometry mesh = square(3), other = square(2), instance = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
    CHECK(built(scene) == 1 && built(scene) == 0, "an empty scene is built once");
    rtcAttachGeometry(scene, mesh);
    CHECK(built(scene) == 1 && built(scene) == 0, "a geometry came");
    rtcCommitGeometry(mesh);
    CHECK(built(scene) == 1 && built(scene) == 0, "a geometry was committed");
    rtcEnableGeometry(mesh);
    CHECK(built(scene) == 0, "it was enabled");
    rtcDisableGeometry(mesh);
    CHECK(built(scene) == 1 && distance(scene) == INFINITY, "it is disabled");
    rtcEnableGeometry(mesh);
    CHECK(built(scene) == 1 && distance(scene) == 3, "it is enabled again");
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_NONE);
    CHECK(built(scene) == 0, "the same flags");
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_COMPACT);
    CHECK(built(scene) == 1, "other flags");
    rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_LOW);
    CHECK(built(scene) == 1, "another quality");
    rtcSetGeometryInstancedScene(instance, scene);
    rtcCommitGeometry(instance);
    rtcAttachGeometry(outer, instance);
    rtcCommitScene(outer);
    CHECK(distance(outer) == 3, "it is shown: %g", distance(outer));
    unsigned id = rtcAttachGeometry(scene, other);
    CHECK(built(scene) == 1 && distance(scene) == 2, "another one came");
    CHECK(built(outer) > 0 && distance(outer) == 2 && built(outer) == 0, "what is shown was committed: %g", distance(outer));
    rtcDetachGeometry(scene, id);
    CHECK(built(scene) == 1 && distance(scene) == 3, "it is gone");
    expect(RTC_ERROR_NONE, "edits");
    /* Setters ask for a commit of the geometry. */
    rtcSetGeometryMask(mesh, 5);
    rtcCommitScene(scene);
    expect(RTC_ERROR_INVALID_OPERATION, "a mask was set, and the geometry not committed");
    rtcCommitGeometry(mesh);
    rtcUpdateGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0);
    rtcCommitScene(scene);
    expect(RTC_ERROR_INVALID_OPERATION, "a buffer was written, and the geometry not committed");
    rtcDisableGeometry(mesh);
    rtcCommitScene(scene);
    expect(RTC_ERROR_NONE, "but it is not seen");
    /* The box around what is no longer there. */
    struct RTCBounds bounds;
    struct RTCLinearBounds linear;
    rtcEnableGeometry(mesh);
    rtcCommitGeometry(mesh);
    rtcCommitScene(scene);
    rtcGetSceneBounds(scene, &bounds);
    CHECK(bounds.lower_z == 3, "bounds begin at %g", bounds.lower_z);
    rtcAttachGeometry(scene, other);
    rtcGetSceneBounds(scene, &bounds);
    expect(RTC_ERROR_INVALID_OPERATION, "bounds of a scene that was edited");
    rtcGetSceneLinearBounds(scene, &linear);
    expect(RTC_ERROR_INVALID_OPERATION, "linear bounds of a scene that was edited");
    rtcCommitScene(scene);
    rtcGetSceneBounds(scene, NULL);
    expect(RTC_ERROR_INVALID_ARGUMENT, "no room for bounds");
    rtcGetGeometryTransform(instance, 0, RTC_FORMAT_FLOAT3X4_ROW_MAJOR, NULL);
    expect(RTC_ERROR_INVALID_ARGUMENT, "no room for a matrix");
    rtcGetGeometryTransformFromScene(outer, 0, 0, RTC_FORMAT_FLOAT3X4_ROW_MAJOR, NULL);
    expect(RTC_ERROR_INVALID_ARGUMENT, "no room for a matrix of a scene's");
    rtcReleaseGeometry(mesh);
    rtcReleaseGeometry(other);
    rtcReleaseGeometry(instance);
    rtcReleaseScene(outer);
    rtcReleaseScene(scene);
}

/* Functions that ask about the scene that is being committed. */
static int asked;
static bool ask_progress(void *scene, double done)
{
    (void)done;
    asked++;
    CHECK(rtcGetSceneFlags(scene) == RTC_SCENE_FLAG_COMPACT, "flags");
    CHECK(rtcGetGeometry(scene, 0) != NULL && rtcGetGeometryThreadSafe(scene, 0) != NULL, "a geometry");
    rtcCommitScene(scene);
    expect(RTC_ERROR_INVALID_OPERATION, "the commit has called this");
    return true;
}

static RTCScene asked_about;
static void ask_bounds(const struct RTCBoundsFunctionArguments *args)
{
    asked++;
    CHECK(rtcGetGeometryUserDataFromScene(asked_about, 0) == &asked, "the pointer of a geometry");
    rtcSetGeometryUserData(rtcGetGeometry(asked_about, 0), &asked);
    struct RTCBounds out = { -1, -1, -1, 0, 1, 1, 1, 0 };
    *args->bounds_o = out;
}

static void functions_ask_about_their_scene(void)
{
    alarm(30);
    RTCScene scene = asked_about = rtcNewScene(device);
    RTCGeometry user = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryUserPrimitiveCount(user, 2);
    rtcSetGeometryBoundsFunction(user, ask_bounds, NULL);
    rtcSetGeometryUserData(user, &asked);
    rtcCommitGeometry(user);
    rtcAttachGeometry(scene, user);
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_COMPACT);
    rtcSetSceneProgressMonitorFunction(scene, ask_progress, scene);
    rtcCommitScene(scene);
    expect(RTC_ERROR_NONE, "a commit whose functions ask");
    CHECK(asked > 2, "they were called: %d", asked);
    rtcReleaseGeometry(user);
    rtcReleaseScene(scene);
    alarm(0);
}

/* Geometries by their ids: of the draft, and of what is committed. */
static void ids(void)
{
    RTCScene scene = rtcNewScene(device);
    RTCGeometry meshes[2] = { square(1), square(2) };
    clock_t before = clock();
    enum { ATTACHED = 40000 };
    for (unsigned i = 0; i < ATTACHED; i++)
        if (rtcAttachGeometry(scene, meshes[0]) != i)
            CHECK(0, "id %u", i);
    double seconds = (double)(clock() - before) / CLOCKS_PER_SEC;
    CHECK(seconds < 0.5, "%d geometries are attached in %g s", ATTACHED, seconds);
    for (unsigned i = 0; i < ATTACHED; i++)
        if (i % 1000 != 7)
            rtcDetachGeometry(scene, i);
    rtcAttachGeometryByID(scene, meshes[1], 0);
    for (int committed = 0; committed < 2; committed++) {
        for (unsigned i = 0; i < ATTACHED; i += 500)
            if (i % 1000)
                rtcAttachGeometryByID(scene, meshes[1], i + committed);
        CHECK(rtcGetGeometry(scene, 0) == meshes[1] && rtcGetGeometry(scene, 7) == meshes[0], "of the draft");
        CHECK(rtcGetGeometry(scene, 500) == meshes[1] && rtcGetGeometry(scene, 39007) == meshes[0], "of the draft");
        rtcCommitScene(scene);
        CHECK(rtcGetGeometry(scene, 0) == meshes[1] && rtcGetGeometry(scene, 7) == meshes[0], "of what is committed");
        CHECK(rtcGetGeometry(scene, 500) == meshes[1] && rtcGetGeometry(scene, 39007) == meshes[0], "of what is committed");
        CHECK(rtcGetGeometryThreadSafe(scene, 500) == meshes[1], "with a lock");
    }
    rtcSetGeometryUserData(meshes[0], &asked);
    CHECK(rtcGetGeometryUserDataFromScene(scene, 7) == &asked, "the pointer is that of now");
    expect(RTC_ERROR_NONE, "ids");
    rtcDetachGeometry(scene, 7);
    CHECK(rtcGetGeometry(scene, 7) == NULL, "it is gone before the commit");
    expect(RTC_ERROR_INVALID_ARGUMENT, "it is gone");
    CHECK(rtcGetGeometryUserDataFromScene(scene, 7) == NULL, "and its pointer with it");
    expect(RTC_ERROR_INVALID_ARGUMENT, "it is gone");
    CHECK(rtcAttachGeometry(scene, meshes[1]) == 1, "the lowest id is given");
    rtcReleaseGeometry(meshes[0]);
    rtcReleaseGeometry(meshes[1]);
    rtcReleaseScene(scene);
}

/* Memory that is refused at the end of a build. */
static ssize_t held;
static bool refuse_the_last(void *user, ssize_t bytes, bool post)
{
    (void)user, (void)post;
    held += bytes;
    /* What the build held is given back before what the scene holds is told. */
    return !(builds > 0 && bytes > 0 && held == bytes);
}

static void monitors(void)
{
    RTCScene scene = rtcNewScene(device);
    RTCGeometry mesh = square(3);
    rtcAttachGeometry(scene, mesh);
    builds = 0;
    rtcSetSceneProgressMonitorFunction(scene, count_builds, NULL);
    rtcSetDeviceMemoryMonitorFunction(device, refuse_the_last, NULL);
    rtcCommitScene(scene);
    expect(RTC_ERROR_OUT_OF_MEMORY, "memory that is refused at the end");
    CHECK(held == 0, "what is refused is given back: %zd", held);
    rtcSetDeviceMemoryMonitorFunction(device, NULL, NULL);
    rtcCommitScene(scene);
    CHECK(distance(scene) == 3, "it can be built again");
    rtcReleaseGeometry(mesh);
    rtcReleaseScene(scene);
}

static int steps;
static bool count_steps(void *user, double done)
{
    (void)user, (void)done;
    steps++;
    return true;
}

static bool stop(void *user, double done)
{
    (void)user, (void)done;
    return false;
}

/* A floor of many quads: builds over it take several steps, and several threads. */
enum { SIDE = 110 };
static RTCGeometry grid(RTCDevice of)
{
    static float p[SIDE][SIDE][3];
    static unsigned quads[SIDE - 1][SIDE - 1][4];
    for (int i = 0; i < SIDE; i++)
        for (int j = 0; j < SIDE; j++)
            p[i][j][0] = i - SIDE / 2.25f, p[i][j][1] = j - SIDE / 2.25f, p[i][j][2] = 8;
    for (int i = 0; i + 1 < SIDE; i++)
        for (int j = 0; j + 1 < SIDE; j++) {
            unsigned a = i * SIDE + j, quad[4] = { a, a + 1, a + SIDE + 1, a + SIDE };
            memcpy(quads[i][j], quad, sizeof quad);
        }
    RTCGeometry mesh = rtcNewGeometry(of, RTC_GEOMETRY_TYPE_QUAD);
    rtcSetSharedGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, p, 0, 12, SIDE * SIDE);
    rtcSetSharedGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT4, quads, 0, 16, (SIDE - 1) * (SIDE - 1));
    rtcCommitGeometry(mesh);
    return mesh;
}

/* A mesh that moves beside one that rests: the tree follows, without a build, and says how far it is. */
static void refits(enum RTCBuildQuality of_what_rests)
{
    RTCScene scene = rtcNewScene(device);
    RTCGeometry moves = square(3), rests = grid(device);
    rtcSetGeometryBuildQuality(moves, RTC_BUILD_QUALITY_REFIT);
    rtcSetGeometryBuildQuality(rests, of_what_rests);
    rtcCommitGeometry(moves);
    rtcCommitGeometry(rests);
    rtcAttachGeometry(scene, moves);
    rtcAttachGeometry(scene, rests);
    steps = 0;
    rtcSetSceneProgressMonitorFunction(scene, count_steps, NULL);
    rtcCommitScene(scene);
    CHECK(steps > 3, "a build takes more steps than a refit: %d", steps);
    for (int step = 1; step < 4; step++) {
        float(*p)[3] = rtcGetGeometryBufferData(moves, RTC_BUFFER_TYPE_VERTEX, 0);
        for (int i = 0; i < 4; i++)
            p[i][2] = 3 + step;
        rtcUpdateGeometryBuffer(moves, RTC_BUFFER_TYPE_VERTEX, 0);
        rtcCommitGeometry(moves);
        steps = 0;
        rtcSetSceneProgressMonitorFunction(scene, step == 2 ? stop : count_steps, NULL);
        rtcCommitScene(scene);
        expect(step == 2 ? RTC_ERROR_CANCELLED : RTC_ERROR_NONE, "a refit");
        CHECK(step == 2 || steps == 2, "a refit begins and ends: %d", steps);
        CHECK(distance(scene) == 3 + (step == 2 ? 1 : step), "step %d: %g", step, distance(scene));
    }
    /* What rests is moved all the same. */
    float(*p)[3] = rtcGetGeometryBufferData(rests, RTC_BUFFER_TYPE_VERTEX, 0);
    for (int i = 0; i < SIDE * SIDE; i++)
        p[i][2] = 1;
    rtcCommitGeometry(rests);
    rtcCommitScene(scene);
    CHECK(distance(scene) == 1, "it has moved: %g", distance(scene));
    rtcReleaseGeometry(moves);
    rtcReleaseGeometry(rests);
    rtcReleaseScene(scene);
}

/* Enough triangles for several threads, in a child as in its parent. */
static void a_child_commits(void)
{
    RTCDevice own = rtcNewDevice("threads = 2");
    RTCScene scene = rtcNewScene(own);
    RTCGeometry mesh = grid(own);
    rtcAttachGeometry(scene, mesh);
    rtcCommitScene(scene);
    CHECK(distance(scene) == 8, "the parent's: %g", distance(scene));
    fflush(NULL);
    pid_t child = fork();
    if (child == 0) {
        alarm(20);
        rtcCommitGeometry(mesh);
        rtcCommitScene(scene);
        _exit(distance(scene) == 8 && rtcGetDeviceError(own) == RTC_ERROR_NONE ? 0 : 1);
    }
    int status = 0;
    CHECK(waitpid(child, &status, 0) == child && WIFEXITED(status) && WEXITSTATUS(status) == 0, "the child: status %d", status);
    rtcReleaseGeometry(mesh);
    rtcReleaseScene(scene);
    rtcReleaseDevice(own);
}

static void settings(void)
{
    CHECK(rtcNewDevice("threads = x") == NULL, "blanks do not hide a mistake");
    CHECK(rtcGetDeviceError(NULL) == RTC_ERROR_INVALID_ARGUMENT, "it is told");
    CHECK(strstr(rtcGetDeviceLastErrorMessage(NULL), "threads=x"), "%s", rtcGetDeviceLastErrorMessage(NULL));
    RTCDevice other = rtcNewDevice(" threads = 2 , isa= avx2 verbose =0\n");
    CHECK(other != NULL, "blanks around names and values");
    rtcReleaseDevice(other);
}

int main(int count, char **arguments)
{
    (void)arguments;
    if (count > 1) {
        RTCDevice verbose = rtcNewDevice("verbose=1");
        rtcNewGeometry(verbose, (enum RTCGeometryType)77);
        enum RTCError code = rtcGetDeviceError(verbose);
        rtcReleaseDevice(verbose);
        return code == RTC_ERROR_INVALID_ARGUMENT ? 0 : 1;
    }
    device = rtcNewDevice("threads=2");
    functions_ask_about_their_scene();
    several_threads_join();
    what_is_an_edit();
    ids();
    monitors();
    refits(RTC_BUILD_QUALITY_MEDIUM);
    refits(RTC_BUILD_QUALITY_REFIT);
    a_child_commits();
    settings();
    expect(RTC_ERROR_NONE, "all that went before");
    rtcReleaseDevice(device);
    return finish();
}
