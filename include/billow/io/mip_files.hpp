// The mip levels of baked atlases as files: one DDS a channel, or one PNG a channel and level.
#pragma once

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <billow/bake/baked_cloud.hpp>
#include <billow/bake/mips.hpp>
#include <billow/core/expected.hpp>
#include <billow/core/parallel.hpp>
#include <billow/image/image.hpp>
#include <billow/io/dds.hpp>
#include <billow/io/image_file.hpp>

namespace billow::inline BILLOW_ABI {

enum class mip_format { none, png, dds };

/// What write_mips has written.
struct mip_files {
    std::vector<std::filesystem::path> names{};
    int safe_levels = 0;  ///< of all atlases, see safe_mip_levels; 0 where nothing was written
};

/// Writes all levels of all channels: tree_basecolor.dds, tree_normal.dds, tree_orm.dds,
/// tree_emissive.dds, tree_horizon.dds for the stem "tree", as far as there are such channels; as PNG
/// tree_basecolor_mip0.png, tree_basecolor_mip1.png … Further atlases are tree_1_basecolor.dds …
///
/// Needs   as make_mips.
/// Gives   the files in the order in which they were written.
/// Fails   as write_file; what was written before stays.
[[nodiscard]] inline expected<mip_files> write_mips(const std::filesystem::path& stem,
                                                    const baked_cloud& baked, mip_format format,
                                                    const mip_options& options = {},
                                                    parallel threads = {}) {
    mip_files files;
    if (format == mip_format::none) return files;
    const auto mips = make_mips(baked, options, threads);
    for (std::size_t id = 0; id < mips.size(); ++id) {
        const atlas_mips& of = mips[id];
        files.safe_levels = id == 0 ? of.safe_levels : std::min(files.safe_levels, of.safe_levels);
        const auto name = [&](std::string_view map, const std::string& ending) {
            std::filesystem::path file = stem;
            if (id > 0) file += "_" + std::to_string(id);
            file += "_" + std::string(map) + ending;
            return file;
        };
        struct map_levels {
            std::string_view name{};
            std::span<const image> levels{};
            bool is_srgb = false;
        };
        for (const map_levels& c :
             {map_levels{"basecolor", of.base_color, true}, map_levels{"normal", of.normal},
              map_levels{"orm", of.occlusion_roughness_metallic},
              map_levels{"emissive", of.emissive, true}, map_levels{"horizon", of.horizon}}) {
            if (c.levels.empty()) continue;
            if (format == mip_format::dds) {
                files.names.push_back(name(c.name, ".dds"));
                const auto written = write_dds(files.names.back(), c.levels, c.is_srgb);
                if (!written) return written.error();
                continue;
            }
            for (std::size_t level = 0; level < c.levels.size(); ++level) {
                files.names.push_back(name(c.name, "_mip" + std::to_string(level) + ".png"));
                const auto written = write_png(files.names.back(), c.levels[level]);
                if (!written) return written.error();
            }
        }
    }
    return files;
}

}  // namespace billow::inline BILLOW_ABI
