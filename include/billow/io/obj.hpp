// Wavefront OBJ in, with MTL, through tinyobjloader.
#pragma once

#include <istream>
#include <streambuf>
#include <unordered_map>

#include <tiny_obj_loader.h>

#include <billow/core/random.hpp>
#include <billow/io/obj_material.hpp>
#include <billow/io/polygon.hpp>
#include <billow/mesh/validate.hpp>

namespace billow::inline BILLOW_ABI {

namespace detail {

/// Bytes as a stream, without a copy.
class bytes_stream : private std::streambuf, public std::istream {
public:
    explicit bytes_stream(std::span<const std::uint8_t> bytes) : std::istream(this) {
        // A get area is not written to.
        char* begin = const_cast<char*>(reinterpret_cast<const char*>(bytes.data()));
        setg(begin, begin, begin + bytes.size());
    }
};

/// Reads material libraries that lie beside the OBJ, and notes those that do not.
class obj_library_reader : public tinyobj::MaterialReader {
public:
    obj_library_reader(std::filesystem::path folder, loaded_mesh& target)
        : folder_(std::move(folder)), target_(target) {}

    bool operator()(const std::string& name, std::vector<tinyobj::material_t>* materials,
                    std::map<std::string, int>* ids, std::string* warnings,
                    std::string* faults) override {
        const auto path = file_beside(folder_, name);
        auto bytes = path ? read_file(*path) : expected<std::vector<std::uint8_t>>(path.error());
        if (!bytes) {
            target_.note("materials left out: " + bytes.error().message);
            return true;  // the next name of the same line would be tried otherwise
        }
        bytes_stream stream(*bytes);
        tinyobj::LoadMtl(ids, materials, &stream, warnings, faults);
        return true;
    }

private:
    std::filesystem::path folder_;
    loaded_mesh& target_;
};

/// Refuses positions that tinyobjloader would read as 0: those that are no finite numbers.
[[nodiscard]] inline expected<done> check_obj_positions(const std::filesystem::path& file,
                                                        std::string_view text) {
    std::size_t line_number = 0;
    while (!text.empty()) {
        ++line_number;
        std::string_view line = text.substr(0, text.find_first_of("\n\r"));
        text.remove_prefix(line.size());
        text.remove_prefix(text.starts_with("\r\n") ? 2 : std::min<std::size_t>(1, text.size()));
        const auto skip_blanks = [&] {
            line.remove_prefix(std::min(line.find_first_not_of(" \t"), line.size()));
        };
        skip_blanks();
        if (line.size() < 2 || line[0] != 'v' || (line[1] != ' ' && line[1] != '\t')) continue;
        line.remove_prefix(1);
        for (int i = 0; i < 3; ++i) {
            skip_blanks();
            const std::string_view number = line.substr(0, line.find_first_of(" \t"));
            line.remove_prefix(number.size());
            if (!number.empty() && number.find_first_not_of("0123456789+-.eE") == number.npos) {
                continue;
            }
            const bool is_word = number.find_first_of("nN") != number.npos;
            return file_error(is_word ? error_code::not_finite : error_code::malformed, file,
                              "vertex on line " + std::to_string(line_number) +
                                  " has not three finite coordinates");
        }
    }
    return done{};
}

/// Turns what tinyobjloader holds into a mesh.
class obj_flattener {
public:
    obj_flattener(const std::filesystem::path& file, const read_options& options,
                  const tinyobj::attrib_t& attributes)
        : file_(file), options_(options), attributes_(attributes) {}

    [[nodiscard]] expected<loaded_mesh> run(const std::vector<tinyobj::shape_t>& shapes,
                                            const std::vector<tinyobj::material_t>& materials,
                                            loaded_mesh target) {
        target_ = std::move(target);
        obj_materials converted(file_.parent_path(), target_);
        for (const auto& m : materials) converted.add(m);
        material_count_ = materials.size();
        for (const auto& shape : shapes) note_columns(shape.mesh);
        has_colors_ = std::any_of(attributes_.colors.begin(), attributes_.colors.end(),
                                  [](float c) { return c != 1; });
        for (const auto& shape : shapes) {
            if (!shape.lines.indices.empty()) ++target_.skipped_primitives;
            if (!shape.points.indices.empty()) ++target_.skipped_primitives;
            if (shape.mesh.indices.empty()) continue;
            ++target_.primitives;
            ++target_.instances;
            if (auto done = add_shape(shape.mesh); !done) return done.error();
        }
        if (auto valid = validate(target_.mesh); !valid) {
            return file_error(valid.error().code, file_, valid.error().message);
        }
        return std::move(target_);
    }

private:
    struct corner_hash {
        std::size_t operator()(const std::array<int, 3>& c) const noexcept {
            std::uint64_t bits = static_cast<std::uint32_t>(c[0]);
            bits = mix_bits(bits << 32 | static_cast<std::uint32_t>(c[1]));
            return static_cast<std::size_t>(mix_bits(bits ^ static_cast<std::uint32_t>(c[2])));
        }
    };

    void note_columns(const tinyobj::mesh_t& shape) {
        for (const auto& i : shape.indices) {
            has_normals_ |= i.normal_index >= 0;
            has_uvs_ |= i.texcoord_index >= 0;
        }
    }

    [[nodiscard]] expected<done> add_shape(const tinyobj::mesh_t& shape) {
        std::size_t corner_count = 0;
        for (const unsigned char n : shape.num_face_vertices) corner_count += n;
        if (corner_count != shape.indices.size()) {
            return file_error(error_code::unsupported, file_,
                              "has a polygon of more than 255 corners; triangulate it first");
        }
        std::size_t first = 0;
        for (std::size_t face = 0; face < shape.num_face_vertices.size(); ++face) {
            const std::size_t count = shape.num_face_vertices[face];
            if (auto done =
                    add_polygon({shape.indices.data() + first, count}, shape.material_ids[face]);
                !done) {
                return done;
            }
            first += count;
        }
        return done{};
    }

    [[nodiscard]] expected<done> add_polygon(std::span<const tinyobj::index_t> polygon,
                                             int obj_material) {
        const auto is_within = [](int id, std::size_t numbers, std::size_t width) {
            return id >= 0 && static_cast<std::size_t>(id) < numbers / width;
        };
        corners_.clear();
        for (const auto& i : polygon) {
            if (!is_within(i.vertex_index, attributes_.vertices.size(), 3) ||
                (i.normal_index >= 0 &&
                 !is_within(i.normal_index, attributes_.normals.size(), 3)) ||
                (i.texcoord_index >= 0 &&
                 !is_within(i.texcoord_index, attributes_.texcoords.size(), 2))) {
                return file_error(error_code::out_of_range, file_,
                                  "face " + std::to_string(target_.mesh.face_count()) +
                                      " has an index beyond the last vertex");
            }
            corners_.emplace_back(three(attributes_.vertices, i.vertex_index));
        }
        vertices_.clear();
        for (const auto& i : polygon) vertices_.push_back(vertex_of(i));
        if (target_.mesh.face_count() + polygon.size() > options_.max_faces) {
            return file_error(error_code::too_large, file_,
                              "has more than " + std::to_string(options_.max_faces) + " faces");
        }
        for (const auto& t : triangulate_polygon(corners_)) {
            target_.mesh.triangles.emplace_back(vertices_[t[0]], vertices_[t[1]], vertices_[t[2]]);
            target_.mesh.face_materials.push_back(material_of(obj_material));
        }
        return done{};
    }

    /// Same indices, same vertex. A corner without a normal is of its polygon alone.
    [[nodiscard]] std::uint32_t vertex_of(const tinyobj::index_t& i) {
        mesh& m = target_.mesh;
        const bool is_flat = has_normals_ && i.normal_index < 0;
        const auto add = [&] {
            const auto id = static_cast<std::uint32_t>(m.positions.size());
            m.positions.push_back(three(attributes_.vertices, i.vertex_index));
            if (has_normals_) m.normals.push_back(normal_of(i));
            if (has_uvs_) m.uv_sets[0].push_back(uv_of(i.texcoord_index));
            if (has_colors_) {
                const vec3 c = three(attributes_.colors, i.vertex_index);
                m.colors.emplace_back(linear(c.r), linear(c.g), linear(c.b), 1.0f);
            }
            return id;
        };
        if (is_flat) return add();
        const auto [known, is_new] =
            ids_.try_emplace({i.vertex_index, i.texcoord_index, i.normal_index}, 0u);
        if (is_new) known->second = add();
        return known->second;
    }

    [[nodiscard]] vec3 normal_of(const tinyobj::index_t& i) const {
        dvec3 normal(0);
        if (i.normal_index >= 0) normal = dvec3(three(attributes_.normals, i.normal_index));
        if (!(glm::length(normal) > 0)) normal = area_vector(corners_);
        const double length = glm::length(normal);
        return length > 0 && std::isfinite(length) ? vec3(normal / length) : vec3(0, 0, 1);
    }

    /// OBJ counts v from the bottom of the image, our textures from the top.
    [[nodiscard]] vec2 uv_of(int id) const {
        if (id < 0) return vec2(0);
        const auto at = static_cast<std::size_t>(id) * 2;
        const vec2 uv(attributes_.texcoords[at], 1 - attributes_.texcoords[at + 1]);
        return std::isfinite(uv.x) && std::isfinite(uv.y) ? uv : vec2(0);
    }

    /// Faces without a material share a white one, added when first needed.
    [[nodiscard]] material_id material_of(int obj_material) {
        if (obj_material >= 0 && static_cast<std::size_t>(obj_material) < material_count_) {
            return static_cast<material_id>(obj_material);
        }
        if (target_.mesh.materials.size() == material_count_) {
            target_.mesh.materials.push_back({.metallic = 0});
        }
        return static_cast<material_id>(material_count_);
    }

    [[nodiscard]] static vec3 three(const std::vector<float>& numbers, int id) {
        const auto at = static_cast<std::size_t>(id) * 3;
        return {numbers[at], numbers[at + 1], numbers[at + 2]};
    }
    [[nodiscard]] static float linear(float value) {
        return linear_from_srgb(std::clamp(std::isfinite(value) ? value : 1.0f, 0.0f, 1.0f));
    }

    const std::filesystem::path& file_;
    const read_options& options_;
    const tinyobj::attrib_t& attributes_;
    loaded_mesh target_{};
    std::size_t material_count_ = 0;
    bool has_normals_ = false;
    bool has_uvs_ = false;
    bool has_colors_ = false;
    std::vector<dvec3> corners_{};
    std::vector<std::uint32_t> vertices_{};
    std::unordered_map<std::array<int, 3>, std::uint32_t, corner_hash> ids_{};
};

/// The mesh in the bytes of an OBJ file; `file` names it and says where its other files lie.
[[nodiscard]] inline expected<loaded_mesh> read_obj_bytes(const std::filesystem::path& file,
                                                          std::span<const std::uint8_t> bytes,
                                                          const read_options& options) {
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    if (text.find('\0') != text.npos) {
        return file_error(error_code::malformed, file, "is not text, so it is no OBJ file");
    }
    if (auto checked = check_obj_positions(file, text); !checked) return checked.error();

    loaded_mesh target;
    obj_library_reader library(file.parent_path(), target);
    tinyobj::attrib_t attributes;
    std::vector<tinyobj::shape_t> shapes;
    std::vector<tinyobj::material_t> materials;
    std::string warnings;
    std::string faults;
    bytes_stream stream(bytes);
    // Polygons come whole: tinyobjloader would drop those with indices out of range in silence.
    constexpr bool triangulates = false;
    constexpr bool fills_colors = true;
    if (!tinyobj::LoadObj(&attributes, &shapes, &materials, &warnings, &faults, &stream, &library,
                          triangulates, fills_colors)) {
        return file_error(error_code::malformed, file,
                          faults.empty() ? "is not an OBJ file" : faults);
    }
    if (attributes.vertices.empty()) {
        return file_error(error_code::malformed, file, "is not an OBJ file: it has no vertex");
    }
    return obj_flattener(file, options, attributes).run(shapes, materials, std::move(target));
}

}  // namespace detail

/// Reads a Wavefront OBJ file with its material libraries and textures.
///
/// Gives   the mesh, valid: polygons in triangles, one vertex for each set of indices, v of texture
///         coordinates from the top. Missing libraries and textures are noted, not fatal.
/// Fails   with one line that names file and fault.
/// Cost    O(bytes), more for concave polygons.
[[nodiscard]] inline expected<loaded_mesh> read_obj(const std::filesystem::path& file,
                                                    const read_options& options = {}) {
    auto bytes = read_file(file);
    if (!bytes) return bytes.error();
    return detail::read_obj_bytes(file, *bytes, options);
}

}  // namespace billow::inline BILLOW_ABI
