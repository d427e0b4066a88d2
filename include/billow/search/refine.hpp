// From the densest bin to a plane: refinement.
//
// Décoret et al. 2003; Luksch 2009, sections 2.1 and 3.2. A bin's density promises only that many
// faces each have some valid plane in the bin, not that one plane serves them all, and the densest
// plane may lie in a neighbour. So the bin and what surrounds it are split again and again, and the
// densest part goes on, until its centre serves every face that is left.
#pragma once

#include <limits>
#include <optional>
#include <span>
#include <utility>
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
    bool falls = true;  ///< whether the falloff policy counts
    /// Whether the penalty policy counts too. Fuhrmann et al. 2005 (section 3.2.2) leave it out, since
    /// planes that slice through foliage are wanted; Décoret et al. 2003 do not.
    bool penalty_counts = false;
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
    bin_splitter(const Space& space, const Policies& policies, double epsilon,
                 const refine_options& options, parallel threads)
        : space_(space),
          policies_(policies),
          epsilon_(epsilon),
          per_axis_(options.children_per_axis),
          penalty_counts_(options.penalty_counts),
          threads_(threads) {}

    struct child {
        plane_bin bin{};
        double contribution = 0;
    };

    /// The child of most density among `faces`; where penalties leave none above 0, that of most
    /// contribution.
    [[nodiscard]] child densest_child(const face_table& faces, const plane_bin& bin) const {
        const dvec2 half = bin.patch.half_size / 2.0;
        const double spacing = (bin.rho_high - bin.rho_low) / 2;
        std::vector<orientation_patch> patches;
        std::vector<orientation_cell> cells;
        std::vector<double> weights;
        for (int j = 0; j < per_axis_; ++j) {
            for (int i = 0; i < per_axis_; ++i) {
                const dvec2 step(2 * i + 1 - per_axis_, 2 * j + 1 - per_axis_);
                patches.push_back({bin.patch.chart, bin.patch.centre + half * step, half});
                cells.push_back(cell_of_patch(space_, patches.back()));
                weights.push_back(
                    policies_.bias(space_.direction_at(bin.patch.chart, patches.back().centre)));
            }
        }
        const double middle = (bin.rho_low + bin.rho_high) / 2;
        density_grid grid(cells.size(), {middle - spacing * per_axis_ / 2, spacing, per_axis_},
                          density_scale(faces));
        rasterize(faces, cells, grid);

        // Where several are worth the same, the one nearest to the middle: the first would drift to
        // the rim of the planes that serve all, where their centres do not.
        const auto densest = [&](const auto& worth) {
            dense_bin best{.density = -std::numeric_limits<double>::infinity()};
            double nearest = 0;
            for (std::size_t row = 0; row < grid.row_count(); ++row) {
                const dvec2 aside = (patches[row].centre - bin.patch.centre) / half;
                grid.for_each_bin(row, [&](int at, std::int64_t c, std::int64_t p) {
                    const double contribution = static_cast<double>(c) / grid.contribution_scale();
                    const double density =
                        worth(row, contribution, static_cast<double>(p) / grid.scale());
                    const double up = 2 * at + 1 - per_axis_;
                    const double distance = glm::dot(aside, aside) + up * up;
                    if (density > best.density || (density == best.density && distance < nearest)) {
                        best = {row, at, density, contribution};
                        nearest = distance;
                    }
                });
            }
            return best;
        };
        const double charge = policies_.penalty.weight;
        dense_bin best = densest([&](std::size_t row, double c, double p) {
            return c > 0 ? biased(c - charge * p, weights[row])
                         : -std::numeric_limits<double>::max();
        });
        if (best.density <= 0) {
            best =
                densest([&](std::size_t row, double c, double) { return biased(c, weights[row]); });
        }
        const double low = grid.axis().origin + best.bin * spacing;
        return {{patches[best.row], low, low + spacing}, best.contribution};
    }

private:
    void rasterize(const face_table& faces, std::span<const orientation_cell> cells,
                   density_grid& grid) const {
        const auto with = [&](const auto& policies) {
            rasterize_density(faces, cells, policies, epsilon_, grid, density_change::add,
                              threads_);
        };
        if (penalty_counts_) {
            with(policies_);
        } else {
            with(density_policies{policies_.validity, policies_.contribution, no_penalty{},
                                  policies_.falloff});
        }
    }

    const Space& space_;
    const Policies& policies_;
    double epsilon_;
    int per_axis_;
    bool penalty_counts_;
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
    if constexpr (Policies::falls) {
        if (!options.falls) {
            return refine(space, bin, std::move(candidates), without_falloff(policies), epsilon,
                          options, threads);
        }
    }
    const detail::bin_splitter splitter(space, policies, epsilon, options, threads);
    // As a bin's contribution is: with the falloff where there is one, without penalty and bias.
    const auto contribution_to = [&](const plane& p, const face_rows& valid) {
        if constexpr (Policies::falls) {
            return contribution_of(candidates, valid, p, policies.contribution, policies.falloff,
                                   epsilon, bin.rho_high - bin.rho_low);
        } else {
            return contribution_of(candidates, valid, p.normal, policies.contribution);
        }
    };
    double promised = std::numeric_limits<double>::infinity();
    for (int level = 0;; ++level) {
        const plane centre = centre_plane(space, bin);
        const face_rows valid =
            faces_valid_for(candidates, centre, epsilon, policies.contribution, threads);
        if (valid.size() == candidates.size || level == options.max_levels ||
            contribution_to(centre, valid) >= options.sufficient_share * promised) {
            return refined_plane{centre, level};
        }
        const auto child = splitter.densest_child(candidates, bin);
        if (child.contribution <= 0) return std::nullopt;
        bin = child.bin;
        promised = child.contribution;
        const face_rows rows = faces_valid_for_bin(
            candidates, cell_of_patch(space, bin.patch), bin.rho_low, bin.rho_high, epsilon,
            widened_centre{}, policies.contribution, threads);
        if (rows.empty()) return std::nullopt;
        candidates = select_rows(candidates, rows, threads);
    }
}

}  // namespace billow::inline BILLOW_ABI
