// The smallest use of billow: billow_minimal INPUT OUTPUT.glb
//
// A program needs nothing but these two headers. The bodies of the libraries that read and write
// files go into one .cpp of the program, which here is this one.
#define BILLOW_IO_IMPLEMENTATION
#include <cstdio>

#include <billow/io.hpp>
// io.hpp comes first where the bodies are asked for.
#include <billow/billow.hpp>

static billow::expected<std::size_t> convert(const char* input, const char* output) {
    auto loaded = billow::read_mesh(input);  // .glb, .gltf or .obj
    if (!loaded) return loaded.error();
    auto built = billow::build_cloud(loaded->mesh, {.epsilon = billow::tolerance::of_radius(0.1)});
    if (!built) return built.error();
    auto written = billow::write_glb(output, built->to_mesh());
    if (!written) return written.error();
    return built->cloud.plane_count();
}

int main(int argc, char** argv) {
    if (argc != 3) return std::fputs("usage: billow_minimal INPUT OUTPUT.glb\n", stderr), 2;
    auto planes = convert(argv[1], argv[2]);
    if (!planes) return std::fprintf(stderr, "%s\n", planes.error().message.c_str()), 1;
    std::printf("%zu planes\n", *planes);
}
