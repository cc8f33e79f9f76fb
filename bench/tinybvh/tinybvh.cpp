/* SPDX-License-Identifier: GPL-3.0-or-later */
/* tinybvh, Embree and our two C libraries on the same rays: single calls, one thread, builds and rays, in one process.
 *
 * tinybvh is one header, which is not kept here. Get `tiny_bvh.h` from its repository (github.com/jbikker/tinybvh), then:
 *
 *   cargo build --release -p gnurt-rays -p gnurt-embree
 *   g++ -O3 -march=native -std=c++20 -DNO_THREADED_BUILDS -I FOLDER_OF_tiny_bvh.h \
 *       -I bindings/rays/include -I bindings/embree/include bench/tinybvh/tinybvh.cpp -o tinybvh -ldl
 *   ./tinybvh --gnurt target/release --embree /usr/lib/x86_64-linux-gnu/libembree4.so.4 conference.obj dragon.ply bunny.bin
 *
 * Scenes are OBJ, binary PLY of triangles, or tinybvh's own files (`testdata/NAME.bin`). Options:
 *
 *   --embree FILE  a library of Embree 4, as often as there are versions to compare
 *   --size N       camera rays are N x N (512)
 *   --rounds N     rounds of rays (5); engines take turns in each, and each begins with another one
 *   --builds N     builds of each engine, by turns, too (3)
 *   --only TEXT    only engines with TEXT in "library mode", such as "tinybvh BVH8" or "gnurt"
 *   --optimize     also tinybvh's BVH8_CPU after Optimize(50, true), as its own benchmark has it: slow to build
 *   --json FILE    writes all numbers
 *   --pause        stops by SIGSTOP before the rays: let the machine become quiet, then `kill -CONT`
 *
 * Rays are made before the clock starts, 2,048 at a time, in each library's own form: tinybvh's have their reciprocals by
 * then, as in its benchmark. All begin at t = 0 and have directions of unit length. Times are processor seconds.
 * The first engine's answers are the reference; where another differs, brute force in doubles decides who is wrong. */
#include <algorithm>
#include <cfloat>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <fstream>
#include <functional>
#include <iterator>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include <dlfcn.h>

#include <gnurt/embree.h>
#include <gnurt/rays.h>

#define TINYBVH_IMPLEMENTATION
#define INST_IDX_BITS 10 // as its benchmark has it: a ray takes 128 bytes
#include "tiny_bvh.h"

static constexpr size_t CHUNK = 2048;
static constexpr float NEAR_ENOUGH = 1e-4f; // of a distance

[[noreturn]] static void fail(const std::string &what)
{
    fprintf(stderr, "tinybvh: %s\n", what.c_str());
    exit(1);
}

static double seconds(clockid_t clock)
{
    timespec now;
    clock_gettime(clock, &now);
    return now.tv_sec + 1e-9 * now.tv_nsec;
}

/* Vectors. */
struct V3 {
    float x, y, z;
};
static V3 operator+(V3 a, V3 b) { return { a.x + b.x, a.y + b.y, a.z + b.z }; }
static V3 operator-(V3 a, V3 b) { return { a.x - b.x, a.y - b.y, a.z - b.z }; }
static V3 operator*(float s, V3 a) { return { s * a.x, s * a.y, s * a.z }; }
static float dot(V3 a, V3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static V3 cross(V3 a, V3 b) { return { a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x }; }
static V3 unit(V3 a) { return (1 / std::sqrt(dot(a, a))) * a; }

/* Scenes. */
struct View {
    const char *scene;
    V3 eye, target, up;
    float fov_y;
    V3 light;
};
/* Those of `gnurt bench rays`. */
static const View VIEWS[] = {
    { "conference", { 31, 3.5f, 6.2f }, { 14, 13, 2.2f }, { 0, 0, 1 }, 62, { 18, 11, 7.5f } },
    { "dragon", { -0.006f, 0.16f, 0.32f }, { -0.006f, 0.122f, 0 }, { 0, 1, 0 }, 38, { 0.2f, 0.4f, 0.3f } },
    { "sponza", { -13, -0.6f, 3.2f }, { 5, 0.8f, 4.2f }, { 0, 0, 1 }, 65, { 0, 0, 12 } },
    { "office", { -1.9f, 2.9f, -1.9f }, { 0.6f, 1.9f, 0.8f }, { 0, 1, 0 }, 70, { 0.1f, 3.5f, 0.2f } },
    { "soda", { 2.4f, 1.7f, 5.9f }, { -0.8f, 1.1f, 0 }, { 0, 1, 0 }, 50, { 0.5f, 2.2f, 1.5f } },
    { "buddha", { 0.3f, 0.3f, 4.6f }, { -0.05f, 0, 0 }, { 0, 1, 0 }, 27, { 2, 3, 3 } },
};

struct Scene {
    std::string name;
    std::vector<float> vertices;   // rows of four
    std::vector<unsigned> indices; // rows of three
    std::vector<tinybvh::bvhvec4> corners;
    View view;
    float diagonal;

    size_t triangles() const { return indices.size() / 3; }
    V3 corner(size_t triangle, int k) const
    {
        const float *v = &vertices[4 * (size_t)indices[3 * triangle + k]];
        return { v[0], v[1], v[2] };
    }
    void add_vertex(float x, float y, float z)
    {
        for (float value : { x, y, z, 0.0f })
            vertices.push_back(value);
    }
};

static void read_obj(std::istream &file, Scene &scene)
{
    std::string line, word;
    while (std::getline(file, line)) {
        std::istringstream words(line);
        words >> word;
        if (line.rfind("v ", 0) == 0) {
            V3 v;
            words >> v.x >> v.y >> v.z;
            scene.add_vertex(v.x, v.y, v.z);
        } else if (line.rfind("f ", 0) == 0) {
            std::vector<unsigned> face;
            while (words >> word) {
                long index = atol(word.c_str()), count = (long)scene.vertices.size() / 4;
                face.push_back((unsigned)(index < 0 ? count + index : index - 1));
            }
            for (size_t k = 2; k < face.size(); k++)
                for (unsigned index : { face[0], face[k - 1], face[k] })
                    scene.indices.push_back(index);
        }
    }
}

/* Floats x, y, z and lists of a byte and ints, little-endian, without other properties. */
static void read_ply(std::istream &file, Scene &scene)
{
    std::string line;
    size_t vertices = 0, faces = 0;
    while (std::getline(file, line) && line.rfind("end_header", 0) != 0) {
        sscanf(line.c_str(), "element vertex %zu", &vertices);
        sscanf(line.c_str(), "element face %zu", &faces);
    }
    for (size_t i = 0; i < vertices; i++) {
        float v[3];
        file.read((char *)v, sizeof v);
        scene.add_vertex(v[0], v[1], v[2]);
    }
    for (size_t i = 0; i < faces; i++) {
        unsigned char count = 0;
        unsigned face[3];
        file.read((char *)&count, 1).read((char *)face, sizeof face);
        if (!file || count != 3)
            fail(scene.name + ": not a binary PLY file of triangles");
        scene.indices.insert(scene.indices.end(), face, face + 3);
    }
}

/* A count, then three times four floats of each triangle. */
static void read_tinybvh(std::istream &file, Scene &scene)
{
    unsigned count = 0;
    file.read((char *)&count, 4);
    for (unsigned i = 0; file && i < 3 * count; i++) {
        float v[4];
        file.read((char *)v, sizeof v);
        scene.add_vertex(v[0], v[1], v[2]);
        scene.indices.push_back(i);
    }
}

static Scene read_scene(const std::string &path)
{
    Scene scene;
    size_t from = path.find_last_of('/') + 1, dot_at = path.find_last_of('.');
    if (dot_at == std::string::npos || dot_at < from)
        fail(path + ": its name ends in .obj, .ply or .bin");
    std::string kind = path.substr(dot_at + 1);
    scene.name = path.substr(from, dot_at - from) + (kind == "bin" ? " (tinybvh)" : "");
    std::ifstream file(path, std::ios::binary);
    if (!file)
        fail(path + ": cannot be read");
    kind == "obj" ? read_obj(file, scene) : kind == "ply" ? read_ply(file, scene) : read_tinybvh(file, scene);
    if (!scene.triangles())
        fail(path + ": no triangles");
    V3 low = { FLT_MAX, FLT_MAX, FLT_MAX }, high = -1.0f * low;
    for (size_t i = 0; i < scene.triangles(); i++)
        for (int k = 0; k < 3; k++) {
            if (4 * (size_t)scene.indices[3 * i + k] >= scene.vertices.size())
                fail(path + ": a face has a vertex that is not there");
            V3 v = scene.corner(i, k);
            low = { std::min(low.x, v.x), std::min(low.y, v.y), std::min(low.z, v.z) };
            high = { std::max(high.x, v.x), std::max(high.y, v.y), std::max(high.z, v.z) };
            scene.corners.push_back({ v.x, v.y, v.z, 0 });
        }
    V3 extent = high - low, middle = 0.5f * (low + high);
    scene.diagonal = std::sqrt(dot(extent, extent));
    V3 eye = middle + scene.diagonal * V3 { 0.3f, 0.25f, 1.1f };
    scene.view = { "", eye, middle, { 0, 1, 0 }, 42, eye + scene.diagonal * V3 { 0.2f, 0.6f, 0 } };
    for (const View &view : VIEWS)
        if (kind != "bin" && scene.name.rfind(view.scene, 0) == 0)
            scene.view = view;
    return scene;
}

/* Rays. */
struct Ray {
    V3 org, dir;
    float t_far;
};
struct Class {
    const char *name;
    bool any;
    bool coherent;
    std::vector<Ray> rays;
};

static unsigned long long state = 1;

static float number()
{
    state = state * 6364136223846793005ull + 1442695040888963407ull;
    return (float)(state >> 40) / (1 << 24);
}

/* Through pixel centres, in tiles of 4 x 4 as tinybvh's benchmark has them. */
static std::vector<Ray> camera_rays(const View &view, int size)
{
    V3 forward = unit(view.target - view.eye), right = unit(cross(forward, view.up)), up = cross(right, forward);
    float half = std::tan(view.fov_y * (float)M_PI / 360);
    std::vector<Ray> rays;
    for (int tile = 0; tile < size / 4 * (size / 4); tile++)
        for (int k = 0; k < 16; k++) {
            int x = tile % (size / 4) * 4 + k % 4, y = tile / (size / 4) * 4 + k / 4;
            float sx = half * (2 * (x + 0.5f) / size - 1), sy = half * (1 - 2 * (y + 0.5f) / size);
            rays.push_back({ view.eye, unit(forward + sx * right + sy * up), INFINITY });
        }
    return rays;
}

static V3 cosine_direction(V3 normal)
{
    V3 across = unit(cross(normal, std::fabs(normal.x) < 0.7f ? V3 { 1, 0, 0 } : V3 { 0, 1, 0 })), other = cross(normal, across);
    float u = number(), angle = 2 * (float)M_PI * number(), radius = std::sqrt(u);
    return unit(std::sqrt(std::max(0.0f, 1 - u)) * normal + radius * std::cos(angle) * across + radius * std::sin(angle) * other);
}

static std::vector<Class> make_rays(const Scene &scene, int size)
{
    std::vector<Ray> primary = camera_rays(scene.view, size), shadow, diffuse;
    tinybvh::BVH8_CPU tree; // BVH has a least determinant of 1e-6: it does not see small triangles
    tree.Build(scene.corners.data(), (uint32_t)scene.triangles());
    state = 1;
    for (const Ray &ray : primary) {
        tinybvh::Ray seen({ ray.org.x, ray.org.y, ray.org.z }, { ray.dir.x, ray.dir.y, ray.dir.z });
        tree.Intersect(seen);
        if (seen.hit.t >= BVH_FAR)
            continue;
        V3 a = scene.corner(seen.hit.prim, 0), b = scene.corner(seen.hit.prim, 1), c = scene.corner(seen.hit.prim, 2);
        V3 normal = unit(cross(b - a, c - a));
        if (dot(normal, ray.dir) > 0)
            normal = -1.0f * normal;
        V3 at = ray.org + seen.hit.t * ray.dir + 1e-5f * scene.diagonal * normal, way = scene.view.light - at;
        float distance = std::sqrt(dot(way, way));
        shadow.push_back({ at, unit(way), distance });
        diffuse.push_back({ at, cosine_direction(normal), INFINITY });
    }
    return { { "primary", false, true, primary }, { "shadow, any hit", true, true, shadow },
             { "diffuse", false, false, diffuse }, { "diffuse, any hit", true, false, diffuse } };
}

/* Engines. */
struct Engine {
    std::string library, mode;
    virtual ~Engine() = default;
    virtual void build(const Scene &) = 0;
    virtual void free() = 0;
    virtual void prepare(const Ray *, size_t count, bool any) = 0;
    virtual void trace(size_t count, bool any, bool coherent) = 0;
    virtual float answer(size_t i, bool any) const = 0; // t, infinite for a miss; 0 for any hit
    Engine(std::string library, std::string mode) : library(std::move(library)), mode(std::move(mode)) {}
};

template <class Tree> struct Tiny : Engine {
    std::function<void(Tree &, const Scene &)> builder;
    std::unique_ptr<Tree> tree;
    alignas(64) tinybvh::Ray rays[CHUNK];
    bool occluded[CHUNK];

    Tiny(const char *mode, std::function<void(Tree &, const Scene &)> builder) : Engine("tinybvh", mode), builder(builder) {}
    void build(const Scene &scene) override
    {
        tree = std::make_unique<Tree>();
        builder(*tree, scene);
    }
    void free() override { tree.reset(); }
    void prepare(const Ray *some, size_t count, bool) override
    {
        for (size_t i = 0; i < count; i++) {
            const Ray &ray = some[i];
            rays[i] = tinybvh::Ray({ ray.org.x, ray.org.y, ray.org.z }, { ray.dir.x, ray.dir.y, ray.dir.z }, std::min(ray.t_far, BVH_FAR));
        }
    }
    void trace(size_t count, bool any, bool) override
    {
        if (any)
            for (size_t i = 0; i < count; i++)
                occluded[i] = tree->IsOccluded(rays[i]);
        else
            for (size_t i = 0; i < count; i++)
                tree->Intersect(rays[i]);
    }
    float answer(size_t i, bool any) const override
    {
        return any ? (occluded[i] ? 0 : INFINITY) : rays[i].hit.t < BVH_FAR ? rays[i].hit.t : INFINITY;
    }
};

template <class Tree> static std::unique_ptr<Engine> tiny(const char *mode, bool high, bool optimize = false)
{
    return std::make_unique<Tiny<Tree>>(mode, [high, optimize](Tree &tree, const Scene &scene) {
        if (high)
            tree.BuildHQ(scene.corners.data(), (uint32_t)scene.triangles());
        else
            tree.Build(scene.corners.data(), (uint32_t)scene.triangles());
        if (optimize)
            tree.Optimize(50, true);
    });
}

#define NAMED_CALLS(call)                                                                                              \
    call(rtcNewDevice) call(rtcGetDeviceError) call(rtcGetDeviceProperty) call(rtcNewScene) call(rtcNewGeometry) call(rtcSetSharedGeometryBuffer) \
    call(rtcCommitGeometry) call(rtcAttachGeometry) call(rtcSetSceneBuildQuality) call(rtcSetSceneFlags)                \
    call(rtcCommitScene) call(rtcIntersect1) call(rtcOccluded1) call(rtcReleaseScene) call(rtcReleaseGeometry)
#define OWN_CALLS(call)                                                                                                \
    call(gnurt_scene_new) call(gnurt_scene_free) call(gnurt_scene_options) call(gnurt_add_triangles) call(gnurt_commit) \
    call(gnurt_intersect) call(gnurt_occluded) call(gnurt_last_error)
#define DECLARE(name) decltype(&::name) name;
#define LOAD(call_name)                                                                                                \
    if (!(call_name = (decltype(call_name))dlsym(library, #call_name)))                                                \
        fail(path + ": no " #call_name);

static void *open_library(const std::string &path)
{
    void *library = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
    return library ? library : (fail(dlerror()), nullptr);
}

/* A library of Embree's names: Embree's own, or ours. */
struct Names {
    NAMED_CALLS(DECLARE)
    RTCDevice device;
    std::string version;
    explicit Names(const std::string &path)
    {
        void *library = open_library(path);
        NAMED_CALLS(LOAD)
        if (!(device = rtcNewDevice("threads=1,set_affinity=0")))
            fail(path + ": no device");
        for (RTCDeviceProperty part : { RTC_DEVICE_PROPERTY_VERSION_MAJOR, RTC_DEVICE_PROPERTY_VERSION_MINOR, RTC_DEVICE_PROPERTY_VERSION_PATCH })
            version.append(version.empty() ? "" : ".").append(std::to_string(rtcGetDeviceProperty(device, part)));
    }
};

struct Named : Engine {
    const Names &names;
    RTCBuildQuality quality;
    int flags;
    RTCScene tree = nullptr;
    RTCRayHit rays[CHUNK];

    Named(const std::string &library, const char *mode, const Names &names, RTCBuildQuality quality, int flags)
        : Engine(library, mode), names(names), quality(quality), flags(flags)
    {
    }
    void build(const Scene &scene) override
    {
        RTCGeometry geometry = names.rtcNewGeometry(names.device, RTC_GEOMETRY_TYPE_TRIANGLE);
        names.rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, scene.vertices.data(), 0, 16,
                                         scene.vertices.size() / 4);
        names.rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, scene.indices.data(), 0, 12,
                                         scene.triangles());
        names.rtcCommitGeometry(geometry);
        tree = names.rtcNewScene(names.device);
        names.rtcSetSceneBuildQuality(tree, quality);
        names.rtcSetSceneFlags(tree, (RTCSceneFlags)flags);
        names.rtcAttachGeometry(tree, geometry);
        names.rtcReleaseGeometry(geometry);
        names.rtcCommitScene(tree);
        if (int error = names.rtcGetDeviceError(names.device))
            fail(library + ": error " + std::to_string(error) + " at the build");
    }
    void free() override
    {
        if (tree)
            names.rtcReleaseScene(tree);
        tree = nullptr;
    }
    void prepare(const Ray *some, size_t count, bool) override
    {
        memset(rays, 0, count * sizeof *rays);
        for (size_t i = 0; i < count; i++) {
            RTCRay &ray = rays[i].ray;
            ray.org_x = some[i].org.x, ray.org_y = some[i].org.y, ray.org_z = some[i].org.z;
            ray.dir_x = some[i].dir.x, ray.dir_y = some[i].dir.y, ray.dir_z = some[i].dir.z;
            ray.tfar = some[i].t_far, ray.mask = ~0u;
            rays[i].hit.geomID = rays[i].hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
        }
    }
    void trace(size_t count, bool any, bool) override
    {
        if (any)
            for (size_t i = 0; i < count; i++)
                names.rtcOccluded1(tree, &rays[i].ray, nullptr);
        else
            for (size_t i = 0; i < count; i++)
                names.rtcIntersect1(tree, &rays[i], nullptr);
    }
    float answer(size_t i, bool any) const override
    {
        return any ? (rays[i].ray.tfar < 0 ? 0 : INFINITY)
                   : rays[i].hit.geomID != RTC_INVALID_GEOMETRY_ID ? rays[i].ray.tfar : INFINITY;
    }
};

/* gnurt/rays.h: `batch` rays a call. */
struct Own : Engine {
    OWN_CALLS(DECLARE)
    int quality;
    size_t batch;
    gnurt_scene *tree = nullptr;
    Ray rays[CHUNK];
    float t[CHUNK], u[CHUNK], v[CHUNK];
    uint32_t prim_id[CHUNK];
    uint8_t occluded[CHUNK];

    Own(const std::string &path, const char *mode, int quality, size_t batch) : Engine("rays.h", mode), quality(quality), batch(batch)
    {
        void *library = open_library(path);
        OWN_CALLS(LOAD)
    }
    void check(int answer) const
    {
        if (answer)
            fail(gnurt_last_error());
    }
    void build(const Scene &scene) override
    {
        tree = gnurt_scene_new();
        gnurt_build options = {};
        options.quality = quality, options.threads = 1;
        check(gnurt_scene_options(tree, &options));
        check(gnurt_add_triangles(tree, { scene.vertices.data(), scene.vertices.size() / 4, 16, GNURT_F32 },
                                  { scene.indices.data(), scene.triangles(), 0, GNURT_U32 }, ~0u, nullptr));
        check(gnurt_commit(tree));
    }
    void free() override
    {
        gnurt_scene_free(tree);
        tree = nullptr;
    }
    void prepare(const Ray *some, size_t count, bool) override { std::copy(some, some + count, rays); }
    void trace(size_t count, bool any, bool coherent) override
    {
        gnurt_query query = {};
        query.threads = 1, query.coherent = coherent;
        for (size_t i = 0; i < count; i += batch) {
            size_t some = std::min(batch, count - i);
            gnurt_rays asked = {};
            asked.count = some;
            asked.origins = { &rays[i].org, some, sizeof(Ray), GNURT_F32 };
            asked.directions = { &rays[i].dir, some, sizeof(Ray), GNURT_F32 };
            asked.t_far = { &rays[i].t_far, some, sizeof(Ray), GNURT_F32 };
            gnurt_hits hits = {};
            hits.t = t + i, hits.u = u + i, hits.v = v + i, hits.prim_id = prim_id + i;
            check(any ? gnurt_occluded(tree, &asked, &query, occluded + i) : gnurt_intersect(tree, &asked, &query, &hits));
        }
    }
    float answer(size_t i, bool any) const override { return any ? (occluded[i] ? 0 : INFINITY) : t[i]; }
};

/* The nearest hit by brute force in doubles. */
static float truth(const Scene &scene, const Ray &ray)
{
    double nearest = ray.t_far, o[3] = { ray.org.x, ray.org.y, ray.org.z }, d[3] = { ray.dir.x, ray.dir.y, ray.dir.z };
    bool found = false;
    for (size_t i = 0; i < scene.triangles(); i++) {
        V3 corners[3] = { scene.corner(i, 0), scene.corner(i, 1), scene.corner(i, 2) };
        double p[3][3], e[2][3];
        for (int k = 0; k < 3; k++)
            p[k][0] = corners[k].x, p[k][1] = corners[k].y, p[k][2] = corners[k].z;
        for (int k = 0; k < 3; k++)
            e[0][k] = p[1][k] - p[0][k], e[1][k] = p[2][k] - p[0][k];
        auto times = [](const double *a, const double *b, double *c) {
            c[0] = a[1] * b[2] - a[2] * b[1], c[1] = a[2] * b[0] - a[0] * b[2], c[2] = a[0] * b[1] - a[1] * b[0];
        };
        auto along = [](const double *a, const double *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; };
        double h[3], q[3], s[3] = { o[0] - p[0][0], o[1] - p[0][1], o[2] - p[0][2] };
        times(d, e[1], h), times(s, e[0], q);
        double det = along(e[0], h), u = along(s, h) / det, v = along(d, q) / det, t = along(e[1], q) / det;
        if (det != 0 && u >= 0 && v >= 0 && u + v <= 1 && t > 0 && t < nearest)
            nearest = t, found = true;
    }
    return found ? (float)nearest : INFINITY;
}

static bool same(float a, float b) { return a == b || std::fabs(a - b) <= NEAR_ENOUGH * std::min(a, b); }

static double median(std::vector<double> values)
{
    std::sort(values.begin(), values.end());
    size_t half = values.size() / 2;
    return values.size() % 2 ? values[half] : 0.5 * (values[half - 1] + values[half]);
}

struct Measured {
    std::vector<double> rates; // million rays per second, of each round
    std::vector<float> answers;
    size_t other = 0, wrong = 0;
};

static void trace_all(Engine &engine, const Class &some, size_t rays, Measured *into)
{
    double spent = 0;
    for (size_t from = 0; from < rays; from += CHUNK) {
        size_t count = std::min(CHUNK, rays - from);
        engine.prepare(&some.rays[from], count, some.any);
        double start = seconds(CLOCK_THREAD_CPUTIME_ID);
        engine.trace(count, some.any, some.coherent);
        spent += seconds(CLOCK_THREAD_CPUTIME_ID) - start;
        if (into && into->rates.empty())
            for (size_t i = 0; i < count; i++)
                into->answers.push_back(engine.answer(i, some.any));
    }
    if (into)
        into->rates.push_back(rays / 1e6 / spent);
}

int main(int count, char **words)
{
    int size = 512, rounds = 5, builds = 3;
    bool optimize = false, pause = false;
    std::string gnurt, json, only, versions;
    std::vector<std::string> paths, embrees;
    for (int i = 1; i < count; i++) {
        std::string word = words[i];
        auto value = [&] { return i + 1 < count ? std::string(words[++i]) : (fail(word + ": a value is missing"), ""); };
        if (word == "--size")
            size = atoi(value().c_str()) / 4 * 4;
        else if (word == "--rounds")
            rounds = atoi(value().c_str());
        else if (word == "--builds")
            builds = atoi(value().c_str());
        else if (word == "--only")
            only = value();
        else if (word == "--optimize")
            optimize = true;
        else if (word == "--pause")
            pause = true;
        else if (word == "--gnurt")
            gnurt = value();
        else if (word == "--embree")
            embrees.push_back(value());
        else if (word == "--json")
            json = value();
        else if (word[0] == '-')
            fail(word + ": unknown");
        else
            paths.push_back(word);
    }
    if (paths.empty() || size < 4 || rounds < 1 || builds < 1)
        fail("tinybvh [--gnurt FOLDER] [--embree LIBRARY]... [--size N] [--rounds N] [--builds N] [--only TEXT] [--optimize] [--pause] [--json FILE] SCENE...");

    std::vector<std::unique_ptr<Names>> libraries;
    std::vector<std::unique_ptr<Engine>> engines;
    auto named = [&](const std::string &library, const char *mode, RTCBuildQuality quality, int flags) {
        engines.push_back(std::make_unique<Named>(library, mode, *libraries.back(), quality, flags));
    };
    if (!gnurt.empty()) {
        libraries.push_back(std::make_unique<Names>(gnurt + "/libgnurt_embree.so"));
        named("gnurt", "medium", RTC_BUILD_QUALITY_MEDIUM, 0);
        named("gnurt", "high", RTC_BUILD_QUALITY_HIGH, 0);
        engines.push_back(std::make_unique<Own>(gnurt + "/libgnurt_rays.so", "high, 1 a call", 1, 1));
        engines.push_back(std::make_unique<Own>(gnurt + "/libgnurt_rays.so", "high, 2048 a call", 1, CHUNK));
    }
    for (const std::string &path : embrees) {
        libraries.push_back(std::make_unique<Names>(path));
        std::string name = "embree " + libraries.back()->version;
        versions += (versions.empty() ? "" : ", ") + libraries.back()->version;
        named(name, "medium", RTC_BUILD_QUALITY_MEDIUM, 0);
        named(name, "high", RTC_BUILD_QUALITY_HIGH, 0);
        named(name, "medium, robust", RTC_BUILD_QUALITY_MEDIUM, RTC_SCENE_FLAG_ROBUST);
    }
    engines.push_back(tiny<tinybvh::BVH8_CPU>("BVH8_CPU", false));
    engines.push_back(tiny<tinybvh::BVH8_CPU>("BVH8_CPU, HQ", true));
    if (optimize)
        engines.push_back(tiny<tinybvh::BVH8_CPU>("BVH8_CPU, optimized", false, true));
    engines.push_back(tiny<tinybvh::BVH4_CPU>("BVH4_CPU, HQ", true));
    engines.push_back(tiny<tinybvh::BVH_SoA>("BVH_SoA, HQ", true));
    std::erase_if(engines, [&](auto &engine) { return (engine->library + ' ' + engine->mode).find(only) == std::string::npos; });
    if (engines.empty())
        fail(only + ": no such engine");

    std::ostringstream out;
    out << "{\n\"tinybvh\": \"" << TINY_BVH_VERSION_MAJOR << '.' << TINY_BVH_VERSION_MINOR << '.' << TINY_BVH_VERSION_SUB << "\", \"embree\": \""
        << versions << "\", \"compiler\": \"" << __VERSION__ << "\",\n\"size\": " << size << ", \"rounds\": " << rounds << ", \"builds\": " << builds
        << ",\n\"scenes\": [";
    printf("tinybvh %d.%d.%d, Embree %s\n", TINY_BVH_VERSION_MAJOR, TINY_BVH_VERSION_MINOR, TINY_BVH_VERSION_SUB, versions.c_str());
    for (const std::string &path : paths) {
        Scene scene = read_scene(path);
        std::vector<Class> classes = make_rays(scene, size);
        printf("\n%s: %zu triangles; %zu camera rays, %zu points\n", scene.name.c_str(), scene.triangles(), classes[0].rays.size(), classes[1].rays.size());

        std::vector<std::vector<double>> build(engines.size());
        for (int round = 0; round < builds; round++)
            for (size_t e = 0; e < engines.size(); e++) {
                engines[e]->free();
                double start = seconds(CLOCK_PROCESS_CPUTIME_ID);
                engines[e]->build(scene);
                build[e].push_back(seconds(CLOCK_PROCESS_CPUTIME_ID) - start);
            }
        fflush(stdout);
        if (pause)
            raise(SIGSTOP);

        std::vector<std::vector<Measured>> measured(engines.size(), std::vector<Measured>(classes.size()));
        for (int round = 0; round < rounds; round++)
            for (size_t c = 0; c < classes.size(); c++)
                for (size_t turn = 0; turn < engines.size(); turn++) {
                    size_t e = (turn + round) % engines.size();
                    trace_all(*engines[e], classes[c], classes[c].rays.size() / 16, nullptr); // warms its caches
                    trace_all(*engines[e], classes[c], classes[c].rays.size(), &measured[e][c]);
                }
        if (pause) {
            printf("rays are done\n");
            fflush(stdout);
        }

        std::vector<size_t> disputed(classes.size());
        for (size_t c = 0; c < classes.size(); c++)
            for (size_t i = 0; i < classes[c].rays.size(); i++) {
                auto reference = measured[0][c].answers[i];
                bool agreed = true;
                for (auto &of : measured)
                    if (!same(of[c].answers[i], reference))
                        of[c].other++, agreed = false;
                if (agreed || ++disputed[c] > 1000)
                    continue;
                float right = truth(scene, classes[c].rays[i]);
                if (classes[c].any && right < INFINITY)
                    right = 0;
                for (auto &of : measured)
                    of[c].wrong += !same(of[c].answers[i], right);
            }

        out << (&path == &paths[0] ? "\n" : ",\n") << " {\"scene\": \"" << scene.name << "\", \"triangles\": " << scene.triangles() << ", \"rays\": {";
        for (size_t c = 0; c < classes.size(); c++)
            out << (c ? ", " : "") << '"' << classes[c].name << "\": " << classes[c].rays.size();
        out << "},\n  \"engines\": [";
        printf("%-12s %-20s %9s", "library", "mode", "build, s");
        for (const Class &some : classes)
            printf(" | %-16s %8s %5s", some.name, "other", "wrong");
        printf("\n");
        for (size_t e = 0; e < engines.size(); e++) {
            printf("%-12s %-20s %9.3f", engines[e]->library.c_str(), engines[e]->mode.c_str(), median(build[e]));
            out << (e ? ",\n" : "\n") << "   {\"library\": \"" << engines[e]->library << "\", \"mode\": \"" << engines[e]->mode << "\", \"build_s\": " << median(build[e]) << ", \"classes\": [";
            for (size_t c = 0; c < classes.size(); c++) {
                const Measured &of = measured[e][c];
                auto [least, most] = std::minmax_element(of.rates.begin(), of.rates.end());
                double share = (double)of.other / of.answers.size();
                printf(" | %16.2f %7.4f%% %5zu", median(of.rates), 100 * share, of.wrong);
                size_t hits = std::count_if(of.answers.begin(), of.answers.end(), [](float t) { return t < INFINITY; });
                out << (c ? ",\n" : "\n") << "    {\"class\": \"" << classes[c].name << "\", \"million_rays_per_s\": " << median(of.rates) << ", \"least\": " << *least
                    << ", \"most\": " << *most << ", \"hits\": " << hits << ", \"other_than_first\": " << of.other << ", \"wrong_of_disputed\": " << of.wrong
                    << ", \"disputed\": " << disputed[c] << "}";
            }
            printf("\n");
            out << "]}";
            engines[e]->free();
        }
        out << "]}";
    }
    out << "\n]\n}\n";
    if (!json.empty() && !(std::ofstream(json) << out.str()))
        fail(json + ": cannot be written");
    return 0;
}
