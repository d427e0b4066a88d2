#include <billow/bake/pack_skyline.hpp>

#include <numeric>

#include <doctest/doctest.h>

#include <billow/core/random.hpp>

namespace {

using namespace billow;
using detail::placing_rule;

constexpr placing_rule rules[] = {placing_rule::lowest, placing_rule::best_fit};

std::vector<std::uint32_t> in_order(std::size_t count) {
    std::vector<std::uint32_t> order(count);
    std::iota(order.begin(), order.end(), 0u);
    return order;
}

}  // namespace

TEST_SUITE("bake/pack_skyline") {
    TEST_CASE("rectangles with a place do not overlap and stay in the room") {
        for (std::uint64_t seed = 0; seed < 60; ++seed) {
            random_stream random(seed);
            std::vector<ivec2> sizes;
            for (int i = 0; i < 40; ++i) {
                sizes.emplace_back(random.between(1, 12), random.between(1, 12));
            }
            const detail::strip room{20 + static_cast<int>(seed % 7), 60, seed % 2 == 0, false};
            for (const placing_rule rule : rules) {
                detail::strip_packer packer;
                const auto use = packer.fill(sizes, in_order(40), rule, room);
                std::vector<int> owner(static_cast<std::size_t>(room.width * room.height));
                std::int64_t area = 0;
                ivec2 corner(0);
                bool has_all = true;
                for (std::size_t i = 0; i < sizes.size(); ++i) {
                    const detail::strip_place& p = packer.places()[i];
                    has_all = has_all && p.x >= 0;
                    if (p.x < 0) continue;
                    CHECK((room.allows_turns || !p.is_turned));
                    const ivec2 size = p.is_turned ? ivec2(sizes[i].y, sizes[i].x) : sizes[i];
                    corner = glm::max(corner, ivec2(p.x, p.y) + size);
                    REQUIRE(corner.x <= room.width);
                    REQUIRE(corner.y <= room.height);
                    area += std::int64_t{size.x} * size.y;
                    for (int y = p.y; y < p.y + size.y; ++y) {
                        for (int x = p.x; x < p.x + size.x; ++x) {
                            ++owner[static_cast<std::size_t>(y * room.width + x)];
                        }
                    }
                }
                CHECK(*std::max_element(owner.begin(), owner.end()) == 1);
                CHECK(use.area == area);
                CHECK(use.width == corner.x);
                CHECK(use.height == corner.y);
                CHECK(use.holds_all == has_all);
            }
        }
    }

    TEST_CASE("the lowest place is taken, the leftmost of equals") {
        const std::vector<ivec2> sizes{{4, 3}, {4, 1}, {2, 2}, {2, 1}};
        detail::strip_packer packer;
        packer.fill(sizes, in_order(4), placing_rule::lowest, {10, 9, false, true});
        CHECK(packer.places()[1].x == 4);
        CHECK(packer.places()[2].x == 8);
        CHECK(packer.places()[3].x == 4);
        CHECK(packer.places()[3].y == 1);
    }

    TEST_CASE("a gap gets the rectangle that fits it, though it comes last") {
        const std::vector<ivec2> sizes{{6, 5}, {2, 2}, {2, 3}, {4, 5}};
        detail::strip_packer packer;
        const auto use =
            packer.fill(sizes, in_order(4), placing_rule::best_fit, {10, 20, false, true});
        CHECK(packer.places()[3].x == 6);
        CHECK(packer.places()[3].y == 0);
        CHECK(use.height == 8);
    }

    TEST_CASE("it gives up where all are needed, and goes on where not") {
        const std::vector<ivec2> sizes{{4, 4}, {9, 9}, {4, 4}};
        for (const placing_rule rule : rules) {
            detail::strip_packer packer;
            CHECK_FALSE(packer.fill(sizes, in_order(3), rule, {8, 4, true, true}).holds_all);
            const auto use = packer.fill(sizes, in_order(3), rule, {8, 4, true, false});
            CHECK(use.area == 32);
            CHECK(packer.places()[1].x < 0);
            CHECK(packer.places()[2].x >= 0);
        }
    }
}
