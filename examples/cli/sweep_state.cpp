// What a sweep has measured so far, in a file.

#include "sweep_state.hpp"

#include <cstdio>
#include <string_view>
#include <utility>

#include <billow/io/file.hpp>

#include "shared.hpp"

namespace cli {

namespace {

using sweep_json = nlohmann::ordered_json;

/// FNV-1a of 64 bits: tells files apart, not attackers.
std::uint64_t hash_of(std::span<const std::uint8_t> bytes) {
    std::uint64_t hash = 0xcbf29ce484222325u;
    for (const std::uint8_t byte : bytes) hash = (hash ^ byte) * 0x100000001b3u;
    return hash;
}

std::string head_of(std::span<const std::uint8_t> input) {
    char hash[17];
    std::snprintf(hash, sizeof hash, "%016llx", static_cast<unsigned long long>(hash_of(input)));
    sweep_json head;
    head["schema"] = "billow-sweep-state/1";
    head["input"]["bytes"] = input.size();
    head["input"]["fnv1a"] = hash;
    return head.dump();
}

/// Whether a line is one of ours, and then the row that it holds.
bool read_row(std::string_view line, sweep_row& row) {
    sweep_json told = sweep_json::parse(line, nullptr, false);
    if (!told.is_object()) return false;
    for (const auto& [name, part] : {std::pair("key", &row.key), std::pair("numbers", &row.numbers),
                                     std::pair("seconds", &row.seconds)}) {
        if (!told.contains(name) || !told[name].is_object()) return false;
        *part = std::move(told[name]);
    }
    return true;
}

}  // namespace

billow::expected<sweep_state> sweep_state::open(const std::filesystem::path& file,
                                                std::span<const std::uint8_t> input) {
    sweep_state state;
    state.file_ = file;
    state.head_ = head_of(input);
    std::error_code ignored;
    if (!std::filesystem::exists(file, ignored)) return state;
    const auto bytes = billow::read_file(file);
    if (!bytes) return bytes.error();
    std::string_view rest(reinterpret_cast<const char*>(bytes->data()), bytes->size());
    const auto refuse = [&](std::string_view why) {
        return billow::detail::file_error(billow::error_code::malformed, file, why);
    };
    for (std::size_t number = 1; !rest.empty(); ++number) {
        const std::size_t end = rest.find('\n');
        const std::string_view line = rest.substr(0, end);
        rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
        if (number == 1) {
            if (line == state.head_) continue;
            return refuse(line.find("\"billow-sweep-state/1\"") != std::string_view::npos
                              ? "belongs to a sweep of another input; name another --output, or "
                                "remove the file"
                              : "is not the state of a sweep; name another --output");
        }
        sweep_row row;
        if (!read_row(line, row)) {
            return refuse("line " + std::to_string(number) +
                          " is no row of a sweep; remove the line, or the file");
        }
        state.rows_.push_back(std::move(row));
    }
    return state;
}

const sweep_row* sweep_state::find(const sweep_json& key) const {
    for (const sweep_row& row : rows_) {
        if (row.key == key) return &row;
    }
    return nullptr;
}

billow::expected<billow::done> sweep_state::add(sweep_row row) {
    rows_.push_back(std::move(row));
    std::string text = head_ + "\n";
    for (const sweep_row& each : rows_) {
        sweep_json line;
        line["key"] = each.key;
        line["numbers"] = each.numbers;
        line["seconds"] = each.seconds;
        text += line.dump(-1, ' ', false, sweep_json::error_handler_t::replace) + "\n";
    }
    return write_text(file_, text);
}

}  // namespace cli
