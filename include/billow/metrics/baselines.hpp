// What users would take in a cloud's place: crossed quads, one flat quad, a mesh of fewer triangles.
//
// Quads in a cross are how games draw distant trees; "Approach geometry/image for rendering forest
// in real time", IJMA 3(3), 2011, section 4, has forests of single quads and of eight crossed ones.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <billow/bake/bake_cloud.hpp>
#include <billow/bake/cloud_mesh.hpp>
#include <billow/cloud/billboard_cloud.hpp>
#include <billow/cloud/fit_billboards.hpp>
#include <billow/core/parallel.hpp>
#include <billow/image/mip_chain.hpp>
#include <billow/mesh/face_table.hpp>
#include <billow/mesh/mesh.hpp>
#include <billow/mesh/select_faces.hpp>
#include <billow/metrics/draw_cost.hpp>

namespace billow::inline BILLOW_ABI {

/// Makes a mesh of about a share of the triangles: reduce_mesh, or any other.
struct mesh_reducer {
    std::string_view name{};
    mesh (*reduce)(const mesh&, double share) = nullptr;
};

/// A stand-in for a mesh, by name.
struct baseline {
    std::string name{};
    billow::mesh mesh{};
};

struct baseline_options {
    std::size_t triangles = 0;              ///< of the cloud, which reduced meshes may have, > 0
    std::uint64_t bytes = 0;                ///< of the cloud, as stored_bytes_of says, > 0
    std::vector<int> quads = {1, 2, 3, 8};  ///< each a baseline of so many quads, ≥ 1
    std::vector<mesh_reducer>
        reducers{};       ///< each a baseline at equal triangles and at equal bytes
    bake_options bake{};  ///< of quads; texels follow `bytes`
};

/// Columns of vertices, indices of 4 bytes, and images as they are, without mips.
[[nodiscard]] inline std::uint64_t stored_bytes_of(const mesh& of) noexcept {
    std::uint64_t bytes = texture_bytes_of(of).level_0 + of.triangles.size() * sizeof(uvec3);
    detail::for_each_vertex_column(of, of, [&](const auto& column, const auto&) {
        bytes += column.size() * sizeof column[0];
    });
    return bytes;
}

namespace detail {

/// Horizontal normals in even steps of half a turn together. The first has the greatest sum of
/// squared cosines to the faces' normals, weighted by area: the broad side of a wall.
[[nodiscard]] inline std::vector<dvec3> crossed_normals(const face_table& faces, int count) {
    double xx = 0;
    double xz = 0;
    double zz = 0;
    for (std::uint32_t row = 0; row < faces.size; ++row) {
        const dvec3 n = faces.normal.get(row);
        const auto area = static_cast<double>(faces.area[row]);
        xx += area * n.x * n.x;
        xz += area * n.x * n.z;
        zz += area * n.z * n.z;
    }
    const double first = 0.5 * std::atan2(2 * xz, zz - xx);
    std::vector<dvec3> normals;
    for (int i = 0; i < count; ++i) {
        const double angle = first + std::numbers::pi * i / count;
        normals.emplace_back(std::sin(angle), 0, std::cos(angle));
    }
    return normals;
}

/// Quads as a cloud, each of which shows every face.
[[nodiscard]] inline billboard_cloud crossed_cloud(const mesh& of, const face_table& faces,
                                                   int count, parallel threads) {
    billboard_cloud cloud;
    cloud.bounds = faces.bounds;
    cloud.epsilon = 2 * faces.bounds.radius;
    for (const dvec3& normal : crossed_normals(faces, count)) cloud.planes.push_back({normal, 0});
    cloud.plane_of_face.assign(of.face_count(), no_id);
    for (std::uint32_t row = 0; row < faces.size; ++row) {
        const auto cosine = [&](const plane& p) {
            return std::abs(glm::dot(p.normal, faces.normal.get(row)));
        };
        const auto best = std::ranges::max_element(cloud.planes, {}, cosine);
        cloud.plane_of_face[faces.source[row]] = static_cast<plane_id>(best - cloud.planes.begin());
    }
    for (plane_id id = 0; id < cloud.plane_count(); ++id) {
        for (face_id face = 0; face < of.face_count(); ++face) {
            const plane_id own = cloud.plane_of_face[face];
            if (own != id && own != no_id) cloud.also_drawn.push_back({id, face});
        }
    }
    fit_billboards(of, cloud, threads);
    return cloud;
}

/// Halves all images of a mesh until they take at most so many bytes; they become RGBA.
inline void shrink_textures(mesh& of, std::uint64_t bytes) {
    std::vector<texel_kind> kinds(of.images.size(), texel_kind::linear);
    const auto set = [&](const texture& t, texel_kind kind) {
        if (t.image < kinds.size()) kinds[t.image] = kind;
    };
    for (const material& m : of.materials) {
        set(m.emissive_texture, texel_kind::srgb);
        set(m.base_color_texture,
            m.alpha == alpha_mode::opaque ? texel_kind::srgb : texel_kind::srgb_alpha);
    }
    const auto halve = [&](std::size_t i) {
        image& of_mesh = of.images[i];
        if (of_mesh.width * of_mesh.height <= 1) return false;
        of_mesh = std::move(make_mip_chain(of_mesh, kinds[i])[1]);
        return true;
    };
    for (bool is_halved = true; is_halved && texture_bytes_of(of).level_0 > bytes;) {
        is_halved = false;
        for (std::size_t i = 0; i < of.images.size(); ++i) is_halved |= halve(i);
    }
}

/// The reduced mesh of most bytes that takes no more than so many, where the reducer gets there.
[[nodiscard]] inline mesh reduced_to_bytes(mesh of, const mesh_reducer& by, std::uint64_t bytes) {
    shrink_textures(of, bytes / 2);
    const std::uint64_t textures = texture_bytes_of(of).level_0;
    const auto allowed = static_cast<double>(bytes - std::min(bytes, textures));
    const auto geometry_of = [&](const mesh& m) {
        return static_cast<double>(stored_bytes_of(m) - texture_bytes_of(m).level_0);
    };
    double share = allowed / geometry_of(of);
    if (share >= 1) return of;
    const double least = 1 / static_cast<double>(of.face_count());
    mesh best;
    for (int i = 0; i < 4; ++i) {
        share = std::clamp(share, least, 1.0);
        mesh tried = by.reduce(of, share);
        const double geometry = geometry_of(tried);
        const bool fits = geometry <= allowed;
        if (i == 0 || (fits && geometry > geometry_of(best)) || geometry_of(best) > allowed) {
            best = std::move(tried);
        }
        if (fits && geometry > 0.9 * allowed) break;
        if (share <= least) break;
        share *= geometry > 0 ? std::clamp(0.97 * allowed / geometry, 0.1, 4.0) : 4.0;
    }
    return best;
}

}  // namespace detail

/// Upright quads through the middle of a mesh, turned evenly about the y axis, each of which shows all
/// of it. One quad is seen from its front as the mesh is, and from its edge not at all; the first one
/// lies along the mesh's broad side.
///
/// Needs   count ≥ 1; `faces` is the table of `of`.
/// Gives   a mesh as cloud_mesh makes it: two triangles a quad, seen from both sides.
/// Cost    as bake_cloud with all faces on every plane.
[[nodiscard]] inline mesh crossed_quads(const mesh& of, const face_table& faces, int count,
                                        const bake_options& options = {}, parallel threads = {}) {
    BILLOW_ASSERT(count >= 1);
    if (faces.size == 0) return {};
    billboard_cloud cloud = detail::crossed_cloud(of, faces, count, threads);
    const baked_cloud baked = bake_cloud(of, faces, cloud, options, threads);
    return cloud_mesh(cloud, baked);
}

/// crossed_quads with as many texels as give about so many bytes, stored_bytes_of; of the few tries
/// the nearest.
///
/// Needs, Cost  as crossed_quads, at most four times.
[[nodiscard]] inline mesh crossed_quads_of_bytes(const mesh& of, const face_table& faces, int count,
                                                 std::uint64_t bytes, bake_options options = {},
                                                 parallel threads = {}) {
    const auto wanted = static_cast<double>(bytes);
    options.texels = 128;
    options.texels_per_unit = 0;
    mesh best;
    double least_miss = std::numeric_limits<double>::infinity();
    for (int tries = 0; tries < 4; ++tries) {
        mesh tried = crossed_quads(of, faces, count, options, threads);
        const auto found = static_cast<double>(stored_bytes_of(tried));
        if (const double miss = std::abs(found - wanted); miss < least_miss) {
            least_miss = miss;
            best = std::move(tried);
        }
        if (faces.size == 0 || std::abs(found - wanted) < 0.03 * wanted) break;
        const int next =
            std::clamp(static_cast<int>(std::lround(options.texels * std::sqrt(wanted / found))), 4,
                       options.max_atlas - 2 * options.padding - 4);
        if (next == options.texels) break;
        options.texels = next;
    }
    return best;
}

/// All stand-ins: quads with textures of about the cloud's bytes; each reducer's mesh of the cloud's
/// triangles, and of its bytes. For the latter textures are halved until they take at most half of
/// the bytes, the triangles get the rest.
///
/// Needs   an original that validate() accepts, with a face; options as they say.
/// Gives   names "1 quad", "8 quads", "<reducer>, equal triangles", "<reducer>, equal bytes". Where a
///         reducer cannot reach so few triangles its mesh is larger, which costs tell.
/// Cost    of the parts.
[[nodiscard]] inline std::vector<baseline> make_baselines(const mesh& original,
                                                          const baseline_options& options,
                                                          parallel threads = {}) {
    BILLOW_ASSERT(options.triangles > 0 && options.bytes > 0 && original.face_count() > 0);
    const expected<face_table> faces = make_face_table(original, threads);
    BILLOW_ASSERT(faces.has_value());
    std::vector<baseline> made;
    for (const int count : options.quads) {
        made.push_back({std::to_string(count) + (count == 1 ? " quad" : " quads"),
                        crossed_quads_of_bytes(original, *faces, count, options.bytes, options.bake,
                                               threads)});
    }
    const double share = std::min(
        1.0, static_cast<double>(options.triangles) / static_cast<double>(original.face_count()));
    for (const mesh_reducer& by : options.reducers) {
        const std::string name(by.name);
        made.push_back({name + ", equal triangles", by.reduce(original, share)});
        made.push_back(
            {name + ", equal bytes", detail::reduced_to_bytes(original, by, options.bytes)});
    }
    return made;
}

}  // namespace billow::inline BILLOW_ABI
