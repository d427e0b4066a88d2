// The pipeline that the tool puts together when it runs finds what the same pipeline, put together
// by the compiler, finds.

#include <algorithm>
#include <cstdio>

#include <billow/plants/species.hpp>
#include <billow/shapes/leaf_soup.hpp>
#include <billow/shapes/teapot.hpp>

#include "recipe.hpp"

using namespace billow;

namespace {

bool is_equal(const moved_face& a, const moved_face& b) {
    return a.face == b.face && a.corners == b.corners;
}

/// The search alone: textures follow from it.
template <class Pipeline>
greedy_result found_by(const face_table& faces, std::size_t face_count,
                       const build_options& options, const Pipeline& method) {
    greedy_options how = options.search;
    how.epsilon = options.epsilon.in(faces.bounds);
    return greedy_search(faces, face_count, how, method);
}

template <class Pipeline>
int differences(const char* name, const mesh& m, const preset<Pipeline>& from) {
    const face_table faces = *make_face_table(m);
    const cli::recipe how = cli::recipe_of(from);
    const greedy_result compiled = found_by(faces, m.face_count(), from.options, from.method);
    const greedy_result chosen = found_by(faces, m.face_count(), how.options, how.method);
    const bool is_same = compiled.cloud.planes == chosen.cloud.planes &&
                         compiled.cloud.plane_of_face == chosen.cloud.plane_of_face &&
                         std::ranges::equal(compiled.moved, chosen.moved, is_equal);
    std::printf("%-14s %zu planes, %s\n", name, chosen.cloud.plane_count(),
                is_same ? "the same" : "OTHERS");
    return !is_same || compiled.cloud.planes.empty() ? 1 : 0;
}

int differences_of_all(const mesh& m) {
    return differences("classic", m, presets::classic()) +
           differences("thesis", m, presets::thesis()) + differences("solid", m, presets::solid()) +
           differences("tree: foliage", m, presets::tree().foliage) +
           differences("tree: trunk", m, presets::tree().trunk);
}

}  // namespace

int main() {
    int found = 0;
    for (const mesh& m : {teapot(3), leaf_soup(400, {.edge = 0.2f}), *tree_of_about(800)}) {
        found += differences_of_all(m);
    }
    return found == 0 ? 0 : 1;
}
