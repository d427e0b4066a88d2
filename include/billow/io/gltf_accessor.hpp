// Accessors of glTF: typed, strided, normalised and sparse columns, read into plain ones.
#pragma once

#include <cstring>
#include <initializer_list>
#include <limits>

#include <billow/io/gltf_document.hpp>

namespace billow::inline BILLOW_ABI::detail {

/// The values of an accessor, `width` of them an element.
template <class T>
struct gltf_column {
    std::vector<T> values{};
    std::size_t width = 1;

    [[nodiscard]] std::size_t size() const noexcept { return values.size() / width; }
    [[nodiscard]] const T* operator[](std::size_t i) const noexcept {
        return values.data() + i * width;
    }
};

/// Bytes of a component; 0 for a type that accessors cannot have.
[[nodiscard]] inline std::size_t component_size(int type) {
    switch (type) {
        case TINYGLTF_COMPONENT_TYPE_BYTE:
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
            return 1;
        case TINYGLTF_COMPONENT_TYPE_SHORT:
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
            return 2;
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
        case TINYGLTF_COMPONENT_TYPE_FLOAT:
            return 4;
        default:
            return 0;
    }
}

/// Reads one component, little endian, at `from`.
template <class T>
[[nodiscard]] T read_component(const std::uint8_t* from, int type, bool is_normalized) {
    const auto as = [&]<class Stored>(Stored) {
        Stored stored;
        std::memcpy(&stored, from, sizeof stored);
        if constexpr (std::is_floating_point_v<T> && std::is_integral_v<Stored>) {
            if (is_normalized) {
                return std::max(
                    static_cast<T>(stored) / static_cast<T>(std::numeric_limits<Stored>::max()),
                    T(-1));
            }
        }
        return static_cast<T>(stored);
    };
    switch (type) {
        case TINYGLTF_COMPONENT_TYPE_BYTE:
            return as(std::int8_t{});
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
            return as(std::uint8_t{});
        case TINYGLTF_COMPONENT_TYPE_SHORT:
            return as(std::int16_t{});
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
            return as(std::uint16_t{});
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
            return as(std::uint32_t{});
        default:
            if constexpr (std::is_floating_point_v<T>) return as(float{});
            return T{};  // callers refuse floats where integers are due
    }
}

/// Whether `count` elements of `size` bytes, `stride` apart from `offset` on, end within `limit`.
[[nodiscard]] constexpr bool fits(std::uint64_t offset, std::uint64_t count, std::uint64_t stride,
                                  std::uint64_t size, std::uint64_t limit) noexcept {
    if (count == 0) return true;
    if (offset > limit || size > limit - offset) return false;
    return stride == 0 || count - 1 <= (limit - offset - size) / stride;
}

/// The column of an accessor.
///
/// Shape   as many values an element as the accessor has, one of `widths`.
/// Fails   out_of_range: a missing id, or bytes beyond the view; malformed: another type than asked
///         for; and what view_bytes may fail with. Nothing large is allocated before all is checked.
template <class T>
[[nodiscard]] expected<gltf_column<T>> read_accessor(gltf_document& document, int accessor_id,
                                                     std::initializer_list<std::size_t> widths) {
    const std::string what = "accessor " + std::to_string(accessor_id);
    const auto fail = [&](error_code code, const std::string& fault) {
        return document.fail(code, what + " " + fault);
    };
    const tinygltf::Accessor* found = row(document.model.accessors, accessor_id);
    if (found == nullptr) return fail(error_code::out_of_range, "does not exist");
    const tinygltf::Accessor& accessor = *found;

    const std::size_t component = component_size(accessor.componentType);
    const bool is_float = accessor.componentType == TINYGLTF_COMPONENT_TYPE_FLOAT;
    if (component == 0 || (std::is_integral_v<T> && is_float)) {
        return fail(error_code::malformed, "has a component type that its use does not allow");
    }
    std::size_t width = 0;
    switch (accessor.type) {
        case TINYGLTF_TYPE_SCALAR:
            width = 1;
            break;
        case TINYGLTF_TYPE_VEC2:
            width = 2;
            break;
        case TINYGLTF_TYPE_VEC3:
            width = 3;
            break;
        case TINYGLTF_TYPE_VEC4:
            width = 4;
            break;
        default:
            break;
    }
    if (std::find(widths.begin(), widths.end(), width) == widths.end()) {
        return fail(error_code::malformed, "has a type that its use does not allow");
    }

    const std::size_t element = component * width;
    const std::size_t count = accessor.count;
    gltf_column<T> column{{}, width};
    const auto read_element = [&](std::size_t i, const std::uint8_t* from) {
        for (std::size_t c = 0; c < width; ++c) {
            column.values[i * width + c] = read_component<T>(
                from + c * component, accessor.componentType, accessor.normalized);
        }
    };

    if (accessor.bufferView >= 0) {
        auto bytes = view_bytes(document, accessor.bufferView);
        if (!bytes) return bytes.error();
        const auto& view =
            document.model.bufferViews[static_cast<std::size_t>(accessor.bufferView)];
        const std::size_t stride = view.byteStride == 0 ? element : view.byteStride;
        if (!fits(accessor.byteOffset, count, stride, element, bytes->size())) {
            return fail(error_code::out_of_range, "of " + std::to_string(count) +
                                                      " elements reaches beyond buffer view " +
                                                      std::to_string(accessor.bufferView));
        }
        column.values.resize(count * width);
        for (std::size_t i = 0; i < count; ++i) {
            read_element(i, bytes->data() + accessor.byteOffset + i * stride);
        }
    } else {
        constexpr std::size_t most_zeros = std::size_t{1} << 24;  // no byte of the file backs them
        if (count > most_zeros) {
            return fail(error_code::too_large,
                        "of " + std::to_string(count) + " elements has no buffer view");
        }
        column.values.resize(count * width);
    }

    if (accessor.sparse.isSparse) {
        const auto& sparse = accessor.sparse;
        const std::size_t index_size = component_size(sparse.indices.componentType);
        if (sparse.count < 0 || sparse.indices.byteOffset < 0 || sparse.values.byteOffset < 0 ||
            index_size == 0 || sparse.indices.componentType == TINYGLTF_COMPONENT_TYPE_FLOAT) {
            return fail(error_code::malformed, "has a sparse part of negative size or wrong type");
        }
        auto indices = view_bytes(document, sparse.indices.bufferView);
        if (!indices) return indices.error();
        auto values = view_bytes(document, sparse.values.bufferView);
        if (!values) return values.error();
        const auto sparse_count = static_cast<std::size_t>(sparse.count);
        const auto index_offset = static_cast<std::size_t>(sparse.indices.byteOffset);
        const auto value_offset = static_cast<std::size_t>(sparse.values.byteOffset);
        if (!fits(index_offset, sparse_count, index_size, index_size, indices->size()) ||
            !fits(value_offset, sparse_count, element, element, values->size())) {
            return fail(error_code::out_of_range, "has a sparse part beyond its buffer view");
        }
        for (std::size_t i = 0; i < sparse_count; ++i) {
            const auto target =
                read_component<std::uint32_t>(indices->data() + index_offset + i * index_size,
                                              sparse.indices.componentType, false);
            if (target >= count) {
                return fail(error_code::out_of_range, "has a sparse index beyond its last element");
            }
            read_element(target, values->data() + value_offset + i * element);
        }
    }
    return column;
}

}  // namespace billow::inline BILLOW_ABI::detail
