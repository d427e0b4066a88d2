// What happens to the vertices of the faces that are left when a plane has been found.
#pragma once

#include <array>
#include <concepts>
#include <vector>

#include <billow/core/types.hpp>
#include <billow/geometry/plane.hpp>
#include <billow/mesh/face_table.hpp>
#include <billow/search/face_sets.hpp>

namespace billow::inline BILLOW_ABI {

/// A face of the mesh whose corners are drawn elsewhere. Unit: scene units, relative to the centre
/// of the table that was searched.
struct moved_face {
    face_id face = no_id;
    std::array<dvec3, 3> corners{};
};

/// Moves vertices during a search. The search works on a copy of its own, which it starts with all
/// faces and tells of each plane.
template <class M>
concept vertex_motion = std::copyable<M> &&
    requires(M& motion, const M& seen, const face_table& faces, const plane& p, double epsilon,
             face_table& remaining, face_rows& rows) {
    { M::is_still } -> std::convertible_to<bool>;
    { motion.start(faces, epsilon) } -> std::same_as<void>;
    /// Drops those `rows` of `faces` that must not be taken by `p` although their moved corners are
    /// valid for it.
    { seen.keep_allowed(faces, p, rows) } -> std::same_as<void>;
    /// Told that `p` has taken `faces`. Gives the rows of `remaining` whose corners move.
    { motion.plane_found(faces, p, remaining) } -> std::same_as<face_rows>;
    /// Moves the corners of those rows, and what the table derives from them.
    { seen.move(remaining, rows) } -> std::same_as<void>;
    /// All faces with a corner that has moved, by face.
    { seen.moved_faces() } -> std::same_as<std::vector<moved_face>>;
};

/// Every vertex stays where it is.
struct fixed_vertices {
    static constexpr bool is_still = true;

    void start(const face_table&, double) noexcept {}
    void keep_allowed(const face_table&, const plane&, face_rows&) const noexcept {}
    [[nodiscard]] face_rows plane_found(const face_table&, const plane&, const face_table&) {
        return {};
    }
    void move(face_table&, const face_rows&) const noexcept {}
    [[nodiscard]] std::vector<moved_face> moved_faces() const { return {}; }
};
static_assert(vertex_motion<fixed_vertices>);

}  // namespace billow::inline BILLOW_ABI
