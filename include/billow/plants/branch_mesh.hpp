// Bark: frusta around the segments of a skeleton.
#pragma once

#include <algorithm>
#include <cmath>

#include <billow/mesh/mesh.hpp>
#include <billow/plants/skeleton.hpp>

namespace billow::inline BILLOW_ABI {

struct branch_options {
    unsigned sides = 10;      ///< of the thickest branch; thinner ones have fewer
    unsigned min_sides = 3;   ///< of the thinnest ones
    double bark_width = 0.5;  ///< width of the bark image, in scene units; every branch has a
                              ///< whole number of them around, at least one
};

namespace detail {

/// `vector` carried along as the unit tangent turns from `from` to `to`, without twist.
[[nodiscard]] inline dvec3 transported(const dvec3& vector, const dvec3& from, const dvec3& to) {
    const dvec3 axis = glm::cross(from, to);
    const dvec3 once = glm::cross(axis, vector);
    return vector + once + glm::cross(axis, once) / (1 + glm::dot(from, to));
}

/// Builds the frusta of one path after the other.
class bark_builder {
public:
    bark_builder(const skeleton& bones, const branch_options& options, material_id material,
                 mesh& out)
        : bones_(bones), options_(options), material_(material), out_(out) {}

    void build() {
        const std::vector<std::uint32_t> heirs = continuations(bones_);
        for (const float radius : bones_.start_radii) thickest_ = std::max(thickest_, radius);
        for (std::uint32_t i = 0; i < bones_.segment_count(); ++i) {
            const std::uint32_t parent = bones_.parents[i];
            if (parent != no_id && heirs[parent] == i) continue;
            path_.clear();
            for (std::uint32_t s = i; s != no_id; s = heirs[s]) path_.push_back(s);
            add_path();
        }
    }

private:
    /// A path has one ring more than segments; neighbours share a ring, so nothing gapes.
    void add_path() {
        const double first_radius = double(bones_.start_radii[path_.front()]);
        sides_ = std::max(options_.min_sides,
                          static_cast<unsigned>(std::lround(
                              options_.sides * std::sqrt(first_radius / double(thickest_)))));
        repeats_ = std::max(1.0, std::round(tau * first_radius / options_.bark_width));
        const auto first_ring = static_cast<std::uint32_t>(out_.vertex_count());
        const auto row = static_cast<std::uint32_t>(sides_ + 1);
        double v = 0;
        dvec3 tangent = heading(0), right = -bones_.frames[path_.front()].u;
        for (std::size_t k = 0; k <= path_.size(); ++k) {
            const dvec3 next = k == 0 || k == path_.size()
                                   ? heading(std::min(k, path_.size() - 1))
                                   : glm::normalize(heading(k - 1) + heading(k));
            right = transported(right, tangent, next);
            tangent = next;
            if (k > 0) v -= length(k - 1) * repeats_ / (pi * (radius(k - 1) + radius(k)));
            add_ring(k, tangent, right, v);
            if (k == 0) continue;
            const auto below = first_ring + static_cast<std::uint32_t>(k - 1) * row;
            for (std::uint32_t s = 0; s < sides_; ++s) {
                const std::uint32_t a = below + s, b = a + 1, c = a + row, d = c + 1;
                add_face({a, b, d});
                add_face({a, d, c});
            }
        }
        if (bones_.parents[path_.front()] == no_id) add_cap(0, first_ring, true);
        add_cap(path_.size(), first_ring + static_cast<std::uint32_t>(path_.size()) * row, false);
    }

    void add_ring(std::size_t k, const dvec3& tangent, const dvec3& right, double v) {
        const dvec3 centre = k == 0 ? bones_.starts[path_[0]] : bones_.ends[path_[k - 1]];
        const dvec3 back = glm::cross(tangent, right);
        // The surface leans by how fast the radius falls on both sides of the ring.
        const std::size_t before = k == 0 ? 0 : k - 1, after = std::min(k, path_.size() - 1);
        const double lean = (radius(before) - radius(after + 1)) /
                            (before == after ? length(before) : length(before) + length(after));
        for (unsigned s = 0; s <= sides_; ++s) {
            const double angle = tau * (s % sides_) / sides_;
            const dvec3 outward = right * std::cos(angle) + back * std::sin(angle);
            out_.positions.emplace_back(centre + outward * radius(k));
            out_.normals.emplace_back(glm::normalize(outward + tangent * lean));
            out_.uv_sets[0].emplace_back(repeats_ * s / sides_, v);
        }
    }

    /// Closes a ring with a flat fan of its own vertices.
    void add_cap(std::size_t k, std::uint32_t ring, bool looks_back) {
        const auto first = static_cast<std::uint32_t>(out_.vertex_count());
        const dvec3 axis = heading(k == 0 ? 0 : k - 1) * (looks_back ? -1.0 : 1.0);
        for (unsigned s = 0; s < sides_; ++s) {
            const double angle = tau * s / sides_;
            out_.positions.push_back(vec3(out_.positions[ring + s]));  // a copy: the column grows
            out_.normals.emplace_back(axis);
            out_.uv_sets[0].emplace_back(vec2(std::cos(angle), std::sin(angle)) *
                                         static_cast<float>(repeats_ / tau));
        }
        for (std::uint32_t s = 1; s + 1 < sides_; ++s) {
            const uvec3 face(first, first + s, first + s + 1);
            add_face(looks_back ? uvec3(face.x, face.z, face.y) : face);
        }
    }

    void add_face(const uvec3& face) {
        out_.triangles.push_back(face);
        out_.face_materials.push_back(material_);
    }

    [[nodiscard]] dvec3 heading(std::size_t k) const { return bones_.frames[path_[k]].normal; }
    [[nodiscard]] double length(std::size_t k) const {
        return glm::distance(bones_.starts[path_[k]], bones_.ends[path_[k]]);
    }
    /// Of ring k.
    [[nodiscard]] double radius(std::size_t k) const {
        return double(k == 0 ? bones_.start_radii[path_[0]] : bones_.end_radii[path_[k - 1]]);
    }

    static constexpr double pi = 3.14159265358979323846;
    static constexpr double tau = 2 * pi;

    const skeleton& bones_;
    const branch_options& options_;
    material_id material_;
    mesh& out_;
    float thickest_ = 0;
    std::vector<std::uint32_t> path_{};
    unsigned sides_ = 3;
    double repeats_ = 1;
};

}  // namespace detail

/// Adds a frustum for every segment. Segments that continue each other form a path whose rings are
/// shared and do not twist; a side branch starts on its parent's axis, inside the bark. Tips, and
/// roots at the ground, are closed.
///
/// Shape   adds to positions, normals, uv set 0, triangles and face_materials.
/// Unit    u counts the images around the branch; v falls by length · images / (2π r) along it, so
///         that the image keeps its proportions and its upper side looks to the tip.
/// Needs   radii assigned and above zero; min_sides ≥ 3; bark_width > 0.
inline void add_branches(mesh& out, const skeleton& bones, const branch_options& options = {},
                         material_id material = 0) {
    BILLOW_ASSERT(bones.end_radii.size() == bones.segment_count());
    BILLOW_ASSERT(options.min_sides >= 3 && options.bark_width > 0);
    detail::bark_builder(bones, options, material, out).build();
}

}  // namespace billow::inline BILLOW_ABI
