// The pictures of a page: drawn, encoded, and small enough.

#include "html_pictures.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <set>
#include <span>
#include <string_view>
#include <utility>

#include <billow/bake/texture_sampler.hpp>
#include <billow/image/mip_chain.hpp>
#include <billow/io/image_file.hpp>
#include <billow/metrics/difference_picture.hpp>
#include <billow/metrics/picture.hpp>
#include <billow/metrics/plane_colors.hpp>

#include "html_text.hpp"

namespace cli {

using namespace billow;

namespace {

std::string base64(std::span<const std::uint8_t> bytes) {
    static constexpr std::string_view digits =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    text.reserve((bytes.size() + 2) / 3 * 4);
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        std::uint32_t word = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            word = word << 8 | (i + k < bytes.size() ? bytes[i + k] : 0u);
        }
        for (std::size_t k = 0; k < 4; ++k) {
            text += i + k > bytes.size() ? '=' : digits[word >> (18 - 6 * k) & 63];
        }
    }
    return text;
}

/// A picture as the address of an img.
std::string data_uri(const image& picture) {
    return "data:image/png;base64," + base64(encode_png(picture));
}

/// One call of draw_pictures.
class picture_maker {
public:
    picture_maker(const std::vector<compared_file>& files, const comparison& found,
                  const compare_options& options, parallel threads,
                  const progress_function& progress)
        : files_(files), found_(found), options_(options), threads_(threads), progress_(progress) {}

    [[nodiscard]] page_pictures run() {
        report(progress_, "report", 0);
        find_atlases();
        find_planes();
        draw_to_fit();
        report(progress_, "report", 1);
        return std::move(result_);
    }

private:
    [[nodiscard]] const mesh& original() const { return *files_.front().drawn; }
    [[nodiscard]] const mesh& cloud(std::size_t i) const { return *files_[i + 1].drawn; }

    // ---- pictures of views

    /// Draws the views ever smaller until the page stays below its size.
    void draw_to_fit() {
        std::size_t used = 40'000;
        for (const auto& a : result_.atlases) used += a.uri.size() + a.planes.size();
        const std::size_t limit = largest_page > used ? largest_page - used : 0;
        const std::vector<std::size_t> rows = telling_views(found_, files_.size() > 3 ? 4 : 6);
        for (const double share : {1.0, 0.75, 0.5, 0.375, 0.25}) {
            side_px_ = std::max(16, static_cast<int>(share * options_.size_px));
            draw_views(rows);
            draw_planes();
            std::size_t size = 0;
            for (const auto& v : result_.views) size += v.size();
            for (const auto& p : result_.planes) size += p.original.size() + p.seen.size();
            report(progress_, "report", share == 1 ? 0.5 : 0.9);
            if (size <= limit) return;
        }
    }

    [[nodiscard]] camera camera_of(std::size_t view) const {
        return orbit_camera(found_.bounds, found_.cameras[view].axes.normal, options_.distance,
                            side_px_);
    }

    void draw_views(const std::vector<std::size_t>& rows) {
        const picture_options look;
        result_.views.assign(rows.size(), {});
        for (std::size_t i = 0; i < rows.size(); ++i) {
            const auto seen = [&](const mesh& m) {
                return render_view(render_scene(m, culls_backs(m)), camera_of(rows[i]),
                                   {.supersample = options_.supersample}, threads_);
            };
            result_.views[i].view = rows[i];
            const view_picture before = seen(original());
            color_options blurring = options_.color;
            blurring.sigma_px = std::max(1.0, blurring.sigma_px * side_px_ / options_.size_px);
            const blurred_picture blurred = blur(before, blurring);
            result_.views[i].original = data_uri(image_of(before, look.background));
            for (std::size_t c = 0; c < found_.clouds.size(); ++c) {
                const view_picture after = seen(cloud(c));
                result_.views[i].clouds.push_back(
                    {data_uri(image_of(after, look.background)),
                     data_uri(coverage_picture(before, after)),
                     data_uri(
                         color_difference_picture(blurred, blur(after, blurring), hottest_color))});
            }
        }
    }

    // ---- planes

    void find_planes() {
        for (std::size_t c = 0; c < found_.clouds.size(); ++c) {
            if (!found_.clouds[c].geometric) continue;
            result_.planes.push_back({.cloud = c});
            const nearest_planes& planes = found_.clouds[c].planes;
            std::vector<std::uint32_t> ids = planes.planes.plane_of_face;
            for (std::uint32_t& id : ids) {
                if (id != no_id) id = planes.feature_of_plane[id];
            }
            colored_originals_.push_back(colored_by(original(), ids));
            colored_clouds_.push_back(colored_by(cloud(c), features_of_faces(cloud(c))));
        }
    }

    void draw_planes() {
        const vec3 background = picture_options{}.background;
        const std::size_t view = found_.cameras.size() * 3 / 8;  // a little above the horizon
        for (std::size_t i = 0; i < result_.planes.size(); ++i) {
            const auto seen = [&](const mesh& m, bool is_culled) {
                return data_uri(
                    image_of(render_view(render_scene(m, is_culled), camera_of(view), {}, threads_),
                             background));
            };
            result_.planes[i].original = seen(colored_originals_[i], culls_backs(original()));
            result_.planes[i].seen = seen(colored_clouds_[i], true);
        }
    }

    // ---- atlases

    void find_atlases() {
        for (std::size_t c = 0; c < found_.clouds.size(); ++c) {
            if (!found_.clouds[c].geometric) continue;
            const mesh& m = cloud(c);
            std::map<image_id, std::map<std::uint32_t, std::vector<face_id>>> faces_of;
            const auto& features = found_.clouds[c].planes.feature_of_plane;
            for (face_id face = 0; face < m.face_count(); ++face) {
                const texture& t = m.material_of(face).base_color_texture;
                const std::uint32_t feature = m.feature_ids[m.triangles[face].x];
                const bool is_plane = std::binary_search(features.begin(), features.end(), feature);
                if (!is_plane || t.image >= m.images.size() || m.images[t.image].empty() ||
                    m.uv_sets[t.uv_set].empty()) {
                    continue;
                }
                faces_of[t.image][feature].push_back(face);
            }
            for (const auto& [image, planes] : faces_of) add_atlas(c, m.images[image], planes);
        }
    }

    void add_atlas(std::size_t c, const image& full,
                   const std::map<std::uint32_t, std::vector<face_id>>& planes) {
        atlas_picture added{.cloud = c, .width = full.width, .height = full.height};
        const std::vector<image> chain = make_mip_chain(full, texel_kind::srgb_alpha);
        const std::size_t share = largest_page / 3 / std::max<std::size_t>(1, found_.clouds.size());
        for (const image& level : chain) {
            if (std::max(level.width, level.height) > 1024) continue;
            added.uri = data_uri(level);
            if (added.uri.size() <= share) break;
        }
        for (const auto& [feature, faces] : planes) {
            added.planes += plane_outline(cloud(c), feature, faces, full);
        }
        result_.atlases.push_back(std::move(added));
    }

    /// The faces of a plane in texels of the atlas, and the edges that only one of them has.
    [[nodiscard]] static std::string plane_outline(const mesh& m, std::uint32_t feature,
                                                   const std::vector<face_id>& faces,
                                                   const image& atlas) {
        using corner = std::pair<int, int>;  // tenths of a texel
        std::set<std::array<corner, 3>> triangles;
        vec2 low(1e30f);
        vec2 high(-1e30f);
        double area = 0;
        for (const face_id face : faces) {
            const texture& t = m.material_of(face).base_color_texture;
            std::array<corner, 3> at;
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint32_t vertex = m.triangles[face][static_cast<int>(k)];
                const vec2 texel =
                    transformed(t, m.uv_sets[t.uv_set][vertex]) * vec2(atlas.width, atlas.height);
                low = glm::min(low, texel);
                high = glm::max(high, texel);
                at[k] = {static_cast<int>(std::lround(10 * std::clamp(texel.x, -1e6f, 1e6f))),
                         static_cast<int>(std::lround(10 * std::clamp(texel.y, -1e6f, 1e6f)))};
            }
            std::sort(at.begin(), at.end());
            if (!triangles.insert(at).second) continue;  // the other side of the same tile
            const auto [a, b, c] = m.corners(face);
            area += glm::length(glm::cross(dvec3(b) - dvec3(a), dvec3(c) - dvec3(a))) / 2;
        }
        std::map<std::pair<corner, corner>, int> edges;
        std::string shape;
        const auto point = [](char command, const corner& at) {
            return formatted("%c%.5g %.5g", command, at.first / 10.0, at.second / 10.0);
        };
        for (const auto& t : triangles) {
            shape += point('M', t[0]) + point('L', t[1]) + point('L', t[2]) + "Z";
            for (const auto& e :
                 {std::pair(t[0], t[1]), std::pair(t[1], t[2]), std::pair(t[0], t[2])}) {
                ++edges[e];
            }
        }
        std::string outline;
        for (const auto& [edge, count] : edges) {
            if (count == 1) outline += point('M', edge.first) + point('L', edge.second);
        }
        return formatted(
                   "<g class=\"plane\" tabindex=\"0\" data-said=\"plane %u: %.0f × %.0f "
                   "texels, %.4g square units\">",
                   feature, static_cast<double>(high.x - low.x),
                   static_cast<double>(high.y - low.y), area) +
               "<path class=\"area\" d=\"" + shape + "\"/><path class=\"edge\" d=\"" + outline +
               "\"/></g>\n";
    }

    const std::vector<compared_file>& files_;
    const comparison& found_;
    const compare_options& options_;
    parallel threads_;
    const progress_function& progress_;
    int side_px_ = 0;
    std::vector<mesh> colored_originals_{};
    std::vector<mesh> colored_clouds_{};
    page_pictures result_{};
};

}  // namespace

page_pictures draw_pictures(const std::vector<compared_file>& files, const comparison& found,
                            const compare_options& options, parallel threads,
                            const progress_function& progress) {
    BILLOW_ASSERT(files.size() == found.clouds.size() + 1);
    return picture_maker(files, found, options, threads, progress).run();
}

}  // namespace cli
