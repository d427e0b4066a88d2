#include <billow/plants/skeleton.hpp>

#include <doctest/doctest.h>

#include <billow/plants/turtle.hpp>

using namespace billow;

namespace {

skeleton grown_bones(unsigned generations) {
    auto bones = interpret(*expand(forest_paper_grammar(), {.generations = generations}));
    REQUIRE(bones);
    return *std::move(bones);
}

}  // namespace

TEST_SUITE("plants/skeleton") {
    TEST_CASE("the cross-section of a parent is the sum of its children's") {
        skeleton bones = grown_bones(4);
        assign_radii(bones, {.trunk = 0.2});
        std::vector<double> sums(bones.segment_count(), 0);
        for (std::size_t i = 0; i < bones.segment_count(); ++i) {
            const double r = double(bones.end_radii[i]);
            if (bones.parents[i] != no_id) sums[bones.parents[i]] += r * r;
        }
        const double tip = 0.2 / std::sqrt(double(tip_count(bones)));
        for (std::size_t i = 0; i < bones.segment_count(); ++i) {
            const double r = double(bones.end_radii[i]);
            if (sums[i] > 0) {
                REQUIRE(r * r == doctest::Approx(sums[i]).epsilon(1e-6));
            } else {
                REQUIRE(r == doctest::Approx(tip));
            }
        }
        CHECK(bones.end_radii[0] == doctest::Approx(0.2));
    }

    TEST_CASE("a continuation starts as wide as its parent ends, a side branch no wider") {
        skeleton bones = grown_bones(4);
        assign_radii(bones);
        const auto heirs = continuations(bones);
        int heir_count = 0;
        for (std::uint32_t i = 0; i < bones.segment_count(); ++i) {
            const std::uint32_t parent = bones.parents[i];
            if (parent == no_id) continue;
            REQUIRE(bones.start_radii[i] <= bones.end_radii[parent]);
            if (heirs[parent] != i) continue;
            ++heir_count;
            REQUIRE(bones.start_radii[i] == bones.end_radii[parent]);
        }
        CHECK(heir_count > 0);
    }

    TEST_CASE("the child that turns least continues, and none that turns back") {
        const skeleton bones = *interpret("F[+(40)F][-(10)F][&(20)F]");
        CHECK(continuations(bones) == std::vector<std::uint32_t>{2, no_id, no_id, no_id});
        CHECK(continuations(*interpret("F[+(120)F]"))[0] == no_id);
        CHECK(continuations(*interpret("F[/F][\\F]"))[0] == 1);  // equal turns: the first
    }

    TEST_CASE("the highest twig ends at the height asked for") {
        skeleton bones = grown_bones(3);
        REQUIRE(scale_to_height(bones, 8));
        double top = 0;
        for (const dvec3& end : bones.ends) top = std::max(top, end.y);
        CHECK(top == doctest::Approx(8));
        skeleton hanging = *interpret("|F");
        CHECK_FALSE(scale_to_height(hanging, 8));
        skeleton nothing;
        CHECK_FALSE(scale_to_height(nothing, 8));
    }
}
