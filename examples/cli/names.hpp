// What the tool calls the kinds that the library has: to read options and to write reports.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <billow/bake/bake_cloud.hpp>
#include <billow/improve/weld.hpp>
#include <billow/io/mip_files.hpp>
#include <billow/search/greedy.hpp>

namespace cli {

template <class Kind, std::size_t Count>
using name_table = std::array<std::pair<Kind, std::string_view>, Count>;

inline constexpr name_table<billow::refinement, 3> refinement_names{
    {{billow::refinement::original, "original"},
     {billow::refinement::fail_safe, "fail-safe"},
     {billow::refinement::none, "none"}}};
inline constexpr name_table<billow::falloff_use, 3> falloff_names{
    {{billow::falloff_use::everywhere, "on"},
     {billow::falloff_use::nowhere, "off"},
     {billow::falloff_use::refinement, "refine"}}};
inline constexpr name_table<billow::weld_kind, 3> weld_kind_names{
    {{billow::weld_kind::none, "none"},
     {billow::weld_kind::first, "first"},
     {billow::weld_kind::intersection, "intersection"}}};
inline constexpr name_table<billow::crack_reduction, 2> crack_names{
    {{billow::crack_reduction::none, "none"}, {billow::crack_reduction::envelope, "envelope"}}};
inline constexpr name_table<billow::alpha_kind, 3> alpha_names{
    {{billow::alpha_kind::binary, "binary"},
     {billow::alpha_kind::coverage, "coverage"},
     {billow::alpha_kind::distance, "sdf"}}};
inline constexpr name_table<billow::opaque_area, 3> area_names{
    {{billow::opaque_area::thresholds, "thresholds"},
     {billow::opaque_area::covered, "covered"},
     {billow::opaque_area::surface, "surface"}}};
inline constexpr name_table<billow::normal_style, 4> normal_names{
    {{billow::normal_style::folded, "folded"},
     {billow::normal_style::sheets, "sheets"},
     {billow::normal_style::object, "object"},
     {billow::normal_style::dome, "dome"}}};
inline constexpr name_table<billow::tile_sides, 3> side_names{
    {{billow::tile_sides::automatic, "auto"},
     {billow::tile_sides::one, "one"},
     {billow::tile_sides::two, "two"}}};

inline constexpr name_table<billow::mip_format, 3> mip_names{{{billow::mip_format::none, "none"},
                                                              {billow::mip_format::png, "png"},
                                                              {billow::mip_format::dds, "dds"}}};

template <class Kind, std::size_t Count>
[[nodiscard]] std::string name_in(const name_table<Kind, Count>& table, Kind kind) {
    for (const auto& [value, name] : table) {
        if (value == kind) return std::string(name);
    }
    return {};
}

/// Needs a name of the table.
template <class Kind, std::size_t Count>
[[nodiscard]] Kind kind_in(const name_table<Kind, Count>& table, std::string_view name) {
    for (const auto& [value, known] : table) {
        if (known == name) return value;
    }
    return table.front().first;
}

template <class Kind, std::size_t Count>
[[nodiscard]] std::vector<std::string> names_in(const name_table<Kind, Count>& table) {
    std::vector<std::string> names;
    for (const auto& entry : table) names.emplace_back(entry.second);
    return names;
}

}  // namespace cli
