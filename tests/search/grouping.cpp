#include <billow/search/grouping.hpp>

#include <doctest/doctest.h>

#include "support/meshes.hpp"

using namespace billow;

TEST_SUITE("search/grouping") {
    TEST_CASE("the whole set is every row, in order") {
        const face_table faces = support::table_of(support::random_triangles(37, 0.3, 2));
        const face_rows all = whole_set{}(faces, {}, 0.1, {});
        CHECK(all.size() == 37);
        for (std::uint32_t row = 0; row < all.size(); ++row) CHECK(all[row] == row);
        CHECK(whole_set{}(face_table{}, {}, 0.1, {}).empty());
    }
}
