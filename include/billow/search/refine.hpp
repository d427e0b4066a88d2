// From the densest bin to a plane: refinement.
//
// Décoret et al. 2003; Luksch 2009, sections 2.1 and 3.2. A bin's density promises only that many
// faces each have some valid plane in the bin, not that one plane serves them all, and the densest
// plane may lie in a neighbour. So the bin and what surrounds it are split again and again, and the
// densest part goes on, until its centre serves every face that is left.
#pragma once

#include <optional>
#include <vector>

#include <billow/density/rasterize.hpp>
#include <billow/search/face_sets.hpp>

namespace billow::inline BILLOW_ABI {

/// What becomes of the densest bin.
enum class refinement {
    original,   ///< split the bin and its 26 neighbours into 216 (Décoret et al. 2003)
    fail_safe,  ///< split the bin and what touches it into 64; when no plane is found, try the
    ///< planes of the bin's faces (Luksch 2009, section 3.2; Fuhrmann et al. 2005, 3.3.2)
    none,  ///< take the plane of its centre (Luksch 2009, section 3.2)
};

/// A part of plane space: the planes whose normal lies in a patch and whose offset in a range.
struct plane_bin {
    orientation_patch patch{};
    double rho_low = 0;
    double rho_high = 0;
};

/// The plane of the bin's centre.
template <plane_space Space>
[[nodiscard]] plane centre_plane(const Space& space, const plane_bin& bin) {
    return {space.direction_at(bin.patch.chart, bin.patch.centre),
            (bin.rho_low + bin.rho_high) / 2};
}

struct refine_options {
    int children_per_axis = 4;  ///< even: 4 gives 64 sub-bins (the layer that touches the bin), 6
                                ///< gives 216 (the whole neighbours)
    int max_levels = 12;        ///< > 0; each level halves the bin
    /// Share of the bin's contribution that its centre plane must serve to be taken, (0, 1]. 1 is
    /// the published rule; in soups of many small faces some always straddle a bin's border, so that
    /// it costs twelve levels and moves the plane by less than the fitting afterwards.
    double sufficient_share = 1;
};

/// A refined plane, and how many times its bin was split.
struct refined_plane {
    billow::plane plane{};
    int level = 0;
};

namespace detail {

/// The children of a bin along each axis, as cells and offsets, and the densest of them.
template <plane_space Space, class Policies>
class bin_splitter {
public:
    bin_splitter(const Space& space, const Policies& policies, double epsilon, int per_axis,
                 parallel threads)
        : space_(space),
          policies_(policies),
          epsilon_(epsilon),
          per_axis_(per_axis),
          threads_(threads) {}

    struct child {
        plane_bin bin{};
        double density = 0;
    };

    /// The child of most contribution among `faces`. No penalty: planes that slice through foliage
    /// are wanted (Fuhrmann et al. 2005, section 3.2.2).
    [[nodiscard]] child densest_child(const face_table& faces, const plane_bin& bin) const {
        const dvec2 half = bin.patch.half_size / 2.0;
        const double spacing = (bin.rho_high - bin.rho_low) / 2;
        std::vector<orientation_patch> patches;
        std::vector<orientation_cell> cells;
        for (int j = 0; j < per_axis_; ++j) {
            for (int i = 0; i < per_axis_; ++i) {
                const dvec2 step(2 * i + 1 - per_axis_, 2 * j + 1 - per_axis_);
                patches.push_back({bin.patch.chart, bin.patch.centre + half * step, half});
                cells.push_back(cell_of_patch(space_, patches.back()));
            }
        }
        const double middle = (bin.rho_low + bin.rho_high) / 2;
        density_grid grid(cells.size(), {middle - spacing * per_axis_ / 2, spacing, per_axis_},
                          density_scale(faces));
        rasterize_density(
            faces, std::span<const orientation_cell>(cells),
            density_policies{policies_.validity, policies_.contribution, no_penalty{}}, epsilon_,
            grid, density_change::add, threads_);
        // Where several are fully covered, the one nearest to the middle: the first would drift to
        // the rim of the planes that serve all, where their centres do not.
        dense_bin best{.density = -1};
        double nearest = 0;
        for (std::size_t row = 0; row < grid.row_count(); ++row) {
            const dvec2 aside = (patches[row].centre - bin.patch.centre) / half;
            grid.for_each_bin(row, [&](int at, std::int64_t contribution, std::int64_t) {
                const double density = static_cast<double>(contribution) / grid.scale();
                const double up = 2 * at + 1 - per_axis_;
                const double distance = glm::dot(aside, aside) + up * up;
                if (density > best.density || (density == best.density && distance < nearest)) {
                    best = {row, at, density, density};
                    nearest = distance;
                }
            });
        }
        const double low = grid.axis().origin + best.bin * spacing;
        return {{patches[best.row], low, low + spacing}, best.density};
    }

private:
    const Space& space_;
    const Policies& policies_;
    double epsilon_;
    int per_axis_;
    parallel threads_;
};

}  // namespace detail

/// Splits `bin` until the plane of its centre serves all of the `candidates` that still have a plane
/// in it.
///
/// Needs   candidates that are simple-valid for the bin (faces_valid_for_bin with widened_centre).
/// Gives   nothing when a bin holds no face any more; after max_levels the last bin's centre.
/// Cost    O(candidates · children_per_axis²) a level, parallel.
/// Source  Luksch 2009, section 3.2. Differs: sub-bins may reach across rho = 0, where the offset
///         turns negative, instead of changing over to the opposite normal.
template <plane_space Space, class Policies>
[[nodiscard]] std::optional<refined_plane> refine(const Space& space, plane_bin bin,
                                                  face_table candidates, const Policies& policies,
                                                  double epsilon, const refine_options& options,
                                                  parallel threads = {}) {
    const detail::bin_splitter splitter(space, policies, epsilon, options.children_per_axis,
                                        threads);
    const auto contribution_to = [&](const plane& p) {
        const face_rows valid = faces_valid_for(candidates, p, epsilon, threads);
        return std::pair(valid.size(),
                         contribution_of(candidates, valid, p.normal, policies.contribution));
    };
    double promised = std::numeric_limits<double>::infinity();
    for (int level = 0;; ++level) {
        const plane centre = centre_plane(space, bin);
        const auto [served, contribution] = contribution_to(centre);
        if (served == candidates.size || contribution >= options.sufficient_share * promised ||
            level == options.max_levels) {
            return refined_plane{centre, level};
        }
        const auto child = splitter.densest_child(candidates, bin);
        if (child.density <= 0) return std::nullopt;
        bin = child.bin;
        promised = child.density;
        const face_rows rows =
            faces_valid_for_bin(candidates, cell_of_patch(space, bin.patch), bin.rho_low,
                                bin.rho_high, epsilon, widened_centre{}, threads);
        if (rows.empty()) return std::nullopt;
        candidates = select_rows(candidates, rows, threads);
    }
}

}  // namespace billow::inline BILLOW_ABI
