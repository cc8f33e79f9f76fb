// SPDX-License-Identifier: GPL-3.0-or-later
// `rivals READER FILE COUNT`: as src/main.rs, by rapidobj, miniply and cgltf, whose sources `compare.py` is given.
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "miniply.h"
#include "rapidobj.hpp"
#define CGLTF_IMPLEMENTATION
#include "cgltf.h"

// Triangulated, with materials.
static size_t by_rapidobj(const char* file) {
    rapidobj::Result result = rapidobj::ParseFile(file, rapidobj::MaterialLibrary::Default(rapidobj::Load::Optional));
    if (result.error || !rapidobj::Triangulate(result)) exit(1);
    size_t triangles = 0;
    for (const auto& shape : result.shapes) triangles += shape.mesh.num_face_vertices.size();
    return triangles;
}

// Positions, normals and triangles.
static size_t by_miniply(const char* file) {
    miniply::PLYReader reader(file);
    if (!reader.valid()) exit(1);
    std::vector<float> positions, normals;
    std::vector<int> indices;
    uint32_t three[3], one[1];
    uint32_t vertices = 0, triangles = 0;
    for (; reader.has_element(); reader.next_element()) {
        if (reader.element_is(miniply::kPLYVertexElement) && reader.load_element() && reader.find_pos(three)) {
            vertices = reader.num_rows();
            positions.resize(vertices * 3);
            reader.extract_properties(three, 3, miniply::PLYPropertyType::Float, positions.data());
            if (reader.find_normal(three)) {
                normals.resize(vertices * 3);
                reader.extract_properties(three, 3, miniply::PLYPropertyType::Float, normals.data());
            }
        } else if (reader.element_is(miniply::kPLYFaceElement) && reader.load_element() && reader.find_indices(one)) {
            triangles = reader.num_triangles(one[0]);
            indices.resize(triangles * 3);
            reader.extract_triangles(one[0], positions.data(), vertices, miniply::PLYPropertyType::Int, indices.data());
        }
    }
    return triangles;
}

// All attributes as floats, and all indices.
static size_t by_cgltf(const char* file) {
    cgltf_options options = {};
    cgltf_data* data = nullptr;
    if (cgltf_parse_file(&options, file, &data) != cgltf_result_success) exit(1);
    if (cgltf_load_buffers(&options, data, file) != cgltf_result_success) exit(1);
    size_t triangles = 0;
    // A scene has all of them.
    std::vector<std::vector<float>> values;
    std::vector<std::vector<cgltf_uint>> indices;
    for (size_t m = 0; m < data->meshes_count; m++) {
        for (size_t p = 0; p < data->meshes[m].primitives_count; p++) {
            const cgltf_primitive& primitive = data->meshes[m].primitives[p];
            for (size_t a = 0; a < primitive.attributes_count; a++) {
                const cgltf_accessor* accessor = primitive.attributes[a].data;
                values.emplace_back(cgltf_accessor_unpack_floats(accessor, nullptr, 0));
                cgltf_accessor_unpack_floats(accessor, values.back().data(), values.back().size());
            }
            if (primitive.indices) {
                auto& order = indices.emplace_back(primitive.indices->count);
                cgltf_accessor_unpack_indices(primitive.indices, order.data(), sizeof(cgltf_uint), order.size());
                triangles += order.size() / 3;
            }
        }
    }
    cgltf_free(data);
    return triangles;
}

int main(int count, char** arguments) {
    if (count != 4) return 2;
    std::string reader = arguments[1];
    for (int i = 0; i < atoi(arguments[3]); i++) {
        auto begin = std::chrono::steady_clock::now();
        size_t triangles = reader == "rapidobj" ? by_rapidobj(arguments[2])
                           : reader == "miniply" ? by_miniply(arguments[2])
                                                 : by_cgltf(arguments[2]);
        std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
        printf("%.6f %zu\n", seconds.count(), triangles);
    }
}
