// What the baker makes of a billboard cloud: atlases, and where each billboard's tiles lie.
#pragma once

#include <cstdint>
#include <vector>

#include <billow/core/types.hpp>
#include <billow/image/image.hpp>

namespace billow::inline BILLOW_ABI {

/// The texels of one side of a billboard within an atlas: columns [x, x + width), rows
/// [y, y + height), without padding. Texel rows run from the top, so the billboard's v axis points up
/// in the tile and its u axis to the right, on a back to the left; a rotated tile has been turned by
/// 90° clockwise (an axis to the right then runs down, one up to the right).
struct tile {
    atlas_id atlas = no_id;
    int x = 0;
    int y = 0;
    int width = 0;   ///< in the atlas, so along v when rotated
    int height = 0;  ///< in the atlas, so along u when rotated
    bool is_rotated = false;
};

/// How normals are told, so that they are lit rightly from both sides of a billboard.
enum class normal_style : std::uint8_t {
    folded,  ///< as seen from the front; one double-sided polygon, whose back mirrors them
    sheets,  ///< front and back each on a single-sided polygon, with tiles of their own
    object,  ///< in scene space on two single-sided polygons: the texture is no longer bound to them
    dome,    ///< as object, but blended with the directions out of the cloud's middle
};

/// Textures of the same size and layout. Channels that say nothing are left empty.
struct atlas {
    image base_color{};  ///< RGBA, sRGB, straight alpha, opaque from 128 on
    /// RGB. Tangent space of the tile: x to the right and y up in the atlas, z out of the drawn side
    /// and above 0; or scene space, see normal_style.
    image normal{};
    image occlusion_roughness_metallic{};  ///< RGB, linear
    image emissive{};                      ///< RGB, sRGB
    image horizon{};  ///< RGBA, linear: the visible sky in scene space, see decode_horizon

    [[nodiscard]] int width() const noexcept { return base_color.width; }
    [[nodiscard]] int height() const noexcept { return base_color.height; }
};

/// Shape  B billboards, T tiles: tiles 0 to B - 1 are the fronts in the order of the billboards;
///        `back_of` and `outlines` have one row a billboard, or none.
struct baked_cloud {
    std::vector<tile> tiles{};
    std::vector<std::uint32_t> back_of{};  ///< row of `tiles`; no_id: the front serves both sides
    /// Convex polygons around what is opaque, counter-clockwise from the front, in the billboard's
    /// coordinates (s, t); none: the whole rectangles.
    std::vector<std::vector<dvec2>> outlines{};
    std::vector<atlas> atlases{};
    normal_style normals = normal_style::folded;
    double texel_size = 0;    ///< scene units a texel side, the same for every tile
    double wanted_size = 0;   ///< what was asked for; less, where tiles would not fit
    double fill = 0;          ///< share of the atlases' area that is tiles, padding not counted
    double opaque_area = 0;   ///< texels of fronts that an alpha test draws
    double polygon_area = 0;  ///< texels of fronts within the outlines

    [[nodiscard]] std::uint32_t back_tile(std::size_t billboard) const noexcept {
        return back_of.empty() ? no_id : back_of[billboard];
    }
    /// Fragments that an alpha test discards, for each that it draws, over all directions: planes
    /// that nothing hides are seen as often, and as obliquely, as others.
    [[nodiscard]] double overdraw() const noexcept {
        return opaque_area > 0 ? (polygon_area - opaque_area) / opaque_area : 0;
    }
};

}  // namespace billow::inline BILLOW_ABI
