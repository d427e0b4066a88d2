// A folder of its own for each test, and glTF files made by hand.
#pragma once

#include <atomic>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include <billow/io/file.hpp>
#include <billow/io/gltf.hpp>

namespace scratch {

using json = nlohmann::json;

/// Gone with all that is in it at the end of the test.
class folder {
public:
    folder() {
        static std::atomic<int> next{0};
        const auto base = std::filesystem::temp_directory_path();
        do {
            path_ = base / ("billow_test_" + std::to_string(next++));
        } while (!std::filesystem::create_directory(path_));
    }
    folder(const folder&) = delete;
    folder& operator=(const folder&) = delete;
    ~folder() {
        std::error_code ignored;
        std::filesystem::remove_all(path_, ignored);
    }

    [[nodiscard]] std::filesystem::path operator/(std::string_view name) const {
        return path_ / name;
    }
    std::filesystem::path put(std::string_view name, std::string_view text) const {
        const auto* bytes = reinterpret_cast<const std::uint8_t*>(text.data());
        REQUIRE(billow::write_file(path_ / name, {bytes, text.size()}));
        return path_ / name;
    }
    [[nodiscard]] std::size_t file_count() const {
        std::size_t count = 0;
        for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(path_)) {
            ++count;
        }
        return count;
    }

private:
    std::filesystem::path path_;
};

inline std::string base64(const std::vector<std::uint8_t>& bytes) {
    constexpr std::string_view digits =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        std::uint32_t bits = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            bits = bits << 8 | (i + k < bytes.size() ? bytes[i + k] : 0u);
        }
        for (std::size_t k = 0; k < 4; ++k) {
            text += i + k <= bytes.size() ? digits[bits >> (18 - 6 * k) & 63] : '=';
        }
    }
    return text;
}

/// A glTF file in the making: one buffer, and a scene of one node with one mesh unless changed.
struct gltf {
    json root{{"asset", {{"version", "2.0"}}},
              {"scene", 0},
              {"scenes", {{{"nodes", {0}}}}},
              {"nodes", {{{"mesh", 0}}}},
              {"meshes", {{{"primitives", json::array()}}}}};
    std::vector<std::uint8_t> binary{};

    int add(const char* list, json item) {
        root[list].push_back(std::move(item));
        return static_cast<int>(root[list].size()) - 1;
    }
    template <class T>
    int view(const std::vector<T>& values, int stride = 0) {
        binary.resize((binary.size() + 3) / 4 * 4);
        const std::size_t offset = binary.size();
        binary.resize(offset + values.size() * sizeof(T));
        std::memcpy(binary.data() + offset, values.data(), values.size() * sizeof(T));
        json item{{"buffer", 0}, {"byteOffset", offset}, {"byteLength", values.size() * sizeof(T)}};
        if (stride != 0) item["byteStride"] = stride;
        return add("bufferViews", item);
    }
    int accessor(int view, int component, const char* type, std::size_t count) {
        return add(
            "accessors",
            {{"bufferView", view}, {"componentType", component}, {"type", type}, {"count", count}});
    }
    int floats(const std::vector<float>& values, const char* type, std::size_t width) {
        return accessor(view(values), 5126, type, values.size() / width);
    }
    int indices(const std::vector<std::uint16_t>& values) {
        return accessor(view(values), 5123, "SCALAR", values.size());
    }
    json& primitive(json attributes) {
        json& list = root["meshes"][0]["primitives"];
        list.push_back({{"attributes", std::move(attributes)}});
        return list.back();
    }
    /// The right angle at the origin with legs along x and y.
    int triangle() { return floats({0, 0, 0, 1, 0, 0, 0, 1, 0}, "VEC3", 3); }

    [[nodiscard]] std::string text() const {
        json whole = root;
        if (!binary.empty() && !whole.contains("buffers")) {
            whole["buffers"] = {
                {{"byteLength", binary.size()},
                 {"uri", "data:application/octet-stream;base64," + base64(binary)}}};
        }
        return whole.dump();
    }
    [[nodiscard]] billow::expected<billow::loaded_mesh> read(
        const billow::read_options& options = {}) const {
        const folder at;
        return billow::read_gltf(at.put("made.gltf", text()), options);
    }
};

/// A GLB around JSON text and a binary chunk.
inline std::string glb(std::string json_text, std::string binary = {}) {
    const auto word = [](std::size_t value) {
        std::string bytes;
        for (int i = 0; i < 4; ++i) bytes += static_cast<char>(value >> 8 * i & 0xff);
        return bytes;
    };
    json_text.resize((json_text.size() + 3) / 4 * 4, ' ');
    binary.resize((binary.size() + 3) / 4 * 4, '\0');
    std::string chunks = word(json_text.size()) + "JSON" + json_text;
    if (!binary.empty()) chunks += word(binary.size()) + std::string("BIN\0", 4) + binary;
    return "glTF" + word(2) + word(12 + chunks.size()) + chunks;
}

/// Whether it failed so, in one line that names the file.
template <class T>
bool failed(const billow::expected<T>& result, billow::error_code code, std::string_view words = {},
            std::string_view file = "made.gltf") {
    if (result) return false;
    const std::string& message = result.error().message;
    CAPTURE(message);
    CHECK(message.find('\n') == std::string::npos);
    CHECK(message.find(file) != std::string::npos);
    CHECK(message.find(words) != std::string::npos);
    CHECK(result.error().code == code);
    return true;
}

}  // namespace scratch
