// What the baker makes of a billboard cloud: atlases, and where each billboard's tile lies.
#pragma once

#include <vector>

#include <billow/core/types.hpp>
#include <billow/image/image.hpp>

namespace billow::inline BILLOW_ABI {

/// The texels of a billboard within an atlas: columns [x, x + width), rows [y, y + height), without
/// padding. Texel rows run from the top, so the billboard's v axis points up in the tile; a rotated
/// tile has been turned by 90° clockwise (the billboard's u axis runs down, its v axis to the right).
struct tile {
    atlas_id atlas = no_id;
    int x = 0;
    int y = 0;
    int width = 0;   ///< in the atlas, so along v when rotated
    int height = 0;  ///< in the atlas, so along u when rotated
    bool is_rotated = false;
};

/// Textures of the same size and layout. Channels that say nothing are left empty.
struct atlas {
    image base_color{};  ///< RGBA, sRGB, straight alpha of 0 or 255
    /// RGB, tangent space of the tile: x to the right and y up in the atlas (so v and -u of a rotated
    /// billboard), z along its normal and above 0.
    image normal{};
    image occlusion_roughness_metallic{};  ///< RGB, linear
    image emissive{};                      ///< RGB, sRGB
    image horizon{};  ///< RGBA, linear: the visible sky in scene space, see decode_horizon

    [[nodiscard]] int width() const noexcept { return base_color.width; }
    [[nodiscard]] int height() const noexcept { return base_color.height; }
};

/// One tile a billboard, in the order of the cloud's billboards.
struct baked_cloud {
    std::vector<tile> tiles{};
    std::vector<atlas> atlases{};
    double texel_size = 0;  ///< scene units a texel side, the same for every tile
    double fill = 0;        ///< share of the atlases' area that is tiles, padding not counted
};

}  // namespace billow::inline BILLOW_ABI
