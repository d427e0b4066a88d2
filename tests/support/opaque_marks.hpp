// Marks for fill_borders of atlases that were made by hand.
#pragma once

#include <vector>

#include <billow/bake/baked_cloud.hpp>

namespace support {

/// Counts what is opaque as covered.
[[nodiscard]] inline std::vector<std::vector<char>> opaque_marks(const billow::baked_cloud& baked) {
    std::vector<std::vector<char>> marks;
    for (const billow::atlas& a : baked.atlases) {
        std::vector<char>& in = marks.emplace_back();
        for (std::size_t i = 3; i < a.base_color.bytes.size(); i += 4) {
            in.push_back(a.base_color.bytes[i] != 0 ? 1 : 0);
        }
    }
    return marks;
}

}  // namespace support
