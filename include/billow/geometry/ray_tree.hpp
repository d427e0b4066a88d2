// What a ray meets: triangles in a hierarchy of boxes, several boxes or triangles tested at once.
//
// Nodes as in Wald, Benthin, Boulos: Getting rid of packets. Symposium on Interactive Ray Tracing
// 2008. Built top down by the surface area heuristic in bins: Wald: On fast construction of SAH-based
// bounding volume hierarchies. Symposium on Interactive Ray Tracing 2007. Triangles as in Möller,
// Trumbore: Fast, minimum storage ray-triangle intersection. Journal of Graphics Tools 2(1), 1997.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include <billow/core/simd.hpp>
#include <billow/core/types.hpp>

namespace billow::inline BILLOW_ABI {

/// The points origin + t · direction with near ≤ t ≤ far.
struct ray {
    vec3 origin{0};
    vec3 direction{0, 0, 1};  ///< any length but 0
    float near = 0;           ///< ≥ 0
    float far = std::numeric_limits<float>::infinity();
};

/// Where a ray meets a triangle.
struct ray_hit {
    std::uint32_t triangle = no_id;                           ///< no_id: it meets none
    float distance = std::numeric_limits<float>::infinity();  ///< t
    float b = 0;                                              ///< weight of the second corner
    float c = 0;                                              ///< weight of the third corner

    [[nodiscard]] explicit operator bool() const noexcept { return triangle != no_id; }
};

/// Triangles, made ready for rays. It knows no mesh: triangles are numbers below a count.
class ray_tree {
public:
    /// Boxes of a node, and triangles of a leaf.
    static constexpr std::size_t width = std::max<std::size_t>(4, simd::lane_count);

    ray_tree() = default;

    /// Builds the tree of `count` triangles; corners_of(i) gives a std::array<vec3, 3>.
    ///
    /// Needs  finite corners. Triangles without area are never met.
    /// Cost   O(count log count), on the calling thread; some 100 bytes a triangle.
    template <class CornersOf>
    ray_tree(std::size_t count, const CornersOf& corners_of) {
        if (count == 0) return;
        std::vector<item> items(count);
        for (std::size_t i = 0; i < count; ++i) {
            const std::array<vec3, 3> p = corners_of(static_cast<std::uint32_t>(i));
            items[i].box = {glm::min(p[0], glm::min(p[1], p[2])),
                            glm::max(p[0], glm::max(p[1], p[2]))};
            items[i].triangle = static_cast<std::uint32_t>(i);
        }
        nodes_.reserve(count / 2);
        blocks_.reserve(count / 2);
        (void)add_node(items, 0, corners_of);
    }

    /// Whether a triangle stands in the ray's way. Where the ray meets one,
    /// is_there(triangle, b, c) tells whether anything is there; it must not throw.
    ///
    /// Cost   O(log count) where triangles are spread; allocates nothing.
    template <class V = simd::wide, class IsThere>
    [[nodiscard]] bool is_blocked(const ray& r, const IsThere& is_there) const noexcept {
        bool is_found = false;
        walk<V>(r, [&](const ray_hit& hit, float&) {
            return is_found = is_there(hit.triangle, hit.b, hit.c);
        });
        return is_found;
    }

    /// The first triangle on the ray's way that is there; of several at the same distance the one
    /// of lowest number.
    template <class V = simd::wide, class IsThere>
    [[nodiscard]] ray_hit closest(const ray& r, const IsThere& is_there) const noexcept {
        ray_hit first;
        walk<V>(r, [&](const ray_hit& hit, float& far) {
            const bool is_nearer =
                hit.distance < first.distance ||
                (hit.distance == first.distance && hit.triangle < first.triangle);
            if (is_nearer && is_there(hit.triangle, hit.b, hit.c)) {
                first = hit;
                far = hit.distance;
            }
            return false;
        });
        return first;
    }
    [[nodiscard]] ray_hit closest(const ray& r) const noexcept {
        return closest(r, [](std::uint32_t, float, float) { return true; });
    }

private:
    struct bounds3 {
        vec3 low{std::numeric_limits<float>::infinity()};
        vec3 high{-std::numeric_limits<float>::infinity()};

        void add(const bounds3& other) noexcept {
            low = glm::min(low, other.low);
            high = glm::max(high, other.high);
        }
        [[nodiscard]] float area() const noexcept {  // half of it
            const vec3 d = glm::max(high - low, vec3(0));
            return d.x * d.y + d.y * d.z + d.z * d.x;
        }
    };
    struct item {
        bounds3 box{};
        std::uint32_t triangle = no_id;

        [[nodiscard]] vec3 centre() const noexcept { return (box.low + box.high) * 0.5f; }
    };
    using lane_values = std::array<float, width>;
    /// A child is a node, or with the highest bit set a block; no_id is none, its box is empty.
    struct node {
        std::array<lane_values, 6> bounds;  ///< low x, high x, low y, …
        std::array<std::uint32_t, width> child;
    };
    struct block {
        std::array<lane_values, 9> value;  ///< first corner, then the edges from it to the others
        std::array<std::uint32_t, width> triangle;
    };
    static constexpr std::uint32_t block_bit = 0x80000000u;
    static constexpr int deepest_sah = 24;  // beyond it triangles are halved, whatever it costs
    static constexpr std::size_t stack_size = (deepest_sah + 32) * (width - 1) + 1;

    // --- Building -----------------------------------------------------------------------------

    struct part {
        std::span<item> items{};
        float cost = 0;  ///< of not splitting it
    };
    [[nodiscard]] static part part_of(std::span<item> items) noexcept {
        bounds3 box;
        for (const item& i : items) box.add(i.box);
        return {items, box.area() * static_cast<float>(items.size())};
    }

    template <class CornersOf>
    [[nodiscard]] std::uint32_t add_node(std::span<item> items, int depth,
                                         const CornersOf& corners_of) {
        const auto id = static_cast<std::uint32_t>(nodes_.size());
        nodes_.emplace_back();
        std::array<part, width> parts{part_of(items)};
        std::size_t count = 1;
        while (count < width) {
            std::size_t largest = width;
            const auto weight = [&](const part& p) {
                return depth < deepest_sah ? p.cost : static_cast<float>(p.items.size());
            };
            for (std::size_t i = 0; i < count; ++i) {
                if (parts[i].items.size() <= width) continue;
                if (largest == width || weight(parts[i]) > weight(parts[largest])) largest = i;
            }
            if (largest == width) break;
            const std::span<item> whole = parts[largest].items;
            const std::size_t left = depth < deepest_sah ? split_by_area(whole) : whole.size() / 2;
            parts[largest] = part_of(whole.first(left));
            parts[count++] = part_of(whole.subspan(left));
        }
        for (std::size_t k = 0; k < width; ++k) {
            bounds3 box;
            std::uint32_t child = no_id;
            if (k < count) {
                for (const item& i : parts[k].items) box.add(i.box);
                child = parts[k].items.size() <= width
                            ? add_block(parts[k].items, corners_of) | block_bit
                            : add_node(parts[k].items, depth + 1, corners_of);
            }
            node& to = nodes_[id];
            to.child[k] = child;
            for (int axis = 0; axis < 3; ++axis) {
                to.bounds[static_cast<std::size_t>(2 * axis)][k] = box.low[axis];
                to.bounds[static_cast<std::size_t>(2 * axis + 1)][k] = box.high[axis];
            }
        }
        return id;
    }

    template <class CornersOf>
    [[nodiscard]] std::uint32_t add_block(std::span<const item> items,
                                          const CornersOf& corners_of) {
        block b{};
        b.triangle.fill(no_id);
        for (std::size_t k = 0; k < items.size(); ++k) {
            const std::array<vec3, 3> p = corners_of(items[k].triangle);
            b.triangle[k] = items[k].triangle;
            for (std::size_t i = 0; i < 3; ++i) {
                const auto axis = static_cast<glm::length_t>(i);
                b.value[i][k] = p[0][axis];
                b.value[3 + i][k] = p[1][axis] - p[0][axis];
                b.value[6 + i][k] = p[2][axis] - p[0][axis];
            }
        }
        blocks_.push_back(b);
        return static_cast<std::uint32_t>(blocks_.size() - 1);
    }

    [[nodiscard]] static float blocks_for(std::size_t count) noexcept {
        const std::size_t blocks = (count + width - 1) / width;
        return static_cast<float>(blocks);
    }

    /// Sorts items to two sides of a plane between bins of centres; gives how many are on the left.
    [[nodiscard]] static std::size_t split_by_area(std::span<item> items) {
        constexpr std::size_t bin_count = 16;
        bounds3 centres;
        for (const item& i : items) centres.add({i.centre(), i.centre()});
        const vec3 extent = centres.high - centres.low;
        const int across = extent.y >= extent.z ? 1 : 2;
        const int widest = extent.x >= extent[across] ? 0 : across;
        const float scale = static_cast<float>(bin_count) / extent[widest];
        if (!std::isfinite(scale)) return items.size() / 2;  // all centres are one
        const auto bin_of = [&](const item& i) {
            const float bin = (i.centre()[widest] - centres.low[widest]) * scale;
            return std::min(static_cast<std::size_t>(bin), bin_count - 1);
        };
        std::array<bounds3, bin_count> boxes{};
        std::array<std::size_t, bin_count> counts{};
        for (const item& i : items) {
            const std::size_t bin = bin_of(i);
            boxes[bin].add(i.box);
            ++counts[bin];
        }
        std::array<float, bin_count> cost_of_right{};
        bounds3 right;
        std::size_t right_count = 0;
        for (std::size_t bin = bin_count; --bin > 0;) {
            right.add(boxes[bin]);
            right_count += counts[bin];
            cost_of_right[bin] = right.area() * blocks_for(right_count);
        }
        bounds3 left;
        std::size_t left_count = 0;
        std::size_t best = 1;
        float least = std::numeric_limits<float>::infinity();
        for (std::size_t bin = 1; bin < bin_count; ++bin) {
            left.add(boxes[bin - 1]);
            left_count += counts[bin - 1];
            const float cost = left.area() * blocks_for(left_count) + cost_of_right[bin];
            if (left_count > 0 && left_count < items.size() && cost < least) {
                least = cost;
                best = bin;
            }
        }
        const auto middle = std::partition(items.begin(), items.end(),
                                           [&](const item& i) { return bin_of(i) < best; });
        return static_cast<std::size_t>(middle - items.begin());
    }

    // --- Rays ---------------------------------------------------------------------------------

    template <class V>
    struct ray_lanes {
        std::array<V, 3> origin, direction, inverse;
        std::array<std::size_t, 3> near_side, far_side;  ///< rows of node::bounds
        V near;

        explicit ray_lanes(const ray& r) noexcept : near(simd::lanes<V>::fill(r.near)) {
            for (std::size_t i = 0; i < 3; ++i) {
                const auto axis = static_cast<glm::length_t>(i);
                const float d = r.direction[axis];
                // Never 0 · ∞ where the origin lies on the side of a box.
                const float safe = std::abs(d) > 1e-18f ? d : std::copysign(1e-18f, d);
                origin[i] = simd::lanes<V>::fill(r.origin[axis]);
                direction[i] = simd::lanes<V>::fill(d);
                inverse[i] = simd::lanes<V>::fill(1 / safe);
                near_side[i] = 2 * i + (safe < 0 ? 1 : 0);
                far_side[i] = 2 * i + (safe < 0 ? 0 : 1);
            }
        }
    };

    /// Where the ray enters each box; below 0 where it misses.
    template <class V>
    static void enter(const node& n, const ray_lanes<V>& r, float far,
                      lane_values& entry) noexcept {
        using lanes = simd::lanes<V>;
        for (std::size_t k = 0; k < width; k += lanes::count) {
            const auto at = [&](std::size_t row, std::size_t axis) {
                return (lanes::load(&n.bounds[row][k]) - r.origin[axis]) * r.inverse[axis];
            };
            const V first = simd::max(simd::max(at(r.near_side[0], 0), at(r.near_side[1], 1)),
                                      simd::max(at(r.near_side[2], 2), r.near));
            const V last = simd::min(simd::min(at(r.far_side[0], 0), at(r.far_side[1], 1)),
                                     simd::min(at(r.far_side[2], 2), lanes::fill(far)));
            // Rounding of the three products; Ize: Robust BVH ray traversal. JCGT 2(2), 2013.
            const V reach = last * lanes::fill(1 + 4e-7f);
            lanes::store(&entry[k], simd::select(first <= reach, first, lanes::fill(-1)));
        }
    }

    /// Where the ray meets each triangle; below 0 where it misses.
    template <class V>
    static void meet(const block& block, const ray_lanes<V>& r, lane_values& distance,
                     lane_values& b, lane_values& c) noexcept {
        using lanes = simd::lanes<V>;
        using vector = std::array<V, 3>;
        const auto cross = [](const vector& p, const vector& q) {
            return vector{p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2],
                          p[0] * q[1] - p[1] * q[0]};
        };
        const auto dot = [](const vector& p, const vector& q) {
            return p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
        };
        for (std::size_t k = 0; k < width; k += lanes::count) {
            const auto load = [&](std::size_t row) {
                return vector{lanes::load(&block.value[row][k]),
                              lanes::load(&block.value[row + 1][k]),
                              lanes::load(&block.value[row + 2][k])};
            };
            const vector corner = load(0);
            const vector e1 = load(3);
            const vector e2 = load(6);
            const vector p = cross(r.direction, e2);
            const V inverse = lanes::fill(1) / dot(e1, p);
            const vector s{r.origin[0] - corner[0], r.origin[1] - corner[1],
                           r.origin[2] - corner[2]};
            const V u = dot(s, p) * inverse;
            const vector q = cross(s, e1);
            const V v = dot(r.direction, q) * inverse;
            const V t = dot(e2, q) * inverse;
            // Between two triangles that share an edge no ray slips through. NaN, of triangles
            // without area, comes last and so stays.
            const V inside = simd::min(simd::min(u, v), lanes::fill(1) - (u + v));
            const V slack = lanes::fill(-2e-6f);
            lanes::store(&distance[k], simd::select(inside >= slack, t, lanes::fill(-1)));
            lanes::store(&b[k], u);
            lanes::store(&c[k], v);
        }
    }

    /// Calls on_hit(hit, far) for triangles on the ray's way, roughly from near to far, until it
    /// gives true. It may move `far` nearer.
    template <class V, class OnHit>
    void walk(const ray& r, const OnHit& on_hit) const noexcept {
        if (nodes_.empty()) return;
        struct entered {
            std::uint32_t child;
            float entry;
        };
        const ray_lanes<V> in_lanes(r);
        float far = r.far;
        std::array<entered, stack_size> stack;
        std::size_t size = 0;
        stack[size++] = {0, r.near};
        lane_values distance, b, c;
        while (size > 0) {
            const entered next = stack[--size];
            if (next.entry > far) continue;
            if ((next.child & block_bit) == 0) {
                const node& n = nodes_[next.child];
                enter(n, in_lanes, far, distance);
                const std::size_t first = size;
                for (std::size_t k = 0; k < width; ++k) {
                    if (distance[k] < 0) continue;
                    std::size_t at = size++;  // farthest first
                    for (; at > first && stack[at - 1].entry < distance[k]; --at) {
                        stack[at] = stack[at - 1];
                    }
                    stack[at] = {n.child[k], distance[k]};
                }
                continue;
            }
            const block& triangles = blocks_[next.child & ~block_bit];
            meet(triangles, in_lanes, distance, b, c);
            for (std::size_t k = 0; k < width; ++k) {
                if (!(distance[k] >= r.near && distance[k] <= far)) continue;
                if (on_hit(ray_hit{triangles.triangle[k], distance[k], b[k], c[k]}, far)) return;
            }
        }
    }

    std::vector<node> nodes_{};
    std::vector<block> blocks_{};
};

}  // namespace billow::inline BILLOW_ABI
