// glTF 2.0 out: any mesh of ours as one .glb, the same bytes for the same mesh.
//
// Source: glTF 2.0 Specification, Khronos Group 2021.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <map>
#include <numeric>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include <billow/core/expected.hpp>
#include <billow/core/parallel.hpp>
#include <billow/io/file.hpp>
#include <billow/io/image_file.hpp>
#include <billow/mesh/mesh.hpp>
#include <billow/mesh/validate.hpp>

namespace billow::inline BILLOW_ABI {

/// A node of its own for some faces of a mesh.
struct glb_node {
    std::string name{};
    std::vector<face_id> faces{};
};

struct glb_options {
    std::string name{};             ///< of mesh and node; empty: none
    std::vector<glb_node> nodes{};  ///< none: one node for all faces, called `name`
    std::string extras{};           ///< JSON text that asset.extras will hold; empty: none
    parallel threads{};             ///< images are encoded in parallel
};

namespace detail {

/// Lays out one GLB. Vertices are written with the primitives that use them, one a material.
class glb_encoder {
public:
    glb_encoder(const mesh& source, const glb_options& options) : mesh_(source), options_(options) {
        for (std::uint32_t s = 0; s < uv_set_count; ++s) {
            if (!mesh_.uv_sets[s].empty()) written_uv_sets_.push_back(s);
        }
    }

    [[nodiscard]] std::vector<std::uint8_t> run() {
        root_["asset"] = {{"version", "2.0"}, {"generator", "billow " BILLOW_VERSION}};
        if (!options_.extras.empty()) {
            root_["asset"]["extras"] = json::parse(options_.extras, nullptr, false);
        }
        root_["scene"] = 0;
        write_nodes();
        if (meshes_.empty()) {
            root_["scenes"] = json::array({json::object()});
        } else {
            write_images();
            json ids = json::array();
            json nodes = json::array();
            for (std::size_t i = 0; i < meshes_.size(); ++i) {
                json node = json::object();
                if (meshes_[i].contains("name")) node["name"] = meshes_[i]["name"];
                node["mesh"] = i;
                ids.push_back(i);
                nodes.push_back(std::move(node));
            }
            root_["scenes"] = json::array({{{"nodes", std::move(ids)}}});
            root_["nodes"] = std::move(nodes);
            root_["meshes"] = std::move(meshes_);
            for (auto* part :
                 {&materials_, &textures_, &samplers_, &images_, &accessors_, &views_}) {
                if (!part->second.empty()) root_[part->first] = std::move(part->second);
            }
            if (uses_transform_) root_["extensionsUsed"] = {"KHR_texture_transform"};
            root_["buffers"] = json::array({{{"byteLength", binary_.size()}}});
        }
        return container();
    }

private:
    using json = nlohmann::ordered_json;
    using section = std::pair<const char*, json>;

    // ---- binary

    template <class T>
    std::size_t add_view(const std::vector<T>& values, int target = 0) {
        const std::size_t offset = binary_.size();
        const std::size_t size = values.size() * sizeof(T);
        binary_.resize(offset + (size + 3) / 4 * 4, 0);
        std::memcpy(binary_.data() + offset, values.data(), size);
        json view{{"buffer", 0}, {"byteOffset", offset}, {"byteLength", size}};
        if (target != 0) view["target"] = target;
        views_.second.push_back(std::move(view));
        return views_.second.size() - 1;
    }

    template <class T>
    std::size_t add_accessor(const std::vector<T>& values, int component, const char* type,
                             int target) {
        accessors_.second.push_back({{"bufferView", add_view(values, target)},
                                     {"componentType", component},
                                     {"count", values.size()},
                                     {"type", type}});
        return accessors_.second.size() - 1;
    }

    // ---- faces

    void write_nodes() {
        if (!options_.nodes.empty()) {
            for (const glb_node& node : options_.nodes) write_mesh(node.name, node.faces);
            return;
        }
        std::vector<face_id> all(mesh_.face_count());
        std::iota(all.begin(), all.end(), face_id{0});
        write_mesh(options_.name, all);
    }

    /// A mesh of these faces, and its node; nothing where there are none.
    void write_mesh(const std::string& name, const std::vector<face_id>& faces) {
        if (faces.empty()) return;
        json mesh = json::object();
        if (!name.empty()) mesh["name"] = name;
        mesh["primitives"] = write_primitives(faces);
        meshes_.push_back(std::move(mesh));
    }

    [[nodiscard]] json write_primitives(const std::vector<face_id>& mesh_faces) {
        json primitives = json::array();
        std::map<material_id, std::vector<face_id>> faces_of;
        for (const face_id face : mesh_faces) {
            const material_id id = mesh_.face_materials.empty() ? 0 : mesh_.face_materials[face];
            faces_of[id < mesh_.materials.size() ? id : no_id].push_back(face);
        }
        std::vector<std::uint32_t> new_ids(mesh_.vertex_count(), no_id);
        for (const auto& [material, faces] : faces_of) {
            std::vector<std::uint32_t> vertices;
            std::vector<std::uint32_t> indices;
            indices.reserve(faces.size() * 3);
            for (const face_id face : faces) {
                for (int c = 0; c < 3; ++c) {
                    const std::uint32_t v = mesh_.triangles[face][c];
                    if (new_ids[v] == no_id) {
                        new_ids[v] = static_cast<std::uint32_t>(vertices.size());
                        vertices.push_back(v);
                    }
                    indices.push_back(new_ids[v]);
                }
            }
            for (const std::uint32_t v : vertices) new_ids[v] = no_id;
            primitives.push_back({{"attributes", write_vertices(vertices)},
                                  {"indices", write_indices(indices, vertices.size())},
                                  {"material", material_row(material)}});
        }
        return primitives;
    }

    std::size_t write_indices(const std::vector<std::uint32_t>& indices, std::size_t vertex_count) {
        constexpr int element_array = 34963;
        if (vertex_count > 0xffff) return add_accessor(indices, 5125, "SCALAR", element_array);
        std::vector<std::uint16_t> narrow(indices.size());
        std::transform(indices.begin(), indices.end(), narrow.begin(),
                       [](std::uint32_t i) { return static_cast<std::uint16_t>(i); });
        return add_accessor(narrow, 5123, "SCALAR", element_array);
    }

    [[nodiscard]] json write_vertices(const std::vector<std::uint32_t>& vertices) {
        constexpr int array = 34962;
        constexpr int as_float = 5126;
        json attributes = json::object();
        const auto write = [&](const std::string& name, const char* type, const auto& column) {
            if (column.empty()) return;
            std::remove_cvref_t<decltype(column)> rows;
            rows.reserve(vertices.size());
            for (const std::uint32_t v : vertices) rows.push_back(column[v]);
            attributes[name] = add_accessor(rows, as_float, type, array);
        };
        write("POSITION", "VEC3", mesh_.positions);
        vec3 low = mesh_.positions[vertices.front()];
        vec3 high = low;
        for (const std::uint32_t v : vertices) {
            low = glm::min(low, mesh_.positions[v]);
            high = glm::max(high, mesh_.positions[v]);
        }
        accessors_.second.back()["min"] = {low.x, low.y, low.z};
        accessors_.second.back()["max"] = {high.x, high.y, high.z};
        write("NORMAL", "VEC3", mesh_.normals);
        if (!mesh_.normals.empty()) write("TANGENT", "VEC4", mesh_.tangents);
        for (std::size_t i = 0; i < written_uv_sets_.size(); ++i) {
            write("TEXCOORD_" + std::to_string(i), "VEC2", mesh_.uv_sets[written_uv_sets_[i]]);
        }
        write("COLOR_0", "VEC4", mesh_.colors);
        if (!mesh_.feature_ids.empty()) {  // a whole number as float: exact up to 2^24
            std::vector<float> ids;
            ids.reserve(vertices.size());
            for (const auto v : vertices) ids.push_back(static_cast<float>(mesh_.feature_ids[v]));
            attributes["_FEATURE_ID_0"] = add_accessor(ids, as_float, "SCALAR", array);
        }
        return attributes;
    }

    // ---- materials

    /// Each material is written once, when it is met first.
    std::size_t material_row(material_id id) {
        const auto [known, is_new] = material_rows_.try_emplace(id, 0);
        if (is_new) known->second = write_material(id);
        return known->second;
    }

    std::size_t write_material(material_id id) {
        static const material plain{.metallic = 0};
        const material& m = id < mesh_.materials.size() ? mesh_.materials[id] : plain;
        const auto unit = [](float value) { return std::clamp(value, 0.0f, 1.0f); };
        json pbr = json::object();
        if (m.base_color != vec4(1)) {
            pbr["baseColorFactor"] = {unit(m.base_color.r), unit(m.base_color.g),
                                      unit(m.base_color.b), unit(m.base_color.a)};
        }
        write_texture(pbr, "baseColorTexture", m.base_color_texture);
        pbr["metallicFactor"] = unit(m.metallic);
        pbr["roughnessFactor"] = unit(m.roughness);
        write_texture(pbr, "metallicRoughnessTexture", m.metallic_roughness_texture);

        json out = json::object();
        if (!m.name.empty()) out["name"] = m.name;
        out["pbrMetallicRoughness"] = std::move(pbr);
        if (write_texture(out, "normalTexture", m.normal_texture) && m.normal_scale != 1) {
            out["normalTexture"]["scale"] = m.normal_scale;
        }
        if (write_texture(out, "occlusionTexture", m.occlusion_texture) &&
            m.occlusion_strength != 1) {
            out["occlusionTexture"]["strength"] = unit(m.occlusion_strength);
        }
        if (m.emissive != vec3(0)) {
            out["emissiveFactor"] = {unit(m.emissive.r), unit(m.emissive.g), unit(m.emissive.b)};
            write_texture(out, "emissiveTexture", m.emissive_texture);
        }
        if (m.alpha == alpha_mode::mask) {
            out["alphaMode"] = "MASK";
            out["alphaCutoff"] = std::max(m.alpha_cutoff, 0.0f);
        } else if (m.alpha == alpha_mode::blend) {
            out["alphaMode"] = "BLEND";
        }
        if (m.is_double_sided) out["doubleSided"] = true;
        materials_.second.push_back(std::move(out));
        return materials_.second.size() - 1;
    }

    /// Whether there is something to write: an image, and coordinates to see it by.
    bool write_texture(json& owner, const char* key, const texture& t) {
        const auto uv_set = std::find(written_uv_sets_.begin(), written_uv_sets_.end(), t.uv_set);
        if (t.image >= mesh_.images.size() || mesh_.images[t.image].empty() ||
            uv_set == written_uv_sets_.end()) {
            return false;
        }
        const auto image = row_of(images_in_use_, t.image);
        const auto wrap = [](texture_wrap w) {
            return w == texture_wrap::repeat          ? 10497
                   : w == texture_wrap::clamp_to_edge ? 33071
                                                      : 33648;
        };
        const json sampler{{"magFilter", t.is_nearest ? 9728 : 9729},
                           {"minFilter", t.is_nearest ? 9984 : 9987},
                           {"wrapS", wrap(t.wrap_u)},
                           {"wrapT", wrap(t.wrap_v)}};
        const json entry{{"sampler", row_of(samplers_.second, sampler)}, {"source", image}};
        json info{{"index", row_of(textures_.second, entry)}};
        if (const auto id = uv_set - written_uv_sets_.begin(); id != 0) info["texCoord"] = id;
        if (t.transform != mat3(1)) {
            info["extensions"]["KHR_texture_transform"] = transform_of(t.transform);
            uses_transform_ = true;
        }
        owner[key] = std::move(info);
        return true;
    }

    /// Offset, rotation and scale that make up a transform. A shear, which glTF has no word for, is
    /// lost; no reader of ours makes one.
    [[nodiscard]] static json transform_of(const mat3& m) {
        const double angle = std::atan2(-static_cast<double>(m[0].y), static_cast<double>(m[0].x));
        const double scale_u = std::hypot(static_cast<double>(m[0].x), static_cast<double>(m[0].y));
        const double scale_v = std::sin(angle) * static_cast<double>(m[1].x) +
                               std::cos(angle) * static_cast<double>(m[1].y);
        json out = json::object();
        if (m[2].x != 0 || m[2].y != 0) out["offset"] = {m[2].x, m[2].y};
        if (angle != 0) out["rotation"] = angle;
        if (scale_u != 1 || scale_v != 1) out["scale"] = {scale_u, scale_v};
        return out;
    }

    void write_images() {
        std::vector<std::vector<std::uint8_t>> files(images_in_use_.size());
        options_.threads.for_chunks(files.size(), 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                files[i] = encode_png(mesh_.images[images_in_use_[i]]);
            }
        });
        for (const auto& file : files) {
            images_.second.push_back({{"bufferView", add_view(file)}, {"mimeType", "image/png"}});
        }
    }

    /// Row of `value`, which is added where it is new.
    template <class Rows, class Value>
    static std::size_t row_of(Rows& rows, const Value& value) {
        const auto found = std::find(rows.begin(), rows.end(), value);
        if (found != rows.end()) return static_cast<std::size_t>(found - rows.begin());
        rows.push_back(value);
        return rows.size() - 1;
    }

    // ---- container

    [[nodiscard]] std::vector<std::uint8_t> container() const {
        std::string text = root_.dump(-1, ' ', false, json::error_handler_t::replace);
        text.resize((text.size() + 3) / 4 * 4, ' ');
        std::vector<std::uint8_t> glb;
        const auto word = [&](std::uint64_t value) {
            for (int i = 0; i < 4; ++i)
                glb.push_back(static_cast<std::uint8_t>(value >> 8 * i & 0xff));
        };
        const std::size_t binary_part = binary_.empty() ? 0 : 8 + binary_.size();
        glb.reserve(12 + 8 + text.size() + binary_part);
        word(0x46546c67);  // "glTF"
        word(2);
        word(12 + 8 + text.size() + binary_part);
        word(text.size());
        word(0x4e4f534a);  // "JSON"
        glb.insert(glb.end(), text.begin(), text.end());
        if (!binary_.empty()) {
            word(binary_.size());
            word(0x004e4942);  // "BIN"
            glb.insert(glb.end(), binary_.begin(), binary_.end());
        }
        return glb;
    }

    const mesh& mesh_;
    const glb_options& options_;
    json root_ = json::object();
    json meshes_ = json::array();
    std::map<material_id, std::size_t> material_rows_{};
    section accessors_{"accessors", json::array()};
    section views_{"bufferViews", json::array()};
    section materials_{"materials", json::array()};
    section textures_{"textures", json::array()};
    section samplers_{"samplers", json::array()};
    section images_{"images", json::array()};
    std::vector<image_id> images_in_use_{};
    std::vector<std::uint32_t> written_uv_sets_{};
    bool uses_transform_ = false;
    std::vector<std::uint8_t> binary_{};
};

}  // namespace detail

/// The bytes of a .glb that holds the mesh: one node, or those that are asked for; in each one
/// primitive a material in use; images as PNG. Same mesh, same bytes, for any number of threads.
///
/// Shape   faces in their order within a material; `feature_ids` as _FEATURE_ID_0.
/// Fails   invalid_options: extras that are not JSON; too_large: beyond the 4 GiB of a GLB; and as
///         validate().
/// Cost    O(vertices + faces + pixels).
[[nodiscard]] inline expected<std::vector<std::uint8_t>> encode_glb(
    const mesh& source, const glb_options& options = {}) {
    if (!options.extras.empty() && !nlohmann::ordered_json::accept(options.extras)) {
        return error{error_code::invalid_options, "the extras of the GLB are not JSON"};
    }
    if (auto valid = validate(source, options.threads); !valid) return valid.error();
    auto bytes = detail::glb_encoder(source, options).run();
    if (bytes.size() > max_file_size) {
        return error{error_code::too_large, "the GLB would be larger than 4 GiB"};
    }
    return bytes;
}

/// Fails   as encode_glb and write_file.
[[nodiscard]] inline expected<done> write_glb(const std::filesystem::path& file, const mesh& source,
                                              const glb_options& options = {}) {
    auto bytes = encode_glb(source, options);
    if (!bytes) return detail::file_error(bytes.error().code, file, bytes.error().message);
    return write_file(file, *bytes);
}

}  // namespace billow::inline BILLOW_ABI
