// The demo: billboard clouds of the Utah teapot and of a leafy tree, with pictures to compare.
//
//     billow_demo FOLDER
#include <array>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <string>
#include <string_view>

#include <billow/billow.hpp>
#include <billow/io.hpp>

namespace {

using billow::dvec3;
using billow::expected;

/// What is made of one model.
struct exhibit {
    std::string name{};    ///< of its files
    double epsilon = 0.1;  ///< share of the radius
    dvec3 seen_from{};     ///< direction from its centre
    int height_px = 768;   ///< of its picture, whose scale is the same for all
};

struct row {
    std::string name{};
    std::size_t faces = 0;
    std::size_t planes = 0;
    std::size_t triangles = 0;
    double epsilon = 0;             ///< share of the radius
    double error_over_epsilon = 0;  ///< of the farthest vertex
    double seconds = 0;
};

/// A line of ten dots for each stage.
void show_progress(std::string_view stage, double share) {
    static int shown = 0;
    const int tenths = static_cast<int>(share * 10);
    if (tenths < shown) shown = 0;  // the next stage
    for (; shown < tenths; ++shown) std::fputc('.', stderr);
    if (shown == 10) std::fprintf(stderr, " %.*s\n", static_cast<int>(stage.size()), stage.data());
}

/// Original on the left, cloud on the right.
billow::image comparison(const billow::mesh& original, const billow::mesh& cloud,
                         const billow::bounding_sphere& bounds, const exhibit& what) {
    billow::camera view = billow::view_of(bounds, what.seen_from, 768, 768);
    view.height *= what.height_px / 768.0;  // cuts off what stays empty
    view.width_px = 680;
    view.height_px = what.height_px;
    return billow::side_by_side(billow::draw_picture(original, view),
                                billow::draw_picture(cloud, view));
}

expected<row> make(const exhibit& what, const billow::mesh& original,
                   const std::filesystem::path& folder) {
    billow::build_options options;
    options.epsilon = billow::tolerance::of_radius(what.epsilon);
    const auto start = std::chrono::steady_clock::now();
    const auto built = billow::build_cloud(original, options, billow::pipeline{}, show_progress);
    if (!built) return built.error();
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
    const billow::mesh cloud = built->to_mesh();

    const auto file = [&](const char* ending) { return folder / (what.name + ending); };
    for (const auto& written :
         {billow::write_glb(file(".glb"), original), billow::write_glb(file("_cloud.glb"), cloud),
          billow::write_png(file("_atlas.png"), built->baked.atlases.front().base_color),
          billow::write_png(file(".png"),
                            comparison(original, cloud, built->cloud.bounds, what))}) {
        if (!written) return written.error();
    }
    return row{
        what.name,          original.face_count(), built->cloud.plane_count(),
        cloud.face_count(), what.epsilon,          built->errors.max_error / built->cloud.epsilon,
        took.count()};
}

expected<std::array<row, 2>> make_all(const std::filesystem::path& folder) {
    const auto teapot =
        make({.name = "teapot", .epsilon = 0.03, .seen_from = {0.6, 0.45, 1}, .height_px = 448},
             billow::teapot(10), folder);
    if (!teapot) return teapot.error();
    const auto grown = billow::tree_of_about(20000, 3);
    if (!grown) return grown.error();
    const auto tree =
        make({.name = "tree", .epsilon = 0.06, .seen_from = {1.5, 0.25, -1}}, *grown, folder);
    if (!tree) return tree.error();
    return std::array{*teapot, *tree};
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 2) {
        std::fputs("usage: billow_demo FOLDER\n", stderr);
        return 2;
    }
    const std::filesystem::path folder = argv[1];
    std::error_code ignored;  // writing tells what is wrong with the folder
    std::filesystem::create_directories(folder, ignored);
    const auto rows = make_all(folder);
    if (!rows) {
        std::fprintf(stderr, "billow_demo: %s\n", rows.error().message.c_str());
        return 1;
    }
    std::puts("model     faces  planes  triangles  epsilon  error/epsilon  seconds");
    for (const row& r : *rows) {
        std::printf("%-7s  %6zu  %6zu  %9zu  %6.1f%%  %13.3f  %7.2f\n", r.name.c_str(), r.faces,
                    r.planes, r.triangles, r.epsilon * 100, r.error_over_epsilon, r.seconds);
    }
    return 0;
}
