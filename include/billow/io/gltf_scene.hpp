// Which mesh stands where: the node graph of a glTF file unfolded.
#pragma once

#include <array>

#include <glm/gtc/quaternion.hpp>
#include <glm/mat4x4.hpp>

#include <billow/io/gltf_accessor.hpp>

namespace billow::inline BILLOW_ABI::detail {

/// A mesh of the file at a place in the scene.
struct gltf_draw {
    int mesh = -1;
    glm::dmat4 to_scene{1};
};

[[nodiscard]] inline glm::dmat4 placement(const glm::dvec3& translation, const glm::dquat& rotation,
                                          const glm::dvec3& scale) {
    glm::dmat4 matrix = glm::mat4_cast(rotation);
    for (int i = 0; i < 3; ++i) matrix[i] *= scale[i];
    matrix[3] = glm::dvec4(translation, 1);
    return matrix;
}

/// The transform of a node to its parent; the identity for parts of the wrong length.
[[nodiscard]] inline glm::dmat4 local_matrix(const tinygltf::Node& node) {
    if (node.matrix.size() == 16) {
        glm::dmat4 matrix;
        for (int i = 0; i < 16; ++i)
            matrix[i / 4][i % 4] = node.matrix[static_cast<std::size_t>(i)];
        return matrix;
    }
    const auto& t = node.translation;
    const auto& r = node.rotation;
    const auto& s = node.scale;
    return placement(t.size() == 3 ? glm::dvec3(t[0], t[1], t[2]) : glm::dvec3(0),
                     r.size() == 4 ? glm::dquat(r[3], r[0], r[1], r[2]) : glm::dquat(1, 0, 0, 0),
                     s.size() == 3 ? glm::dvec3(s[0], s[1], s[2]) : glm::dvec3(1));
}

/// Places of EXT_mesh_gpu_instancing, relative to the node.
[[nodiscard]] inline expected<std::vector<glm::dmat4>> instance_matrices(
    gltf_document& document, const tinygltf::Value& extension) {
    std::array<gltf_column<float>, 3> columns;  // translation, rotation, scale
    std::size_t count = 0;
    bool has_any = false;
    if (extension.IsObject() && extension.Has("attributes")) {
        const tinygltf::Value& attributes = extension.Get("attributes");
        static constexpr std::array names{"TRANSLATION", "ROTATION", "SCALE"};
        for (std::size_t i = 0; i < names.size(); ++i) {
            if (!attributes.IsObject() || !attributes.Has(names[i])) continue;
            const tinygltf::Value& id = attributes.Get(names[i]);
            auto column = read_accessor<float>(document, id.IsInt() ? id.GetNumberAsInt() : -1,
                                               {i == 1 ? std::size_t{4} : std::size_t{3}});
            if (!column) return column.error();
            if (has_any && column->size() != count) {
                return document.fail(error_code::malformed,
                                     "has instances whose columns differ in length");
            }
            count = column->size();
            has_any = true;
            columns[i] = std::move(*column);
        }
    }
    if (!has_any) return std::vector<glm::dmat4>{glm::dmat4(1)};
    std::vector<glm::dmat4> matrices;
    matrices.reserve(count);
    const auto& [translations, rotations, scales] = columns;
    for (std::size_t i = 0; i < count; ++i) {
        const auto point = [i](const gltf_column<float>& column, double otherwise) {
            if (column.values.empty()) return glm::dvec3(otherwise);
            return glm::dvec3(column[i][0], column[i][1], column[i][2]);
        };
        glm::dquat rotation(1, 0, 0, 0);
        if (!rotations.values.empty()) {
            const float* r = rotations[i];
            rotation = glm::normalize(glm::dquat(r[3], r[0], r[1], r[2]));
        }
        matrices.push_back(placement(point(translations, 0), rotation, point(scales, 1)));
    }
    return matrices;
}

/// The nodes that the unfolding starts from: of the default scene, else of the first, else all that
/// are nobody's children.
[[nodiscard]] inline expected<std::vector<int>> root_nodes(const gltf_document& document) {
    const auto& model = document.model;
    if (!model.scenes.empty() || model.defaultScene >= 0) {
        const auto* scene = row(model.scenes, std::max(model.defaultScene, 0));
        if (scene == nullptr) {
            return document.fail(error_code::out_of_range, "its default scene does not exist");
        }
        return scene->nodes;
    }
    std::vector<bool> is_child(model.nodes.size(), false);
    for (const auto& node : model.nodes) {
        for (const int child : node.children) {
            if (row(model.nodes, child) != nullptr)
                is_child[static_cast<std::size_t>(child)] = true;
        }
    }
    std::vector<int> roots;
    for (std::size_t i = 0; i < is_child.size(); ++i) {
        if (!is_child[i]) roots.push_back(static_cast<int>(i));
    }
    if (roots.empty() && !model.nodes.empty()) {
        return document.fail(error_code::malformed, "its nodes form a circle");
    }
    return roots;
}

/// Every mesh of the scene at its place, in the order of the file. A file of meshes without nodes
/// shows each of them once.
///
/// Fails   out_of_range: a missing scene, node or mesh; malformed: a node that is reached twice, as
///         in a circle; too_large: more than `max_draws`.
[[nodiscard]] inline expected<std::vector<gltf_draw>> unfold_scene(gltf_document& document,
                                                                   std::size_t max_draws) {
    const auto& model = document.model;
    std::vector<gltf_draw> draws;
    if (model.nodes.empty() && model.scenes.empty()) {
        for (std::size_t i = 0; i < model.meshes.size(); ++i) {
            draws.push_back({static_cast<int>(i), glm::dmat4(1)});
        }
        return draws;
    }
    auto roots = root_nodes(document);
    if (!roots) return roots.error();

    struct visit {
        int node;
        glm::dmat4 to_scene;  // of the parent
    };
    std::vector<visit> pending;
    const auto push = [&](const std::vector<int>& nodes, const glm::dmat4& to_scene) {
        for (auto node = nodes.rbegin(); node != nodes.rend(); ++node) {
            pending.push_back({*node, to_scene});
        }
    };
    push(*roots, glm::dmat4(1));
    std::vector<bool> is_visited(model.nodes.size(), false);
    while (!pending.empty()) {
        const visit next = pending.back();
        pending.pop_back();
        const std::string what = "node " + std::to_string(next.node);
        const tinygltf::Node* node = row(model.nodes, next.node);
        if (node == nullptr)
            return document.fail(error_code::out_of_range, what + " does not exist");
        if (is_visited[static_cast<std::size_t>(next.node)]) {
            return document.fail(error_code::malformed,
                                 what + " is reached twice: the nodes are not a tree");
        }
        is_visited[static_cast<std::size_t>(next.node)] = true;

        const glm::dmat4 to_scene = next.to_scene * local_matrix(*node);
        if (node->mesh >= 0) {
            if (row(model.meshes, node->mesh) == nullptr) {
                return document.fail(error_code::out_of_range, what + " names a missing mesh");
            }
            const auto instancing = node->extensions.find("EXT_mesh_gpu_instancing");
            if (instancing == node->extensions.end()) {
                draws.push_back({node->mesh, to_scene});
            } else {
                auto places = instance_matrices(document, instancing->second);
                if (!places) return places.error();
                for (const auto& place : *places) draws.push_back({node->mesh, to_scene * place});
            }
            if (draws.size() > max_draws) {
                return document.fail(
                    error_code::too_large,
                    "places its meshes more than " + std::to_string(max_draws) + " times");
            }
        }
        push(node->children, to_scene);
    }
    return draws;
}

}  // namespace billow::inline BILLOW_ABI::detail
