// What a reader delivers: the mesh, and what it left out on the way.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include <billow/mesh/mesh.hpp>

namespace billow::inline BILLOW_ABI {

/// Limits of a reader. A file of a few bytes may ask for billions of faces by its instances.
struct read_options {
    std::size_t max_faces = std::size_t{1} << 27;  ///< of the whole mesh, instances unfolded
};

/// A mesh as it came from a file. It passes validate().
struct loaded_mesh {
    billow::mesh mesh{};
    std::size_t primitives = 0;          ///< triangle primitives or groups of faces in the file
    std::size_t instances = 0;           ///< times that one was placed in the scene
    std::size_t skipped_primitives = 0;  ///< points and lines, or without positions
    std::vector<std::string> notes{};    ///< one line each: what was ignored or repaired

    /// Adds a note once.
    void note(std::string text) {
        if (std::find(notes.begin(), notes.end(), text) == notes.end()) {
            notes.push_back(std::move(text));
        }
    }
};

}  // namespace billow::inline BILLOW_ABI
