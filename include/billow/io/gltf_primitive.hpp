// A primitive of a glTF mesh as triangles of its own vertices, in the space of its node.
#pragma once

#include <array>
#include <map>

#include <billow/io/gltf_accessor.hpp>
#include <billow/io/loaded_mesh.hpp>
#include <billow/mesh/mesh.hpp>

namespace billow::inline BILLOW_ABI::detail {

/// Columns hold one row a vertex, or none.
struct gltf_primitive {
    int material = -1;
    std::vector<vec3> positions{};
    std::vector<vec3> normals{};
    std::vector<vec4> tangents{};
    std::array<std::vector<vec2>, uv_set_count> uv_sets{};
    std::vector<vec4> colors{};
    std::vector<std::uint32_t> feature_ids{};
    std::vector<uvec3> triangles{};

    /// Gives every face its own corners and its own normal, as glTF asks for where normals lack.
    void make_flat() {
        const auto unfold = [&](auto& column) {
            if (column.empty()) return;
            std::remove_reference_t<decltype(column)> unfolded;
            unfolded.reserve(triangles.size() * 3);
            for (const uvec3& t : triangles) {
                for (int c = 0; c < 3; ++c) unfolded.push_back(column[t[c]]);
            }
            column = std::move(unfolded);
        };
        unfold(positions);
        unfold(tangents);
        for (auto& uv_set : uv_sets) unfold(uv_set);
        unfold(colors);
        unfold(feature_ids);
        normals.resize(positions.size());
        for (std::size_t i = 0; i < triangles.size(); ++i) {
            const auto first = static_cast<std::uint32_t>(i * 3);
            triangles[i] = uvec3(first, first + 1, first + 2);
            const dvec3 a(positions[first]);
            const dvec3 b(positions[first + 1]);
            const dvec3 c(positions[first + 2]);
            const dvec3 across = glm::cross(b - a, c - a);
            const double length = glm::length(across);
            const vec3 normal(length > 0 ? across / length : dvec3(0, 0, 1));
            std::fill_n(normals.begin() + static_cast<std::ptrdiff_t>(first), 3, normal);
        }
    }
};

/// Number of triangles that `count` indices make in a mode of glTF; 0 for points and lines.
[[nodiscard]] inline std::size_t triangle_count(int mode, std::size_t count) {
    if (mode == TINYGLTF_MODE_TRIANGLES) return count / 3;
    return mode >= TINYGLTF_MODE_TRIANGLE_STRIP && count >= 3 ? count - 2 : 0;
}

/// Positions in the index column of the i-th triangle's corners, all front sides alike.
[[nodiscard]] inline std::array<std::size_t, 3> corners_of(int mode, std::size_t i) {
    switch (mode) {
        case TINYGLTF_MODE_TRIANGLE_STRIP:
            return {i, i + 1 + i % 2, i + 2 - i % 2};
        case TINYGLTF_MODE_TRIANGLE_FAN:
            return {i + 1, i + 2, 0};
        default:
            return {3 * i, 3 * i + 1, 3 * i + 2};
    }
}

/// Reads primitives. Decoded accessors are kept, since primitives like to share them.
class gltf_primitive_reader {
public:
    gltf_primitive_reader(gltf_document& document, loaded_mesh& target)
        : document_(document), target_(target) {}

    /// Needs   a primitive of triangles with positions.
    [[nodiscard]] expected<gltf_primitive> read(const tinygltf::Primitive& from) {
        const auto attribute = [&](const char* name) {
            const auto found = from.attributes.find(name);
            return found == from.attributes.end() ? -1 : found->second;
        };
        auto positions = column(attribute("POSITION"), {3});
        if (!positions) return positions.error();
        const std::size_t vertex_count = (*positions)->size();
        if (vertex_count >= no_id) {
            return document_.fail(error_code::too_large, "has a primitive of 2^32 vertices");
        }

        gltf_primitive to;
        to.material = from.material;
        auto used = read_triangles(from, vertex_count, to);
        if (!used) return used.error();
        const std::vector<std::uint32_t>& vertices = *used;

        // Copies the rows of the vertices in use.
        const auto fill = [&](const char* name, std::initializer_list<std::size_t> widths,
                              auto& column_to, const auto& convert) -> expected<done> {
            const int id = attribute(name);
            if (id < 0) return done{};
            auto values = column(id, widths);
            if (!values) return values.error();
            if ((*values)->size() != vertex_count) {
                return document_.fail(error_code::malformed,
                                      std::string("has a primitive of ") +
                                          std::to_string(vertex_count) + " positions, but " +
                                          std::to_string((*values)->size()) + " of " + name);
            }
            column_to.reserve(vertices.size());
            for (const std::uint32_t v : vertices) {
                column_to.push_back(convert((**values)[v], (*values)->width));
            }
            return done{};
        };
        const auto as_vec2 = [&](const float* v, std::size_t) {
            if (std::isfinite(v[0]) && std::isfinite(v[1])) return vec2(v[0], v[1]);
            target_.note("texture coordinates that are not finite are set to 0");
            return vec2(0);
        };
        const auto as_vec3 = [](const float* v, std::size_t) { return vec3(v[0], v[1], v[2]); };
        const auto as_vec4 = [](const float* v, std::size_t) {
            return vec4(v[0], v[1], v[2], v[3]);
        };
        const auto as_color = [](const float* v, std::size_t width) {
            vec4 color(1);
            for (std::size_t c = 0; c < width; ++c) {
                if (std::isfinite(v[c])) color[static_cast<int>(c)] = std::clamp(v[c], 0.0f, 1.0f);
            }
            return color;
        };
        const auto as_id = [](const float* v, std::size_t) {
            const double id = std::round(static_cast<double>(*v));
            return id >= 0 && id < no_id ? static_cast<std::uint32_t>(id) : no_id;
        };
        for (const auto& filled :
             {fill("POSITION", {3}, to.positions, as_vec3),
              fill("NORMAL", {3}, to.normals, as_vec3), fill("TANGENT", {4}, to.tangents, as_vec4),
              fill("TEXCOORD_0", {2}, to.uv_sets[0], as_vec2),
              fill("TEXCOORD_1", {2}, to.uv_sets[1], as_vec2),
              fill("COLOR_0", {3, 4}, to.colors, as_color),
              fill("_FEATURE_ID_0", {1}, to.feature_ids, as_id)}) {
            if (!filled) return filled.error();
        }
        return to;
    }

private:
    /// Fills the triangles of `to` with ids among the vertices in use, and gives these, in the order of use.
    [[nodiscard]] expected<std::vector<std::uint32_t>> read_triangles(
        const tinygltf::Primitive& from, std::size_t vertex_count, gltf_primitive& to) {
        std::vector<std::uint32_t> indices;
        std::uint32_t restart = no_id;
        if (from.indices >= 0) {
            auto read = read_accessor<std::uint32_t>(document_, from.indices, {1});
            if (!read) return read.error();
            indices = std::move(read->values);
            const auto& accessor =
                document_.model.accessors[static_cast<std::size_t>(from.indices)];
            restart >>= 32 - 8 * component_size(accessor.componentType);
        } else {
            indices.resize(vertex_count);
            for (std::size_t i = 0; i < vertex_count; ++i)
                indices[i] = static_cast<std::uint32_t>(i);
        }
        const std::size_t count = triangle_count(from.mode, indices.size());
        to.triangles.reserve(count);
        std::vector<std::uint32_t> used;
        if (new_ids_.size() < vertex_count) new_ids_.resize(vertex_count, no_id);
        for (std::size_t i = 0; i < count; ++i) {
            uvec3 triangle;
            int c = 0;
            for (const std::size_t corner : corners_of(from.mode, i)) {
                const std::uint32_t index = indices[corner];
                if (index == restart) {
                    return document_.fail(
                        error_code::malformed,
                        "has primitive restart in its indices, which glTF forbids");
                }
                if (index >= vertex_count) {
                    return document_.fail(error_code::out_of_range,
                                          "has index " + std::to_string(index) +
                                              " in a primitive of " + std::to_string(vertex_count) +
                                              " vertices");
                }
                std::uint32_t& new_id = new_ids_[index];
                if (new_id == no_id) {
                    new_id = static_cast<std::uint32_t>(used.size());
                    used.push_back(index);
                }
                triangle[c++] = new_id;
            }
            to.triangles.push_back(triangle);
        }
        for (const std::uint32_t v : used) new_ids_[v] = no_id;
        return used;
    }

    [[nodiscard]] expected<const gltf_column<float>*> column(
        int accessor_id, std::initializer_list<std::size_t> widths) {
        const auto known = columns_.find(accessor_id);
        if (known != columns_.end() &&
            std::find(widths.begin(), widths.end(), known->second.width) != widths.end()) {
            return &known->second;
        }
        auto read = read_accessor<float>(document_, accessor_id, widths);
        if (!read) return read.error();
        return &columns_.insert_or_assign(accessor_id, std::move(*read)).first->second;
    }

    gltf_document& document_;
    loaded_mesh& target_;
    std::map<int, gltf_column<float>> columns_{};
    std::vector<std::uint32_t> new_ids_{};  // all no_id between two primitives
};

}  // namespace billow::inline BILLOW_ABI::detail
