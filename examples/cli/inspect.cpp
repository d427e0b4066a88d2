// billow inspect: what a mesh or a billboard cloud holds.

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include <billow/billow.hpp>
#include <billow/io.hpp>

#include "verbs.hpp"

namespace cli {
namespace {

using namespace billow;

const char* name_of(alpha_mode mode) {
    switch (mode) {
        case alpha_mode::opaque:
            return "opaque";
        case alpha_mode::mask:
            return "mask";
        case alpha_mode::blend:
            return "blend";
    }
    return "";
}

void print_texture(const mesh& m, const char* use, const texture& t) {
    if (!t.is_present()) return;
    const image& picture = m.images[t.image];
    std::printf("    %s: image %u, %d x %d\n", use, t.image, picture.width, picture.height);
}

void print_materials(const mesh& m) {
    std::vector<std::size_t> faces(std::max<std::size_t>(1, m.materials.size()));
    if (m.face_materials.empty()) faces[0] = m.face_count();
    for (const material_id id : m.face_materials) {
        if (id < faces.size()) ++faces[id];
    }
    std::printf("materials: %zu\n", m.materials.size());
    for (std::size_t i = 0; i < m.materials.size(); ++i) {
        const material& look = m.materials[i];
        std::printf("  %zu%s%s: %zu faces, %s%s\n", i, look.name.empty() ? "" : " ",
                    look.name.c_str(), faces[i], name_of(look.alpha),
                    look.is_double_sided ? ", double-sided" : "");
        print_texture(m, "base colour", look.base_color_texture);
        print_texture(m, "normal", look.normal_texture);
        print_texture(m, "metallic-roughness", look.metallic_roughness_texture);
        print_texture(m, "occlusion", look.occlusion_texture);
        print_texture(m, "emissive", look.emissive_texture);
    }
}

void print_planes(const mesh& m) {
    if (m.feature_ids.empty()) return;
    const std::set<std::uint32_t> planes(m.feature_ids.begin(), m.feature_ids.end());
    std::printf("billboard cloud: %zu planes, %zu triangles\n", planes.size(), m.face_count());
}

exit_code inspect(const std::filesystem::path& file) {
    const auto fail = [](const std::string& message) {
        std::fprintf(stderr, "billow: %s\n", message.c_str());
        return bad_input;
    };
    const expected<loaded_mesh> loaded = read_mesh(file);
    if (!loaded) return fail(loaded.error().message);
    const mesh& m = loaded->mesh;
    const expected<face_table> faces = make_face_table(m);
    if (!faces) return fail(file.string() + ": " + faces.error().message);

    double area = 0;
    for (const float face : faces->area) area += static_cast<double>(face);
    const bounding_sphere& bounds = faces->bounds;
    std::printf("%s\n", file.string().c_str());
    print_planes(m);
    std::printf("faces: %zu, of them degenerate: %zu\nvertices: %zu\n", m.face_count(),
                faces->degenerate.size(), m.vertex_count());
    std::printf("area: %.6g\nradius: %.6g\ncentre: %.6g %.6g %.6g\n", area, bounds.radius,
                bounds.centre.x, bounds.centre.y, bounds.centre.z);
    std::printf("attributes:%s%s%s%s%s%s\n", m.normals.empty() ? "" : " normals",
                m.tangents.empty() ? "" : " tangents", m.uv_sets[0].empty() ? "" : " uv0",
                m.uv_sets[1].empty() ? "" : " uv1", m.colors.empty() ? "" : " colours",
                m.feature_ids.empty() ? "" : " plane-ids");
    std::printf("primitives: %zu, placed %zu times, skipped: %zu\n", loaded->primitives,
                loaded->instances, loaded->skipped_primitives);
    print_materials(m);
    std::printf("images: %zu\n", m.images.size());
    for (const std::string& note : loaded->notes) std::printf("note: %s\n", note.c_str());
    return success;
}

}  // namespace

void add_inspect(CLI::App& tool, exit_code& result) {
    auto file = std::make_shared<std::filesystem::path>();
    CLI::App* verb = tool.add_subcommand("inspect", "Print what a mesh or billboard cloud holds.");
    verb->add_option("FILE", *file, "Mesh or cloud: .glb, .gltf or .obj")->required();
    verb->callback([file, &result] { result = inspect(*file); });
}

}  // namespace cli
