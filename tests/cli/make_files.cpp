// Writes the files that the tests of the tool read: small meshes, and files that are broken.

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>

#include <billow/io.hpp>
#include <billow/plants/species.hpp>
#include <billow/shapes/box.hpp>
#include <billow/shapes/leaf_soup.hpp>
#include <billow/shapes/teapot.hpp>

using namespace billow;

namespace {

void write_text(const std::filesystem::path& file, const std::string& text) {
    std::ofstream(file, std::ios::binary) << text;
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 2) return 2;
    const std::filesystem::path folder = argv[1];
    std::filesystem::create_directories(folder);

    bool is_written = true;
    const auto put = [&](const char* name, const mesh& m) {
        is_written &= write_glb(folder / name, m).has_value();
    };
    put("cube.glb", textured_cube());
    put("teapot.glb", teapot(3));
    put("leaves.glb", leaf_soup(2000, {.edge = 0.1f}));
    put("tree.glb", *tree_of_about(1500, 1));
    put("empty.glb", mesh{});
    mesh one;
    one.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    one.triangles = {{0, 1, 2}};
    put("one face.glb", one);
    one.positions = {{1, 1, 1}, {1, 1, 1}, {1, 1, 1}};
    put("degenerate.glb", one);

    write_text(folder / "nothing.glb", "");
    write_text(folder / "words.glb", "this is no mesh");
    write_text(folder / "words.xyz", "this is no mesh");
    write_text(folder / "nan.obj", "v 0 0 0\nv 1 0 0\nv nan 1 0\nf 1 2 3\n");
    write_text(folder / "square.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n");
    write_text(folder / "draco.gltf",
               R"({"asset":{"version":"2.0"},"extensionsRequired":["KHR_draco_mesh_compression"],)"
               R"("extensionsUsed":["KHR_draco_mesh_compression"]})");
    write_text(folder / "cycle.gltf", R"({"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],)"
                                      R"("nodes":[{"children":[1]},{"children":[0]}]})");
    write_text(
        folder / "huge.gltf",
        R"({"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],)"
        R"("meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"buffers":[{"byteLength":12,)"
        R"("uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAA"}],)"
        R"("bufferViews":[{"buffer":0,"byteLength":12}],"accessors":[{"bufferView":0,)"
        R"("componentType":5126,"count":4000000000,"type":"VEC3"}]})");
    const auto whole = read_file(folder / "cube.glb");
    if (!whole) return 1;
    write_text(folder / "truncated.glb",
               std::string(whole->begin(),
                           whole->begin() + static_cast<std::ptrdiff_t>(whole->size() / 2)));
    write_text(folder / "options.toml", "[build]\nepsilon = \"20%\"\nmax-planes = 3\n");
    write_text(folder / "planes.toml",
               "[build]\npreset = \"classic\"\nfalloff = \"on\"\nhorizontal-penalty = \"30%\"\n"
               "weld = \"first\"\ncompact = true\nfoliage-materials = [\"leaf*\"]\n"
               "trunk-epsilon = \"2%\"\n");
    return is_written ? 0 : 1;
}
