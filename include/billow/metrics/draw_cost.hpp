// What it costs to keep a mesh and to draw it: triangles, bytes of textures, fragments.
#pragma once

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <billow/bake/baked_cloud.hpp>
#include <billow/image/image.hpp>
#include <billow/mesh/mesh.hpp>
#include <billow/metrics/statistic.hpp>

namespace billow::inline BILLOW_ABI {

/// Bytes of images that are neither packed nor compressed, with the channels they have.
struct texture_bytes {
    std::uint64_t level_0 = 0;
    std::uint64_t with_mips = 0;  ///< all levels down to 1 × 1, sides halved and rounded down

    texture_bytes& operator+=(const texture_bytes& other) noexcept {
        level_0 += other.level_0;
        with_mips += other.with_mips;
        return *this;
    }
    [[nodiscard]] bool operator==(const texture_bytes&) const = default;
};

[[nodiscard]] inline texture_bytes texture_bytes_of(const image& of) noexcept {
    if (of.empty()) return {};
    texture_bytes bytes;
    auto width = static_cast<std::uint64_t>(of.width);
    auto height = static_cast<std::uint64_t>(of.height);
    const auto channels = static_cast<std::uint64_t>(of.channels);
    bytes.level_0 = width * height * channels;
    bytes.with_mips = bytes.level_0;
    while (width > 1 || height > 1) {
        width = std::max<std::uint64_t>(1, width / 2);
        height = std::max<std::uint64_t>(1, height / 2);
        bytes.with_mips += width * height * channels;
    }
    return bytes;
}

/// Of all images of a mesh: of an original's, or of those that a cloud's mesh has brought along.
[[nodiscard]] inline texture_bytes texture_bytes_of(const mesh& of) noexcept {
    texture_bytes bytes;
    for (const image& i : of.images) bytes += texture_bytes_of(i);
    return bytes;
}

/// Of all channels of all atlases.
[[nodiscard]] inline texture_bytes texture_bytes_of(const baked_cloud& of) noexcept {
    texture_bytes bytes;
    for (const atlas& a : of.atlases) {
        bytes += texture_bytes_of(a.base_color);
        bytes += texture_bytes_of(a.normal);
        bytes += texture_bytes_of(a.occlusion_roughness_metallic);
        bytes += texture_bytes_of(a.emissive);
        bytes += texture_bytes_of(a.horizon);
    }
    return bytes;
}

struct draw_cost {
    std::size_t triangles = 0;
    texture_bytes textures{};
};

[[nodiscard]] inline draw_cost draw_cost_of(const mesh& of) noexcept {
    return {of.face_count(), texture_bytes_of(of)};
}

/// What a view counts of the fragments it draws, such as `render_counts`.
template <class C>
concept fragment_counts = requires(const C& counts) {
    { counts.overdraw() } -> std::convertible_to<double>;
};

/// Fragments drawn for each pixel covered, over views.
template <fragment_counts Counts>
[[nodiscard]] statistic overdraw_over(std::span<const Counts> views) {
    std::vector<double> values;
    values.reserve(views.size());
    for (const Counts& counts : views) values.push_back(counts.overdraw());
    return statistic_of(values);
}

}  // namespace billow::inline BILLOW_ABI
