// Which vertices are one: those at the same place, across seams of normals and uvs.
#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include <billow/core/disjoint_sets.hpp>
#include <billow/core/random.hpp>
#include <billow/core/types.hpp>
#include <billow/mesh/face_table.hpp>
#include <billow/mesh/mesh.hpp>

namespace billow::inline BILLOW_ABI {

/// One id a vertex, the same for vertices that are one.
struct vertex_identity {
    std::vector<std::uint32_t> id{};  ///< below `count`, in the order of first occurrence
    std::size_t count = 0;
};

namespace detail {

/// Numbers points from 0 on; equal points get the same number. A NaN equals nothing.
class point_numbers {
public:
    explicit point_numbers(std::size_t most) : slots_(std::bit_ceil(2 * most + 1), no_id) {
        points_.reserve(most);
    }

    [[nodiscard]] const std::vector<dvec3>& points() const noexcept { return points_; }

    /// no_id: not numbered yet.
    [[nodiscard]] std::uint32_t find(const dvec3& point) const noexcept {
        return slots_[slot_of(point)];
    }
    std::uint32_t add(const dvec3& point) {
        std::uint32_t& slot = slots_[slot_of(point)];
        if (slot == no_id) {
            slot = static_cast<std::uint32_t>(points_.size());
            points_.push_back(point);
        }
        return slot;
    }

private:
    /// Where `point` is, or else belongs.
    [[nodiscard]] std::size_t slot_of(const dvec3& point) const noexcept {
        const dvec3 p = point + 0.0;  // -0 has other bits than the 0 that it equals
        std::uint64_t hash = mix_bits(std::bit_cast<std::uint64_t>(p.x));
        hash = mix_bits(hash ^ std::bit_cast<std::uint64_t>(p.y));
        hash = mix_bits(hash ^ std::bit_cast<std::uint64_t>(p.z));
        std::size_t slot = hash & (slots_.size() - 1);
        while (slots_[slot] != no_id && points_[slots_[slot]] != point) {
            slot = (slot + 1) & (slots_.size() - 1);
        }
        return slot;
    }

    std::vector<std::uint32_t> slots_;
    std::vector<dvec3> points_;
};

/// Joins points that are at most `tolerance` apart: they lie in the same cell of a grid with that
/// spacing or in neighbouring ones.
[[nodiscard]] inline vertex_identity joined_points(const std::vector<dvec3>& points,
                                                   double tolerance) {
    const auto size = static_cast<std::uint32_t>(points.size());
    disjoint_sets sets(size);
    point_numbers cells(size);
    std::vector<std::uint32_t> newest;  // of each cell
    std::vector<std::uint32_t> before(size, no_id);
    for (std::uint32_t i = 0; i < size; ++i) {
        const dvec3 cell = glm::floor(points[i] / tolerance);
        for (int k = 0; k < 27; ++k) {
            const std::uint32_t near =
                cells.find(cell + dvec3(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1));
            if (near == no_id) continue;
            for (std::uint32_t j = newest[near]; j != no_id; j = before[j]) {
                if (glm::distance(points[i], points[j]) <= tolerance) sets.join(i, j);
            }
        }
        const std::uint32_t own = cells.add(cell);
        if (own == newest.size()) newest.push_back(no_id);
        before[i] = std::exchange(newest[own], i);
    }
    vertex_identity identity;
    identity.id = sets.numbers(identity.count);
    return identity;
}

template <class ForEachPoint>
[[nodiscard]] vertex_identity identify(std::size_t count, double tolerance,
                                       const ForEachPoint& for_each_point) {
    BILLOW_ASSERT(tolerance >= 0);
    vertex_identity identity;
    identity.id.reserve(count);
    point_numbers numbers(count);
    for_each_point([&](const dvec3& point) { identity.id.push_back(numbers.add(point)); });
    identity.count = numbers.points().size();
    if (tolerance > 0) {
        const vertex_identity joined = joined_points(numbers.points(), tolerance);
        for (std::uint32_t& id : identity.id) id = joined.id[id];
        identity.count = joined.count;
    }
    return identity;
}

}  // namespace detail

/// Says which vertices of `m` are one: those at the same position, and those within `tolerance` of
/// each other, directly or by way of others between them. No attribute is looked at.
///
/// Shape   one id a vertex, used by a face or not.
/// Unit    tolerance in scene units, ≥ 0; 0: the same position only.
/// Cost    O(vertices); with a tolerance that holds many vertices, times their number.
[[nodiscard]] inline vertex_identity position_ids(const mesh& m, double tolerance = 0) {
    return detail::identify(m.vertex_count(), tolerance, [&](const auto& visit) {
        for (const vec3& position : m.positions) visit(dvec3(position));
    });
}

/// The same for the corners of faces. Shape: corner k of row r at k·faces.size + r.
[[nodiscard]] inline vertex_identity position_ids(const face_table& faces, double tolerance = 0) {
    return detail::identify(3 * faces.size, tolerance,
                            [&](const auto& visit) { for_each_corner(faces, visit); });
}

}  // namespace billow::inline BILLOW_ABI
