// SPDX-License-Identifier: GPL-3.0-or-later
// How thick the walls of a hollow ball are: all hits of rays from its middle. c++ hollow.cpp -lgnurt
#include <gnurt/rays.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <vector>

struct Free {
    void operator()(gnurt_scene *scene) const { gnurt_scene_free(scene); }
};

static bool fails(int status)
{
    if (status != 0)
        std::fprintf(stderr, "%s\n", gnurt_last_error());
    return status != 0;
}

int main()
{
    const std::vector<std::array<float, 3>> centers = { { 0, 0, 0 }, { 0, 0, 0.25f } };
    const std::vector<float> radii = { 2, 1 };
    std::unique_ptr<gnurt_scene, Free> scene(gnurt_scene_new());
    const gnurt_array at = { centers.data(), centers.size(), 0, GNURT_F32 };
    const gnurt_array size = { radii.data(), radii.size(), 0, GNURT_F32 };
    if (fails(gnurt_add_spheres(scene.get(), at, size, 1, nullptr)) || fails(gnurt_commit(scene.get())))
        return 1;

    std::vector<std::array<float, 3>> directions;
    for (int i = 0; i <= 8; i++) {
        const double angle = 3.14159265358979 * i / 8;
        directions.push_back({ float(std::sin(angle)), 0, float(std::cos(angle)) });
    }
    const std::array<float, 3> middle = { 0, 0, 0.25f };
    gnurt_rays rays = {};
    rays.count = directions.size();
    rays.origins = { middle.data(), 1, 0, GNURT_F32 }; // one for all
    rays.directions = { directions.data(), directions.size(), 0, GNURT_F32 };
    std::vector<std::size_t> ends(rays.count);
    std::vector<float> t(2 * rays.count);
    gnurt_hits hits = {};
    hits.t = t.data();
    if (fails(gnurt_all_hits(scene.get(), &rays, nullptr, 2, ends.data(), t.size(), &hits)))
        return 1;
    for (std::size_t i = 0; i < rays.count; i++)
        std::printf("%3d degrees: %.3f\n", int(22.5 * double(i)), double(t[ends[i] - 1] - t[ends[i] - 2]));
    return 0;
}
