// SPDX-License-Identifier: GPL-3.0-or-later
// Grids by NanoVDB's own builder as files, with the values that its own reader finds: for the test of `src/nanovdb.rs`:
// GNURT_NANOVDB=FOLDER cargo test -p gnurt-anari --lib nanovdb -- --ignored
// c++ -std=c++17 -O1 nanovdb_judge.cpp -o judge && ./judge FOLDER (Debian: libnanovdb-dev)

#include <cstdio>
#include <fstream>
#include <string>

#include <nanovdb/NanoVDB.h>
#include <nanovdb/util/GridBuilder.h>
#include <nanovdb/util/Primitives.h>

/// Writes a grid, and the values of a box around its active ones in the order of the device.
template <typename Build>
void put(const std::string& name, nanovdb::GridHandle<>& handle)
{
    std::ofstream(name + ".grid", std::ios::binary).write(reinterpret_cast<const char*>(handle.data()), handle.size());
    const auto* grid = handle.grid<Build>();
    auto accessor = grid->getAccessor();
    auto box = grid->indexBBox();
    std::ofstream values(name + ".values", std::ios::binary);
    for (int z = box.min()[2] - 1; z <= box.max()[2] + 1; z++)
        for (int y = box.min()[1] - 1; y <= box.max()[1] + 1; y++)
            for (int x = box.min()[0] - 1; x <= box.max()[0] + 1; x++) {
                float value = static_cast<float>(accessor.getValue({x, y, z}));
                values.write(reinterpret_cast<const char*>(&value), sizeof value);
            }
    std::printf("%s: %zu bytes, type %d\n", name.c_str(), size_t(handle.size()), int(grid->gridType()));
}

int main(int, char** arguments)
{
    const std::string folder = std::string(arguments[1]) + "/";
    const nanovdb::Vec3d origin(1, 2, 3);
    using Vec = nanovdb::Vec3<float>;
    auto fog = nanovdb::createFogVolumeSphere<float>(7.0f, Vec(-3, 2, 1), 0.25f, 3.0f, origin);
    put<float>(folder + "float", fog);
    auto doubles = nanovdb::createFogVolumeSphere<double>(7.0, nanovdb::Vec3<double>(-3, 2, 1), 0.25, 3.0, origin);
    put<double>(folder + "double", doubles);
    using namespace nanovdb;
    auto four = createFogVolumeSphere<float, Fp4>(7.0f, Vec(-3, 2, 1), 0.25f, 3.0f, origin);
    put<Fp4>(folder + "fp4", four);
    auto eight = createFogVolumeSphere<float, Fp8>(7.0f, Vec(-3, 2, 1), 0.25f, 3.0f, origin);
    put<Fp8>(folder + "fp8", eight);
    auto sixteen = createFogVolumeSphere<float, Fp16>(7.0f, Vec(-3, 2, 1), 0.25f, 3.0f, origin);
    put<Fp16>(folder + "fp16", sixteen);
    auto varied = createFogVolumeSphere<float, FpN>(7.0f, Vec(-3, 2, 1), 0.25f, 3.0f, origin);
    put<FpN>(folder + "fpn", varied);
}
