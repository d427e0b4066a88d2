#include "models.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <numbers>

#include <billow/io/mesh_file.hpp>
#include <billow/plants/species.hpp>
#include <billow/shapes/box.hpp>
#include <billow/shapes/leaf_soup.hpp>
#include <billow/shapes/sphere.hpp>
#include <billow/shapes/teapot.hpp>

namespace thesis {

namespace {

using namespace billow;

struct stand_in {
    const char* published;
    const char* file;       ///< within the folder of models; none: always generated
    const char* generated;  ///< a name that generate() knows
};

constexpr std::array<stand_in, 9> stand_ins{{
    {"teapot", "solid/teapot_1k.glb", "teapot"},
    {"screwdriver", "solid/waterbottle.glb", "spindle"},
    {"gas can", "solid/avocado.glb", "small teapot"},
    {"barrel", "solid/barrel.glb", "egg"},
    {"hut", "solid/house.glb", "turned box"},
    {"box", "", "turned box"},
    {"windmill", "solid/windmill.glb", "bare tree"},
    {"Eiffel tower", "solid/ferris_wheel.glb", "tree of 5,000"},
    {"aspen", "trees/aspen_113k.glb", "tree of 113,016"},
}};

constexpr std::array<const char*, 7> generated_models{
    "teapot", "spindle", "egg", "turned box", "tree of 5,000", "tree of 20,547", "leaf soup"};

mesh stretched(mesh m, const vec3& by) {
    for (vec3& p : m.positions) p *= by;
    m.normals.clear();
    return m;
}

/// So that no side lies in a sample of the plane space.
mesh turned(mesh m) {
    const glm::mat3 turn(
        glm::normalize(vec3(0.86f, 0.31f, -0.4f)), glm::normalize(vec3(-0.31f, 0.95f, 0.07f)),
        glm::normalize(glm::cross(vec3(0.86f, 0.31f, -0.4f), vec3(-0.31f, 0.95f, 0.07f))));
    for (vec3& p : m.positions) p = turn * p;
    m.normals.clear();
    return m;
}

std::size_t number_in(const std::string& name) {
    std::size_t number = 0;
    for (const char c : name) {
        if (c >= '0' && c <= '9') number = 10 * number + static_cast<std::size_t>(c - '0');
    }
    return number;
}

mesh generate(const std::string& name) {
    if (name == "teapot") return teapot(4);
    if (name == "small teapot") return teapot(2);
    if (name == "spindle") return stretched(icosphere(4), {1, 6, 1});
    if (name == "egg") return stretched(icosphere(3), {1, 1.4f, 1});
    if (name == "turned box") return turned(box({1, 1.5f, 2}, 3));
    if (name == "leaf soup") return leaf_soup(20'000);
    if (name == "bare tree") return *tree_of_about(2'653, 3);
    return *tree_of_about(number_in(name));
}

bool is_generated_tree(const std::string& name) {
    return name.find("tree") != std::string::npos || name == "leaf soup";
}

mesh read(const std::filesystem::path& file) {
    expected<loaded_mesh> loaded = read_mesh(file);
    if (!loaded) {
        std::fprintf(stderr, "%s\n", loaded.error().message.c_str());
        std::exit(2);
    }
    return std::move(loaded->mesh);
}

std::string with_faces(const std::string& name, const mesh& m) {
    const std::string count = std::to_string(m.face_count());
    std::string text = name + ", ";
    for (std::size_t i = 0; i < count.size(); ++i) {
        if (i > 0 && (count.size() - i) % 3 == 0) text += ',';
        text += count[i];
    }
    return text;
}

}  // namespace

const model_store::model& model_store::of(const std::string& published) {
    if (const auto at = known_.find(published); at != known_.end()) return at->second;
    const auto* found = std::find_if(stand_ins.begin(), stand_ins.end(),
                                     [&](const stand_in& s) { return s.published == published; });
    model made;
    const std::filesystem::path file = folder_ / found->file;
    if (!folder_.empty() && *found->file != '\0' && std::filesystem::exists(file)) {
        made.mesh = read(file);
        made.name = with_faces(file.stem().string(), made.mesh);
        made.is_tree = file.parent_path().filename() == "trees";
    } else {
        made.mesh = generate(found->generated);
        made.name = found->generated;
        if (made.name.find("tree of") == std::string::npos) {
            made.name = with_faces(made.name, made.mesh);
        }
        made.is_tree = is_generated_tree(found->generated);
    }
    return known_[published] = std::move(made);
}

const model_store::model& model_store::tree(std::size_t faces) {
    const std::string name = "tree " + std::to_string(faces);
    if (const auto at = known_.find(name); at != known_.end()) return at->second;
    model made;
    made.mesh = *tree_of_about(faces);
    made.name = with_faces("generated", made.mesh);
    made.is_tree = true;
    return known_[name] = std::move(made);
}

std::vector<std::string> model_store::all() const {
    std::vector<std::string> found;
    for (const char* folder : {"solid", "trees"}) {
        if (folder_.empty() || !std::filesystem::is_directory(folder_ / folder)) continue;
        std::vector<std::string> files;
        for (const auto& file : std::filesystem::directory_iterator(folder_ / folder)) {
            if (file.path().extension() != ".glb") continue;
            files.push_back((std::filesystem::path(folder) / file.path().filename()).string());
        }
        std::sort(files.begin(), files.end());
        found.insert(found.end(), files.begin(), files.end());
    }
    if (found.empty()) found.assign(generated_models.begin(), generated_models.end());
    return found;
}

model_store::model model_store::load(const std::string& id) const {
    if (!id.ends_with(".glb")) {
        mesh made = generate(id);
        return {id, std::move(made), is_generated_tree(id)};
    }
    const std::filesystem::path file = folder_ / id;
    mesh made = read(file);
    std::string name = with_faces(file.stem().string(), made);
    return {std::move(name), std::move(made), id.starts_with("trees")};
}

}  // namespace thesis
