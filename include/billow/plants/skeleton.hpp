// What a turtle leaves behind: the axes of a plant and the places of its leaves, in columns.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include <billow/core/expected.hpp>
#include <billow/core/types.hpp>
#include <billow/geometry/frame.hpp>

namespace billow::inline BILLOW_ABI {

/// Branch segments and leaf sites. A segment comes after its parent.
///
/// Unit  scene units. A frame's normal is the heading, its u the left, its v the upper side.
struct skeleton {
    std::vector<std::uint32_t> parents{};  ///< segment that this one grows from; no_id: a root
    std::vector<dvec3> starts{}, ends{};   ///< a child starts where its parent ends
    std::vector<frame> frames{};
    std::vector<float> start_radii{}, end_radii{};  ///< filled by assign_radii

    std::vector<std::uint32_t> leaf_segments{};  ///< segment at whose end the leaf grows
    std::vector<frame> leaf_frames{};
    std::vector<float> leaf_scales{};

    [[nodiscard]] std::size_t segment_count() const noexcept { return parents.size(); }
    [[nodiscard]] std::size_t leaf_count() const noexcept { return leaf_segments.size(); }
};

/// For every segment the child that continues it: the one that turns least, if it turns by less
/// than 90°; no_id where there is none.
[[nodiscard]] inline std::vector<std::uint32_t> continuations(const skeleton& bones) {
    std::vector<std::uint32_t> heirs(bones.segment_count(), no_id);
    std::vector<double> best(bones.segment_count(), 1e-3);
    for (std::uint32_t i = 0; i < bones.segment_count(); ++i) {
        const std::uint32_t parent = bones.parents[i];
        if (parent == no_id) continue;
        const double cosine = glm::dot(bones.frames[parent].normal, bones.frames[i].normal);
        if (cosine > best[parent] + 1e-9) {  // of equal ones the first stays, on every machine
            best[parent] = cosine;
            heirs[parent] = i;
        }
    }
    return heirs;
}

/// The number of segments that nothing grows from.
[[nodiscard]] inline std::size_t tip_count(const skeleton& bones) {
    std::vector<bool> has_child(bones.segment_count());
    for (const std::uint32_t parent : bones.parents) {
        if (parent != no_id) has_child[parent] = true;
    }
    return static_cast<std::size_t>(std::ranges::count(has_child, false));
}

/// Scales the plant so that its highest segment ends at `height` above the ground, y = 0.
///
/// Fails   malformed: nothing of it is above the ground.
[[nodiscard]] inline expected<done> scale_to_height(skeleton& bones, double height) {
    double top = 0;
    for (const dvec3& end : bones.ends) top = std::max(top, end.y);
    if (!(top > 1e-9)) {
        return error{error_code::malformed, "the plant does not grow above the ground"};
    }
    const double scale = height / top;
    for (dvec3& p : bones.starts) p *= scale;
    for (dvec3& p : bones.ends) p *= scale;
    return done{};
}

struct radius_options {
    double trunk = 0.15;  ///< radius of a lone root's end, in scene units
    double flare = 1.4;   ///< how much wider a root starts at the ground
    double collar = 1.2;  ///< how much wider a branch starts than it goes on; 1: none
};

/// Radii by da Vinci's rule: at every node the parent's cross-section is the sum of its children's,
/// r² = Σ r², all tips being equal. A continuation starts with its parent's end radius; a side
/// branch starts inside its parent, never wider than that.
///
/// Source  Leonardo da Vinci, notebooks, as quoted in ABOP, section 2.1 (there with the exponent
///         as a parameter).
inline void assign_radii(skeleton& bones, const radius_options& options = {}) {
    const std::size_t count = bones.segment_count();
    const double tip_area =
        options.trunk * options.trunk / double(std::max<std::size_t>(1, tip_count(bones)));
    std::vector<double> areas(count, 0);
    for (std::size_t i = count; i-- > 0;) {
        if (areas[i] == 0) areas[i] = tip_area;
        if (bones.parents[i] != no_id) areas[bones.parents[i]] += areas[i];
    }
    const std::vector<std::uint32_t> heirs = continuations(bones);
    bones.start_radii.resize(count);
    bones.end_radii.resize(count);
    for (std::uint32_t i = 0; i < count; ++i) {
        const std::uint32_t parent = bones.parents[i];
        const double radius = std::sqrt(areas[i]);
        bones.end_radii[i] = static_cast<float>(radius);
        if (parent == no_id) {
            bones.start_radii[i] = static_cast<float>(radius * options.flare);
        } else if (heirs[parent] == i) {
            bones.start_radii[i] = bones.end_radii[parent];
        } else {
            bones.start_radii[i] =
                std::min(bones.end_radii[parent], static_cast<float>(radius * options.collar));
        }
    }
}

}  // namespace billow::inline BILLOW_ABI
