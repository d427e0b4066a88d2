// glTF 2.0 in: .gltf and .glb, the default scene flattened into one mesh.
//
// Source: glTF 2.0 Specification, Khronos Group 2021, and the extensions' own texts.
#pragma once

#include <cmath>

#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include <billow/io/gltf_material.hpp>
#include <billow/io/gltf_parse.hpp>
#include <billow/io/gltf_primitive.hpp>
#include <billow/io/gltf_scene.hpp>
#include <billow/mesh/validate.hpp>

namespace billow::inline BILLOW_ABI {

namespace detail {

/// Normal matrix of a transform: cofactors, which unlike the inverse exist for flat scales too.
[[nodiscard]] inline glm::dmat3 normal_matrix(const glm::dmat3& m) {
    return glm::dmat3(glm::cross(m[1], m[2]), glm::cross(m[2], m[0]), glm::cross(m[0], m[1]));
}

/// `v` at unit length; zero where it has none.
[[nodiscard]] inline vec3 unit_or_zero(const dvec3& v) {
    const double length = glm::length(v);
    return std::isfinite(length) && length > 0 ? vec3(v / length) : vec3(0);
}

/// Replaces normals without direction by those of the faces around. Gives how many there were.
inline std::size_t repair_normals(mesh& m) {
    const auto is_bad = [&](std::uint32_t v) { return m.normals[v] == vec3(0); };
    const auto count =
        static_cast<std::size_t>(std::count(m.normals.begin(), m.normals.end(), vec3(0)));
    if (count == 0) return 0;
    std::vector<dvec3> sums(m.vertex_count(), dvec3(0));
    for (std::size_t face = 0; face < m.face_count(); ++face) {
        const auto [a, b, c] = m.corners(static_cast<face_id>(face));
        const dvec3 across = glm::cross(dvec3(b) - dvec3(a), dvec3(c) - dvec3(a));
        for (int i = 0; i < 3; ++i) sums[m.triangles[face][i]] += across;
    }
    for (std::uint32_t v = 0; v < sums.size(); ++v) {
        if (!is_bad(v)) continue;
        const vec3 normal = unit_or_zero(sums[v]);
        m.normals[v] = normal == vec3(0) ? vec3(0, 0, 1) : normal;
    }
    return count;
}

/// Reads the default scene in the order: where meshes stand, what is in them, all together.
class gltf_flattener {
public:
    gltf_flattener(gltf_document& document, const read_options& options)
        : document_(document), options_(options) {}

    [[nodiscard]] expected<loaded_mesh> run() {
        auto draws = unfold_scene(document_, options_.max_faces);
        if (!draws) return draws.error();
        if (document_.has_animations) target_.note("animation and skin are left out: bind pose");
        if (auto done = check_size(*draws); !done) return done.error();
        if (auto done = read_primitives(*draws); !done) return done.error();
        choose_columns();
        for (const gltf_draw& draw : *draws) {
            for (const std::size_t id : primitives_of_mesh_[draw.mesh]) {
                append(primitives_[id], materials_of_primitive_[id], draw.to_scene);
                ++target_.instances;
            }
        }
        if (auto valid = validate(target_.mesh); !valid) {
            return document_.fail(valid.error().code, valid.error().message);
        }
        if (repair_normals(target_.mesh) > 0) target_.note("normals of no direction are replaced");
        drop_textures_without_uv();
        return std::move(target_);
    }

private:
    [[nodiscard]] static bool is_read(const tinygltf::Primitive& primitive) {
        return primitive.mode >= TINYGLTF_MODE_TRIANGLES &&
               primitive.attributes.contains("POSITION");
    }

    /// Refuses what would unfold to more faces than wanted, before anything is decoded.
    [[nodiscard]] expected<done> check_size(const std::vector<gltf_draw>& draws) {
        std::uint64_t faces = 0;
        for (const gltf_draw& draw : draws) {
            const auto& mesh = document_.model.meshes[static_cast<std::size_t>(draw.mesh)];
            for (const auto& primitive : mesh.primitives) {
                if (!is_read(primitive)) continue;
                const int counted = primitive.indices >= 0 ? primitive.indices
                                                           : primitive.attributes.at("POSITION");
                const auto* accessor = row(document_.model.accessors, counted);
                // The count is a claim so far, so it may be beyond everything.
                const std::size_t most = options_.max_faces + 1;
                if (accessor != nullptr) {
                    faces += std::min(most, triangle_count(primitive.mode, accessor->count));
                }
                if (faces > options_.max_faces) {
                    return document_.fail(
                        error_code::too_large,
                        "claims more than " + std::to_string(options_.max_faces) + " faces");
                }
            }
        }
        return done{};
    }

    [[nodiscard]] expected<done> read_primitives(const std::vector<gltf_draw>& draws) {
        gltf_primitive_reader reader(document_, target_);
        gltf_materials materials(document_, target_);
        for (const gltf_draw& draw : draws) {
            const auto [entry, is_new] = primitives_of_mesh_.try_emplace(draw.mesh);
            if (!is_new) continue;
            const auto& mesh = document_.model.meshes[static_cast<std::size_t>(draw.mesh)];
            for (const auto& source : mesh.primitives) {
                if (source.mode < 0 || source.mode > TINYGLTF_MODE_TRIANGLE_FAN) {
                    return document_.fail(error_code::malformed, "has a primitive of unknown mode");
                }
                if (!source.targets.empty()) target_.note("morph targets are left out: base shape");
                if (!is_read(source)) {
                    ++target_.skipped_primitives;
                    continue;
                }
                if (needs_draco(source)) {
                    return document_.fail(error_code::unsupported,
                                          "is compressed with Draco, which billow does not read; "
                                          "decompress it first: gltf-transform copy IN OUT");
                }
                auto primitive = reader.read(source);
                if (!primitive) return primitive.error();
                auto material = materials.use(source.material);
                if (!material) return material.error();
                entry->second.push_back(primitives_.size());
                primitives_.push_back(std::move(*primitive));
                materials_of_primitive_.push_back(*material);
            }
        }
        target_.primitives = primitives_.size();
        return done{};
    }

    /// Whether the uncompressed form that the extension allows beside it is missing.
    [[nodiscard]] bool needs_draco(const tinygltf::Primitive& primitive) const {
        if (!primitive.extensions.contains("KHR_draco_mesh_compression")) return false;
        const auto* positions = row(document_.model.accessors, primitive.attributes.at("POSITION"));
        return positions != nullptr && positions->bufferView < 0;
    }

    /// A column is there when one primitive has it, and the others are given the plainest values.
    void choose_columns() {
        bool can_keep_tangents = true;
        has_features_ = !primitives_.empty();
        for (std::size_t i = 0; i < primitives_.size(); ++i) {
            const gltf_primitive& p = primitives_[i];
            const material& m = target_.mesh.materials[materials_of_primitive_[i]];
            has_normals_ |= !p.normals.empty();
            has_tangents_ |= !p.tangents.empty();
            can_keep_tangents &= !p.tangents.empty() || !m.normal_texture.is_present();
            for (std::size_t s = 0; s < uv_set_count; ++s) has_uvs_[s] |= !p.uv_sets[s].empty();
            has_colors_ |= !p.colors.empty();
            has_features_ &= !p.feature_ids.empty() || p.positions.empty();
        }
        if (has_tangents_ && !(can_keep_tangents && has_normals_)) {
            has_tangents_ = false;
            target_.note("tangents are left out: not every primitive that needs them has some");
        }
        if (!has_normals_) return;
        for (gltf_primitive& p : primitives_) {
            if (p.normals.empty()) p.make_flat();
        }
    }

    void append(const gltf_primitive& from, material_id material, const glm::dmat4& to_scene) {
        mesh& to = target_.mesh;
        const glm::dmat3 linear(to_scene);
        const bool is_mirrored = glm::determinant(linear) < 0;
        const glm::dmat3 for_normals = is_mirrored ? -normal_matrix(linear) : normal_matrix(linear);
        const auto first = static_cast<std::uint32_t>(to.positions.size());
        const std::size_t count = from.positions.size();

        for (const vec3& p : from.positions) {
            to.positions.emplace_back(glm::dvec3(to_scene * glm::dvec4(dvec3(p), 1)));
        }
        if (has_normals_) {
            for (const vec3& n : from.normals) {
                to.normals.push_back(unit_or_zero(for_normals * dvec3(n)));
            }
        }
        if (has_tangents_) append_tangents(from, linear, is_mirrored);
        for (std::size_t s = 0; s < uv_set_count; ++s) {
            append_column(to.uv_sets[s], from.uv_sets[s], has_uvs_[s], count, vec2(0));
        }
        append_column(to.colors, from.colors, has_colors_, count, vec4(1));
        append_column(to.feature_ids, from.feature_ids, has_features_, count, 0u);
        for (uvec3 t : from.triangles) {
            if (is_mirrored) std::swap(t.y, t.z);
            to.triangles.push_back(t + first);
        }
        to.face_materials.resize(to.triangles.size(), material);
    }

    void append_tangents(const gltf_primitive& from, const glm::dmat3& linear, bool is_mirrored) {
        const std::size_t first = target_.mesh.tangents.size();
        for (std::size_t i = 0; i < from.positions.size(); ++i) {
            const vec4 given = from.tangents.empty() ? vec4(0, 0, 0, 1) : from.tangents[i];
            vec3 direction = unit_or_zero(linear * dvec3(given));
            if (direction == vec3(0)) {  // any direction along the surface
                const vec3 n = target_.mesh.normals[first + i];
                direction = unit_or_zero(
                    glm::cross(dvec3(n), std::abs(n.x) < 0.9f ? dvec3(1, 0, 0) : dvec3(0, 1, 0)));
                if (direction == vec3(0)) direction = vec3(1, 0, 0);
            }
            // The mirrored frame is left-handed, so the bitangent's side changes too.
            const bool is_negative = (given.w < 0) != is_mirrored;
            target_.mesh.tangents.emplace_back(direction, is_negative ? -1.0f : 1.0f);
        }
    }

    template <class T>
    static void append_column(std::vector<T>& to, const std::vector<T>& from, bool is_wanted,
                              std::size_t count, const T& plain) {
        if (!is_wanted) return;
        if (from.empty()) {
            to.resize(to.size() + count, plain);
        } else {
            to.insert(to.end(), from.begin(), from.end());
        }
    }

    void drop_textures_without_uv() {
        for (material& m : target_.mesh.materials) {
            for (texture* t : {&m.base_color_texture, &m.metallic_roughness_texture,
                               &m.normal_texture, &m.occlusion_texture, &m.emissive_texture}) {
                if (!t->is_present() || !target_.mesh.uv_sets[t->uv_set].empty()) continue;
                *t = {};
                target_.note("textures without texture coordinates are left out");
            }
        }
    }

    gltf_document& document_;
    const read_options& options_;
    loaded_mesh target_{};
    std::vector<gltf_primitive> primitives_{};
    std::vector<material_id> materials_of_primitive_{};
    std::map<int, std::vector<std::size_t>> primitives_of_mesh_{};
    bool has_normals_ = false;
    bool has_tangents_ = false;
    std::array<bool, uv_set_count> has_uvs_{};
    bool has_colors_ = false;
    bool has_features_ = false;
};

/// The mesh in the bytes of a glTF file; `file` names it and says where its other files lie.
[[nodiscard]] inline expected<loaded_mesh> read_gltf_bytes(const std::filesystem::path& file,
                                                           std::vector<std::uint8_t> bytes,
                                                           const read_options& options) {
    auto document = parse_gltf(file, std::move(bytes));
    if (!document) return document.error();
    return gltf_flattener(*document, options).run();
}

}  // namespace detail

/// Reads the default scene of a .gltf or .glb file into one mesh in scene space.
///
/// Gives   the mesh, valid, with what was left out. Points and lines are skipped and counted, skins
///         keep their bind pose, morph targets their base shape.
/// Fails   with one line that names file and fault. unsupported says what to do.
/// Cost    O(bytes + faces of all instances).
[[nodiscard]] inline expected<loaded_mesh> read_gltf(const std::filesystem::path& file,
                                                     const read_options& options = {}) {
    auto bytes = read_file(file);
    if (!bytes) return bytes.error();
    return detail::read_gltf_bytes(file, std::move(*bytes), options);
}

}  // namespace billow::inline BILLOW_ABI
