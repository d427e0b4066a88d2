// billow_thesis: the published tables measured anew, what users would pick instead, and all searches
// against each other. Writes docs/results.md; see docs/results.md for how to run it.
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <limits>
#include <map>
#include <string>
#include <string_view>
#include <utility>

#include <billow/metrics/baselines.hpp>
#include <billow/metrics/compare.hpp>

#if defined(BILLOW_HAS_REDUCE)
#include <billow/reduce.hpp>
#endif

#include "clouds.hpp"
#include "models.hpp"
#include "report.hpp"

namespace {

using namespace billow;
using namespace thesis;

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

struct setup {
    model_store models;
    view_settings views{};
    std::size_t most_faces = 70'000;  ///< of models whose epsilon is searched for a plane count
};

/// What a table of the thesis tells of a cloud; per cent as printed. NaN: not told.
struct published {
    double planes = unknown;
    double coverage = unknown;
    double geometric = unknown;
    double color = unknown;
    double gap = unknown;
    double level = unknown;
    double seconds = unknown;
    double skipped = unknown;
};

/// One row: a variant of a cloud with its published counterpart.
struct experiment {
    std::string variant{};
    recipe how{};
    published theirs{};
};

enum class column { planes, coverage, geometric, color, gap, level, skipped, seconds };

struct column_kind {
    const char* title;
    double published::*theirs;
    int decimals;
    std::function<std::string(const cloud_made&, const picture_means&)> ours;
};

const column_kind& kind_of(column c) {
    static const std::map<column, column_kind> kinds{
        {column::planes,
         {"planes", &published::planes, 0,
          [](const cloud_made& made, const picture_means&) {
              return std::to_string(made.planes);
          }}},
        {column::coverage,
         {"coverage %", &published::coverage, 1,
          [](const cloud_made&, const picture_means& seen) {
              return number(100 * seen.coverage, 1);
          }}},
        {column::geometric,
         {"geometric % of diameter", &published::geometric, 1,
          [](const cloud_made& made, const picture_means&) {
              return number(50 * made.geometric, 2);
          }}},
        {column::color,
         {"colour", &published::color, 2,
          [](const cloud_made&, const picture_means& seen) { return number(seen.color, 2); }}},
        {column::gap,
         {"gap", &published::gap, 2,
          [](const cloud_made&, const picture_means& seen) {
              return number(seen.gap_intensity, 2);
          }}},
        {column::level,
         {"level", &published::level, 1,
          [](const cloud_made& made, const picture_means&) {
              return number(made.refinement_level, 1);
          }}},
        {column::skipped,
         {"skipped %", &published::skipped, 1,
          [](const cloud_made& made, const picture_means&) {
              return number(100 * made.skipped_area_share, 1);
          }}},
        {column::seconds,
         {"seconds", &published::seconds, 1,
          [](const cloud_made& made, const picture_means&) { return number(made.seconds, 2); }}},
    };
    return kinds.at(c);
}

/// A table of experiments: a few models, each with its variants, on one or both bases of epsilon.
class experiment_table {
public:
    experiment_table(setup& with, std::vector<column> columns, bool has_both_bases)
        : setup_(with), columns_(std::move(columns)), has_both_bases_(has_both_bases) {
        head_ = {"model", "variant"};
        if (has_both_bases_) head_.push_back("ε of");
        for (const column c : columns_) {
            head_.emplace_back(kind_of(c).title);
            head_.emplace_back("*published*");
        }
    }

    void add(const std::string& model, std::vector<experiment> experiments) {
        const model_store::model& of = setup_.models.of(model);
        std::vector<cloud_made> made;
        std::vector<const mesh*> clouds;
        const int bases = has_both_bases_ ? 2 : 1;
        std::vector<std::size_t> wanted(experiments.size(), 0);
        for (int base = 1; base <= bases; ++base) {
            for (std::size_t i = 0; i < experiments.size(); ++i) {
                recipe how = experiments[i].how;
                how.epsilon *= base;
                // A row of as many planes as the first follows the first of the same base.
                if (how.planes != 0) how.planes = wanted[0];
                made.push_back(make_cloud(of.mesh, how, setup_.views));
                if (i == 0) wanted[0] = made.back().planes;
                std::fprintf(stderr, "  %s, %s, base %d: %zu planes, %.2f s\n", of.name.c_str(),
                             experiments[i].variant.c_str(), base, made.back().planes,
                             made.back().seconds);
            }
        }
        for (const cloud_made& m : made) clouds.push_back(&m.mesh);
        const std::vector<picture_means> seen = look_at(of.mesh, clouds, setup_.views);
        for (std::size_t i = 0; i < experiments.size(); ++i) {
            for (int base = 1; base <= bases; ++base) {
                const std::size_t at = static_cast<std::size_t>(base - 1) * experiments.size() + i;
                std::vector<std::string> row{model + " (" + of.name + ")", experiments[i].variant};
                if (has_both_bases_) row.emplace_back(base == 1 ? "radius" : "diameter");
                for (const column c : columns_) {
                    const column_kind& kind = kind_of(c);
                    row.push_back(kind.ours(made[at], seen[at]));
                    const double theirs = experiments[i].theirs.*kind.theirs;
                    row.push_back(std::isfinite(theirs) && base == 1
                                      ? '*' + number(theirs, kind.decimals) + '*'
                                      : "");
                }
                rows_.push_back(std::move(row));
            }
        }
    }

    [[nodiscard]] section done(std::string title, std::string about) const {
        return {
            .title = std::move(title), .about = std::move(about), .columns = head_, .rows = rows_};
    }

private:
    setup& setup_;
    std::vector<column> columns_;
    bool has_both_bases_;
    std::vector<std::string> head_{};
    std::vector<std::vector<std::string>> rows_{};
};

// --- The thesis ------------------------------------------------------------------------------

section falloff(setup& with) {
    experiment_table table(
        with, {column::planes, column::geometric, column::coverage, column::level, column::seconds},
        true);
    const recipe none{.how = method::unfitted,
                      .epsilon = 0.06,
                      .raster = 20,
                      .rho_rate = 2,
                      .penalty = 2,
                      .falls = false};
    recipe with_falloff = none;
    with_falloff.falls = true;
    const auto pair = [&](const char* model, const published& without, const published& falling) {
        table.add(model, {{"no falloff", none, without}, {"falloff", with_falloff, falling}});
    };
    pair("teapot", {.planes = 22, .geometric = 1.4, .level = 1.4, .seconds = 4.5},
         {.planes = 20, .geometric = 1.3, .level = 1.8, .seconds = 4.9});
    pair("screwdriver", {.planes = 16, .geometric = 1.4, .level = 3.1, .seconds = 56},
         {.planes = 14, .geometric = 0.7, .level = 2.4, .seconds = 43});
    pair("gas can", {.planes = 16, .geometric = 1.7, .level = 1.8, .seconds = 1.7},
         {.planes = 18, .geometric = 1.0, .level = 1.6, .seconds = 1.6});
    pair("barrel", {.planes = 44, .geometric = 1.4, .level = 1.9, .seconds = 33},
         {.planes = 43, .geometric = 1.0, .level = 1.6, .seconds = 32});
    return table.done("Table 5.1: distance falloff",
                      "ε 6 %, raster 20, 2 offset bins an ε, penalty 2, planes not fitted. The "
                      "thesis's seconds are those of refinement, ours those of the search.");
}

section fitting(setup& with) {
    experiment_table table(with, {column::planes, column::coverage, column::geometric}, true);
    const recipe as_found{.how = method::unfitted, .falls = false};
    recipe fitted = as_found;
    fitted.how = method::density;
    const auto pair = [&](const char* model, const published& before, const published& after) {
        table.add(model, {{"as found", as_found, before}, {"least squares", fitted, after}});
    };
    pair("hut", {.coverage = 8.5, .geometric = 1.4}, {.coverage = 3.2, .geometric = 0.2});
    pair("box", {.coverage = 2.2, .geometric = 1.2}, {.coverage = 1.9, .geometric = 1.2});
    pair("gas can", {.coverage = 5.0, .geometric = 1.5}, {.coverage = 4.4, .geometric = 0.9});
    pair("windmill", {.coverage = 5.6, .geometric = 1.4}, {.coverage = 5.3, .geometric = 0.8});
    return table.done("Table 5.2: least squares",
                      "ε 5 %, raster 18, 1.5 bins an ε, penalty 3, no falloff.");
}

section no_refinement(setup& with) {
    experiment_table table(
        with, {column::planes, column::coverage, column::geometric, column::seconds}, false);
    const recipe refined{.epsilon = 0.06, .penalty = 1};
    recipe densest = refined;
    densest.refine = refinement::none;
    const auto pair = [&](const char* model, const published& before, const published& after) {
        table.add(model, {{"refined", refined, before}, {"densest bin", densest, after}});
    };
    pair("barrel", {.planes = 39, .coverage = 9.6, .geometric = 0.8, .seconds = 61},
         {.planes = 30, .coverage = 13.9, .geometric = 0.9, .seconds = 42});
    pair("teapot", {.planes = 22, .coverage = 19, .geometric = 1.4, .seconds = 9},
         {.planes = 15, .coverage = 23.9, .geometric = 1.5, .seconds = 6});
    pair("screwdriver", {.planes = 11, .coverage = 19.5, .geometric = 0.6, .seconds = 83},
         {.planes = 10, .coverage = 21.4, .geometric = 0.7, .seconds = 51});
    return table.done("Section 5.2: no refinement",
                      "ε 6 %, raster 18, 1.5 bins an ε, penalty 1, falloff, least squares.");
}

section skipping(setup& with) {
    experiment_table table(
        with, {column::planes, column::coverage, column::geometric, column::skipped}, false);
    const auto pair = [&](const char* model, double share, bool welds, const published& all,
                          const published& skipped) {
        const recipe every{.epsilon = 0.04, .welds = welds};
        recipe skips = every;
        skips.skip_area = share;
        table.add(model, {{"all faces", every, all}, {"skipping", skips, skipped}});
    };
    pair("Eiffel tower", 0.015, false, {.planes = 54, .coverage = 38.1, .geometric = 0.6},
         {.planes = 38, .coverage = 38.3, .geometric = 0.6, .skipped = 1.5});
    pair("barrel", 0.05, true, {.planes = 65, .coverage = 3.9, .geometric = 0.4},
         {.planes = 50, .coverage = 4.9, .geometric = 0.3, .skipped = 5});
    pair("teapot", 0.05, true, {.planes = 47, .coverage = 8.9, .geometric = 0.5},
         {.planes = 39, .coverage = 10.8, .geometric = 0.6, .skipped = 5});
    return table.done(
        "Section 5.2: face skipping",
        "ε 4 %, raster 18, 1.5 bins an ε, penalty 3, falloff, least squares; the "
        "solids welded. *Skipped %*: area of the faces that had no plane when the search "
        "ended.");
}

section welding(setup& with) {
    experiment_table table(
        with, {column::gap, column::coverage, column::color, column::geometric, column::planes},
        true);
    const recipe torn{.epsilon = 0.06, .skip_area = 0.02};
    recipe welded = torn;
    welded.welds = true;
    const auto pair = [&](const char* model, const published& before, const published& after) {
        table.add(model, {{"torn", torn, before}, {"welded", welded, after}});
    };
    pair("teapot", {.coverage = 10.8, .color = 0.47, .gap = 0.42},
         {.coverage = 11.5, .color = 0.53, .gap = 0.11});
    pair("gas can", {.coverage = 6.0, .color = 0.82, .gap = 0.42},
         {.coverage = 5.8, .color = 0.87, .gap = 0.07});
    pair("barrel", {.coverage = 9.2, .color = 0.36, .gap = 0.96},
         {.coverage = 5.6, .color = 0.35, .gap = 0.29});
    pair("windmill", {.coverage = 8.1, .color = 1.03, .gap = 0.12},
         {.coverage = 6.7, .color = 0.90, .gap = 0.04});
    return table.done("Table 5.3: welding",
                      "ε 6 %, all else as presets::thesis: raster 18, 1.5 bins an ε, penalty 3, "
                      "falloff, least squares, 2 % of the area skipped.");
}

const recipe thesis_best{.skip_area = 0.02};

/// What the tables over all models show to be best for solids.
constexpr double best_tangency = 2;

/// The thesis's method, and our search with the thesis's stochastic one as its counterpart.
std::vector<experiment> both_searches(double epsilon, bool welds, const published& original,
                                      const published& stochastic) {
    recipe density = thesis_best;
    density.epsilon = epsilon;
    density.welds = welds;
    recipe exact = density;
    exact.how = method::exact_refined;
    exact.tangency = best_tangency;
    return {{"density grid", density, original},
            {"exact, refined; *stochastic*", exact, stochastic}};
}

const std::vector<column> all_of_them{column::planes, column::coverage, column::geometric,
                                      column::color,  column::gap,      column::seconds};

section windmill(setup& with) {
    experiment_table table(with, all_of_them, true);
    const published original{
        .planes = 33, .coverage = 10.5, .geometric = 1.2, .color = 1.0, .seconds = 4.5};
    std::vector<experiment> experiments = both_searches(
        0.1, true, original,
        {.planes = 76, .coverage = 10.6, .geometric = 0.5, .color = 1.02, .seconds = 1.5});
    recipe as_many = experiments[1].how;
    as_many.planes = 1;  // as the first row has
    experiments.push_back({"exact, as many planes; *stochastic at 16 %*",
                           as_many,
                           {.planes = 33, .coverage = 14.8, .geometric = 1.2, .color = 1.54}});
    table.add("windmill", std::move(experiments));
    return table.done("Tables 5.5 and 5.6: the windmill",
                      "ε 10 %, raster 18, 1.5 bins an ε, penalty 3, falloff, least squares, 2 % of "
                      "the area skipped, welded.");
}

section searches_compared(setup& with) {
    experiment_table table(with, all_of_them, true);
    table.add("teapot", both_searches(0.05, true,
                                      {.planes = 23,
                                       .coverage = 19.7,
                                       .geometric = 0.9,
                                       .color = 0.55,
                                       .gap = 0.62,
                                       .seconds = 6.2},
                                      {.planes = 33,
                                       .coverage = 10.2,
                                       .geometric = 0.5,
                                       .color = 0.36,
                                       .gap = 0.23,
                                       .seconds = 0.7}));
    table.add("screwdriver", both_searches(0.05, true,
                                           {.planes = 10,
                                            .coverage = 14.5,
                                            .geometric = 0.5,
                                            .color = 0.64,
                                            .gap = -0.01,
                                            .seconds = 58},
                                           {.planes = 12,
                                            .coverage = 16.2,
                                            .geometric = 0.4,
                                            .color = 0.70,
                                            .gap = -0.03,
                                            .seconds = 1}));
    table.add("Eiffel tower", both_searches(0.05, false,
                                            {.planes = 24,
                                             .coverage = 42.5,
                                             .geometric = 1.0,
                                             .color = 1.19,
                                             .gap = -0.05,
                                             .seconds = 292},
                                            {.planes = 31,
                                             .coverage = 41.6,
                                             .geometric = 0.9,
                                             .color = 1.4,
                                             .gap = -0.2,
                                             .seconds = 8}));
    table.add("aspen", both_searches(0.05, false,
                                     {.planes = 122,
                                      .coverage = 18.4,
                                      .geometric = 1,
                                      .color = 2.38,
                                      .gap = -0.1,
                                      .seconds = 1514},
                                     {.planes = 159,
                                      .coverage = 17.7,
                                      .geometric = 1,
                                      .color = 2.97,
                                      .gap = 0.12,
                                      .seconds = 51}));
    return table.done("Table 5.7: four models",
                      "ε 5 %, all else as in table 5.5; teapot and screwdriver welded.");
}

section search_times(setup& with) {
    section made{.title = "Section 5.4: seconds of the search",
                 .about = "ε 10 %, all else as in table 5.5, one thread.",
                 .columns = {"model", "faces", "density grid", "*original*", "exact, refined",
                             "*stochastic*"}};
    const auto row = [&](const char* model, double original, double stochastic) {
        const model_store::model& of = with.models.of(model);
        const auto two = both_searches(0.1, false, {}, {});
        view_settings none = with.views;
        none.texels = 16;
        const cloud_made density = make_cloud(of.mesh, two[0].how, none);
        const cloud_made exact = make_cloud(of.mesh, two[1].how, none);
        made.rows.push_back({std::string(model) + " (" + of.name + ")",
                             std::to_string(of.mesh.face_count()), number(density.seconds),
                             '*' + number(original, 1) + '*', number(exact.seconds),
                             '*' + number(stochastic, 2) + '*'});
    };
    row("gas can", 0.9, 0.16);
    row("teapot", 3.4, 0.51);
    row("screwdriver", 25, 0.82);
    row("Eiffel tower", 143, 10);
    row("aspen", 885, 48);
    return made;
}

/// One model, one parameter, many values.
section study(setup& with, const char* model, const std::vector<column>& columns,
              const std::vector<std::pair<std::string, recipe>>& values, std::string title,
              std::string about) {
    experiment_table table(with, columns, false);
    std::vector<experiment> experiments;
    for (const auto& [name, how] : values) experiments.push_back({name, how, {}});
    table.add(model, std::move(experiments));
    section made = table.done(std::move(title), std::move(about));
    // The graphs have no numbers to print beside ours.
    for (std::size_t i = made.columns.size(); i-- > 0;) {
        if (made.columns[i] != "*published*") continue;
        made.columns.erase(made.columns.begin() + static_cast<std::ptrdiff_t>(i));
        for (auto& row : made.rows) row.erase(row.begin() + static_cast<std::ptrdiff_t>(i));
    }
    return made;
}

section raster_study(setup& with) {
    std::vector<std::pair<std::string, recipe>> values;
    for (const int raster : {12, 14, 16, 18, 20, 22, 24}) {
        const int orientations = 6 * raster * raster + 2;
        recipe how;
        how.raster = raster;
        values.emplace_back(
            "raster " + std::to_string(raster) + ", " + std::to_string(orientations) + " normals",
            how);
    }
    return study(
        with, "screwdriver",
        {column::planes, column::coverage, column::geometric, column::level, column::seconds},
        values, "Figure 5.2: raster of normals",
        "ε 5 %, 1.5 bins an ε, penalty 3, falloff, least squares. *Published*: about 11 "
        "planes throughout; coverage error falls, levels of refinement fall, time is that "
        "of the first density and rises with the normals; unstable below 16.");
}

section rho_study(setup& with) {
    std::vector<std::pair<std::string, recipe>> values;
    for (const double rate : {0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0, 4.0}) {
        recipe how;
        how.rho_rate = rate;
        values.emplace_back(number(rate, 2) + " bins an ε", how);
    }
    return study(
        with, "screwdriver",
        {column::planes, column::coverage, column::geometric, column::level, column::seconds},
        values, "Figure 5.3: bins of offsets",
        "ε 5 %, raster 18, penalty 3, falloff, least squares. *Published*: 11 planes and "
        "an even coverage error from 0.75 bins on, unstable below; time hardly changes.");
}

section penalty_study(setup& with) {
    std::vector<std::pair<std::string, recipe>> values;
    for (const double weight : {0.0, 1.0, 2.0, 3.0, 5.0, 7.0, 10.0}) {
        recipe how;
        how.epsilon = 0.04;
        how.penalty = weight;
        values.emplace_back("penalty " + number(weight, 0), how);
    }
    return study(with, "barrel", {column::planes, column::coverage, column::geometric}, values,
                 "Figure 5.5: penalty",
                 "ε 4 %, raster 18, 1.5 bins an ε, falloff, least squares. *Published*: many "
                 "planes and a large error without penalty, both least near 3; then more planes, "
                 "and still less error.");
}

// --- Trees of Fuhrmann et al. ----------------------------------------------------------------

section forest_trees(setup& with) {
    section made{.title = "Fuhrmann et al. 2005, figure 11: trees",
                 .about =
                     "*tree* is presets::tree, as their paper says, trunk and foliage apart; "
                     "*exact, refined* searches all faces together. Published seconds are of "
                     "all preprocessing on a Pentium 4 of 3.2 GHz, ours of the search.",
                 .columns = {"tree", "ε %", "ε of", "*faces*", "*planes*", "*seconds*",
                             "tree: planes", "seconds", "exact: planes", "seconds", "share"}};
    const auto row = [&](const char* name, const model_store::model& of, double epsilon,
                         const char* faces, const char* planes, const char* seconds) {
        view_settings none = with.views;
        none.texels = 16;
        for (int base = 1; base <= 2; ++base) {
            const cloud_made tree = search_tree(of.mesh, base * epsilon);
            recipe how{.how = method::exact_refined, .epsilon = base * epsilon};
            const cloud_made exact = make_cloud(of.mesh, how, none);
            std::fprintf(stderr, "  %s: %zu, %zu planes\n", of.name.c_str(), tree.planes,
                         exact.planes);
            const bool is_first = base == 1;
            made.rows.push_back({std::string(name) + " (" + of.name + ")", number(100 * epsilon, 1),
                                 is_first ? "radius" : "diameter", is_first ? faces : "",
                                 is_first ? planes : "", is_first ? seconds : "",
                                 std::to_string(tree.planes), number(tree.seconds),
                                 std::to_string(exact.planes), number(exact.seconds),
                                 number(exact.projected_area_share)});
        }
    };
    row("a", with.models.of("aspen"), 0.1, "*108,782*", "*12*", "*342*");
    row("b", with.models.tree(159'160), 0.12, "*159,160*", "*14*", "*403*");
    row("c", with.models.tree(20'547), 0.125, "*20,547*", "*13*", "*62*");
    row("d", with.models.tree(7'292), 0.065, "*7,292*", "*8*", "*25*");
    row("e", with.models.tree(169'781), 0.065, "*169,781*", "*21*", "*496*");
    return made;
}

// --- What users would pick instead -----------------------------------------------------------

std::vector<mesh_reducer> reducers() {
#if defined(BILLOW_HAS_REDUCE)
    return {{"simplify", [](const mesh& m, double share) { return reduce_mesh(m, share).mesh; }},
            {"simplifySloppy",
             [](const mesh& m, double share) { return reduce_mesh_sloppily(m, share).mesh; }}};
#else
    return {};
#endif
}

section baselines(setup& with) {
    section made{.title = "Against what users would pick instead",
                 .about = "",
                 .columns = {"model", "stand-in", "triangles", "kB", "coverage %", "missing %",
                             "extra %", "colour", "local colour", "ꟻLIP", "gap"}};
    made.about =
        "The cloud is that of the exact search, refined, 256 texels along the diameter, its "
        "triangles and bytes are what the others may have. Bytes: vertices, indices and textures "
        "uncompressed, without mips. Quads: as many texels as give the cloud's bytes. *simplify* "
        "and *simplifySloppy* are meshoptimizer's: at equal triangles with the original's "
        "textures, "
        "at equal bytes with textures halved to half of the bytes; where that is the whole "
        "original, "
        "it fits.";
    const auto rows = [&](const std::string& name, const mesh& original, double epsilon,
                          bool welds) {
        recipe how{.how = method::exact_refined,
                   .epsilon = epsilon,
                   .tangency = best_tangency,
                   .skip_area = 0.02,
                   .welds = welds};
        std::vector<baseline> all;
        all.push_back({"billboard cloud", make_cloud(original, how, with.views).mesh});
        baseline_options options{.triangles = all[0].mesh.face_count(),
                                 .bytes = stored_bytes_of(all[0].mesh),
                                 .reducers = reducers()};
        options.bake.draw.supersample = 2;
        for (baseline& b : make_baselines(original, options)) all.push_back(std::move(b));
        std::vector<const mesh*> meshes;
        for (const baseline& b : all) meshes.push_back(&b.mesh);
        const compare_options views{.views = with.views.views,
                                    .size_px = with.views.size_px,
                                    .supersample = with.views.supersample};
        const comparison found = compare(original, meshes, views);
        for (std::size_t i = 0; i < all.size(); ++i) {
            const errors_over_views& e = found.clouds[i].errors;
            const bool is_empty = all[i].mesh.face_count() == 0;  // has no colours
            made.rows.push_back(
                {name, all[i].name, std::to_string(all[i].mesh.face_count()),
                 number(1e-3 * static_cast<double>(stored_bytes_of(all[i].mesh)), 0),
                 number(100 * e.coverage.mean, 1), number(100 * e.missing.mean, 1),
                 number(100 * e.extra.mean, 1), number(is_empty ? unknown : e.color.mean),
                 number(is_empty ? unknown : e.local_color.mean), number(e.object_flip.mean, 3),
                 number(e.gap_intensity.mean)});
        }
        std::fprintf(stderr, "  %s: %zu stand-ins\n", name.c_str(), all.size());
    };
    const auto of = [&](const char* name, double epsilon, bool welds) {
        const model_store::model& m = with.models.of(name);
        rows(m.name + ", ε " + percent(epsilon, 0), m.mesh, epsilon, welds);
    };
    of("teapot", 0.05, true);
    of("windmill", 0.05, true);
    of("Eiffel tower", 0.05, false);
    const model_store::model& tree = with.models.tree(20'547);
    rows("tree, " + tree.name + ", ε 10 %", tree.mesh, 0.1, false);
    of("aspen", 0.1, false);
    of("aspen", 0.05, false);
    return made;
}

// --- All searches on all models --------------------------------------------------------------

constexpr const char* shares_and_errors =
    "Solids at ε 5 %, plants at 10 % of the radius. *classic* and *thesis* are the presets' "
    "searches, "
    "*exact* is exact_search without penalty, *refined* with refine_whole after it. *thesis* and "
    "*refined, 98 %* skip 2 % of the area, the others nothing; nothing is welded. *Share*: "
    "area-weighted mean |cos| between a face and its plane. ";

const std::vector<std::pair<const char*, recipe>>& all_searches() {
    static const std::vector<std::pair<const char*, recipe>> searches{
        {"thesis", {.skip_area = 0.02}},
        {"thesis, refined", {.how = method::density_refined, .skip_area = 0.02}},
        {"solid", {}},
        {"classic", {.how = method::classic}},
        {"exact", {.how = method::exact}},
        {"refined", {.how = method::exact_refined}},
        {"refined, 98 %", {.how = method::exact_refined, .skip_area = 0.02}},
        {"tangent", {.how = method::exact_refined, .tangency = 2}},
        {"tangent, 98 %", {.how = method::exact_refined, .tangency = 2, .skip_area = 0.02}},
    };
    return searches;
}

constexpr std::string_view of_one_model = "all:";
constexpr const char* at_equal_epsilon = "ε";
constexpr const char* at_equal_planes = "planes";

using table_row = std::vector<std::string>;

[[nodiscard]] bool is_row_of(const table_row& row, std::string_view table,
                             std::string_view search) {
    return row[0] == table && row[2] == search;
}

[[nodiscard]] const table_row* find_row(const std::vector<table_row>& rows, std::string_view table,
                                        std::string_view search) {
    const auto at = std::find_if(rows.begin(), rows.end(), [&](const table_row& row) {
        return is_row_of(row, table, search);
    });
    return at == rows.end() ? nullptr : &*at;
}

/// Whether all searches have been measured on a model.
[[nodiscard]] bool is_complete(const section& of_model) {
    return std::all_of(all_searches().begin(), all_searches().end(), [&](const auto& search) {
        return find_row(of_model.rows, at_equal_epsilon, search.first) != nullptr;
    });
}

/// All searches on one model: at equal epsilon, and at as many planes as the thesis has there. The
/// first cell of a row tells which of the two. Rows that are `known` are not measured again.
section one_model(setup& with, const std::string& id, std::vector<table_row> known) {
    struct planned {
        const char* table;
        const char* search;
        cloud_made cloud;
    };
    const model_store::model of = with.models.load(id);
    const bool has_both = of.mesh.face_count() <= with.most_faces;
    std::size_t planes_of_thesis = 0;
    if (const table_row* row = find_row(known, at_equal_epsilon, all_searches().front().first)) {
        planes_of_thesis = static_cast<std::size_t>(std::atol((*row)[3].c_str()));
    }
    std::vector<planned> made;
    for (const auto& [name, base] : all_searches()) {
        if (find_row(known, at_equal_epsilon, name) != nullptr) continue;
        recipe how = base;
        how.epsilon = of.is_tree ? 0.1 : 0.05;
        const cloud_made cloud = make_cloud(of.mesh, how, with.views);
        if (planes_of_thesis == 0) planes_of_thesis = cloud.planes;
        made.push_back({at_equal_epsilon, name, cloud});
        if (!has_both) continue;
        how.planes = planes_of_thesis;
        const bool is_right = cloud.planes == planes_of_thesis;
        made.push_back(
            {at_equal_planes, name, is_right ? cloud : make_cloud(of.mesh, how, with.views)});
    }
    std::vector<const mesh*> meshes;
    for (const planned& p : made) meshes.push_back(&p.cloud.mesh);
    const std::vector<picture_means> seen = look_at(of.mesh, meshes, with.views);
    for (std::size_t i = 0; i < made.size(); ++i) {
        const cloud_made& cloud = made[i].cloud;
        known.push_back({made[i].table, of.name, made[i].search, std::to_string(cloud.planes),
                         number(100 * cloud.epsilon, 1), number(cloud.projected_area_share),
                         number(100 * seen[i].coverage, 1), number(seen[i].color),
                         number(seen[i].local_color), number(cloud.seconds)});
        std::fprintf(stderr, "  %s, %s at equal %s: %zu planes\n", of.name.c_str(), made[i].search,
                     made[i].table, cloud.planes);
    }
    return {.id = std::string(of_one_model) + id, .rows = std::move(known)};
}

/// The rows of all models that are known, for one of the tables, and their means below.
section all_models(const setup& with, const result_file& results, const char* table) {
    section made{.columns = {"model", "search", "planes", "ε %", "share", "coverage %", "colour",
                             "local colour", "seconds"}};
    if (table == std::string_view(at_equal_epsilon)) {
        made.id = "all_epsilon";
        made.title = "All searches at equal ε";
        made.about = std::string(shares_and_errors) + "Means of planes are geometric.";
    } else {
        made.id = "all_planes";
        made.title = "All searches at equal planes";
        made.about =
            "As above, with the ε at which a search needs about as many planes as *thesis* "
            "at equal ε: the nearest of six trials, whose seconds are summed up. Models of "
            "more than " +
            std::to_string(with.most_faces) + " faces are left out.";
    }
    struct sums {
        std::array<double, 9> values{};  // by column
        int models = 0;
    };
    constexpr std::array<const char*, 2> kinds{"solids", "plants"};
    std::array<std::map<std::string, sums>, 2> of_kind;
    for (const std::string& id : with.models.all()) {
        const section* model = results.find(std::string(of_one_model) + id);
        if (model == nullptr) continue;
        made.where = model->where;
        made.seconds += model->seconds;
        const bool is_plant =
            id.starts_with("trees/") || id.find("tree") != id.npos || id == "leaf soup";
        for (const auto& [name, unused] : all_searches()) {
            const table_row* row = find_row(model->rows, table, name);
            if (row == nullptr) continue;
            made.rows.emplace_back(row->begin() + 1, row->end());
            sums& sum = of_kind[is_plant ? 1 : 0][name];
            ++sum.models;
            for (std::size_t i = 2; i < made.columns.size(); ++i) {
                const double value = std::strtod((*row)[i + 1].c_str(), nullptr);
                sum.values[i] += i == 2 ? std::log(std::max(1.0, value)) : value;
            }
        }
    }
    for (std::size_t kind = 0; kind < kinds.size(); ++kind) {
        for (const auto& [name, unused] : all_searches()) {
            const auto at = of_kind[kind].find(name);
            if (at == of_kind[kind].end()) continue;
            const sums& sum = at->second;
            const auto mean = [&](std::size_t i) { return sum.values[i] / sum.models; };
            made.rows.push_back(
                {"**mean of " + std::to_string(sum.models) + ' ' + kinds[kind] + "**", name,
                 number(std::exp(mean(2)), 1), "", number(mean(4)), number(mean(5), 1),
                 number(mean(6)), number(mean(7)), number(mean(8))});
        }
    }
    return made;
}

// --- The program -----------------------------------------------------------------------------

struct job {
    const char* id;
    std::function<section(setup&)> run;
};

const std::vector<job>& jobs() {
    static const std::vector<job> all{
        {"falloff", falloff},
        {"fitting", fitting},
        {"no_refinement", no_refinement},
        {"skipping", skipping},
        {"welding", welding},
        {"windmill", windmill},
        {"searches", searches_compared},
        {"times", search_times},
        {"raster", raster_study},
        {"rho", rho_study},
        {"penalty", penalty_study},
        {"fuhrmann", forest_trees},
        {"baselines", baselines},
    };
    return all;
}

constexpr const char* usage =
    "billow_thesis [--models DIR] [--page results.md] [--json results.json] [--notes notes.md]\n"
    "              [--only ID,ID…] [--missing yes] [--views 42] [--size 256] [--most-faces 70000]\n"
    "Measures the sections of results.md. Those not named by --only are taken from the JSON file\n"
    "as they are; --only none measures nothing and writes the page anew; --missing yes measures\n"
    "what the file does not have. Sections:\n ";

}  // namespace

int main(int argc, char** argv) {
    std::map<std::string, std::string> options{{"--models", ""},
                                               {"--page", "docs/results.md"},
                                               {"--json", "docs/results.json"},
                                               {"--notes", "benchmarks/thesis/notes.md"},
                                               {"--only", ""},
                                               {"--missing", "no"},
                                               {"--views", "42"},
                                               {"--size", "256"},
                                               {"--most-faces", "70000"}};
    for (int i = 1; i < argc; i += 2) {
        const auto at = options.find(argv[i]);
        if (at == options.end() || i + 1 == argc) {
            std::fputs(usage, stderr);
            for (const job& j : jobs()) std::fprintf(stderr, " %s", j.id);
            std::fputs(" all, or all:<model>\n", stderr);
            return 1;
        }
        at->second = argv[i + 1];
    }
    setup with{model_store(options["--models"])};
    with.views.views = std::max(1, std::atoi(options["--views"].c_str()));
    with.views.size_px = std::max(16, std::atoi(options["--size"].c_str()));
    with.views.texels = with.views.size_px;
    with.most_faces = static_cast<std::size_t>(std::atol(options["--most-faces"].c_str()));
    const std::string only = ',' + options["--only"] + ',';
    const auto is_wanted = [&](const std::string& id) {
        return only == ",," || only.find(',' + id + ',') != only.npos;
    };

    result_file results(options["--json"]);
    const bool only_missing = options["--missing"] != "no";
    const auto measure = [&](const std::string& id, const auto& run) {
        std::fprintf(stderr, "%s\n", id.c_str());
        const auto start = std::chrono::steady_clock::now();
        section made = run();
        const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
        made.id = id;
        made.seconds = std::round(took.count());
        made.where = this_machine();
        results.put(std::move(made));
        results.save();  // so that a run that is stopped is not lost
    };
    for (const job& j : jobs()) {
        if (!is_wanted(j.id) || (only_missing && results.find(j.id) != nullptr)) continue;
        measure(j.id, [&] { return j.run(with); });
    }
    for (const std::string& model : with.models.all()) {
        const std::string id = std::string(of_one_model) + model;
        if (!is_wanted("all") && !is_wanted(id)) continue;
        const section* known = only_missing ? results.find(id) : nullptr;
        if (known != nullptr && is_complete(*known)) continue;
        std::vector<table_row> rows = known != nullptr ? known->rows : std::vector<table_row>{};
        measure(id, [&] { return one_model(with, model, std::move(rows)); });
    }
    results.put(all_models(with, results, at_equal_epsilon));
    results.put(all_models(with, results, at_equal_planes));

    std::vector<std::string> order;
    for (const job& j : jobs()) order.emplace_back(j.id);
    order.insert(order.end(), {"all_epsilon", "all_planes"});
    write_page(options["--page"], results, order, options["--notes"]);
    return 0;
}
