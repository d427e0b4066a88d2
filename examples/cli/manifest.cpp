// What verbs share that write several files and a manifest of them.

#include "manifest.hpp"

#include <system_error>

#include <billow/io/file.hpp>

namespace cli {

using namespace billow;

expected<done> write_together(const std::vector<output_file>& files) {
    std::vector<std::filesystem::path> aside;
    const auto give_up = [&](const error& why) {
        std::error_code ignored;
        for (const auto& name : aside) std::filesystem::remove(name, ignored);
        return why;
    };
    for (const output_file& file : files) {
        aside.push_back(billow::detail::name_aside(file.name));
        if (const auto written = write_file(aside.back(), file.bytes); !written) {
            return give_up(written.error());
        }
    }
    for (std::size_t i = 0; i < files.size(); ++i) {
        std::error_code why;
        std::filesystem::rename(aside[i], files[i].name, why);
        if (why) {
            return give_up(billow::detail::file_error(error_code::unwritable, files[i].name,
                                                      "cannot be replaced: " + why.message()));
        }
    }
    return done{};
}

nlohmann::ordered_json sphere_json(const bounding_sphere& sphere) {
    nlohmann::ordered_json out;
    out["centre"] = {sphere.centre.x, sphere.centre.y, sphere.centre.z};
    out["radius"] = sphere.radius;
    return out;
}

std::size_t texture_bytes(const mesh& cloud) {
    std::size_t bytes = 0;
    for (const image& picture : cloud.images) bytes += picture.bytes.size();
    return bytes;
}

}  // namespace cli
