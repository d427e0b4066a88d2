#include "report.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <map>
#include <sstream>
#include <thread>

#include <nlohmann/json.hpp>

namespace thesis {

namespace {

std::map<std::string, std::string> read_notes(const std::filesystem::path& file) {
    std::map<std::string, std::string> notes;
    std::ifstream in(file);
    std::string id;
    for (std::string line; std::getline(in, line);) {
        if (line.starts_with("## ")) {
            id = line.substr(3);
        } else if (!id.empty()) {
            notes[id] += line + '\n';
        }
    }
    for (auto& [key, text] : notes) {
        const auto begin = text.find_first_not_of('\n');
        const auto end = text.find_last_not_of('\n');
        text = begin == std::string::npos ? "" : text.substr(begin, end - begin + 1);
    }
    return notes;
}

void write_table(std::ostream& out, const section& of) {
    out << '|';
    for (const std::string& column : of.columns) out << ' ' << column << " |";
    out << "\n|";
    for (std::size_t i = 0; i < of.columns.size(); ++i) out << (i < 2 ? "---|" : "---:|");
    out << '\n';
    for (const auto& row : of.rows) {
        out << '|';
        for (const std::string& cell : row) out << ' ' << cell << (cell.empty() ? "|" : " |");
        out << '\n';
    }
}

}  // namespace

result_file::result_file(std::filesystem::path file) : file_(std::move(file)) {
    std::ifstream in(file_);
    const auto json = nlohmann::json::parse(in, nullptr, false);
    if (!json.is_array()) return;
    for (const auto& s : json) {
        sections_.push_back({s.value("id", ""), s.value("title", ""), s.value("about", ""),
                             s.value("columns", std::vector<std::string>{}),
                             s.value("rows", std::vector<std::vector<std::string>>{}),
                             s.value("seconds", 0.0), s.value("where", "")});
    }
}

void result_file::put(section made) {
    std::erase_if(sections_, [&](const section& s) { return s.id == made.id; });
    sections_.push_back(std::move(made));
    std::sort(sections_.begin(), sections_.end(),
              [](const section& a, const section& b) { return a.id < b.id; });
}

const section* result_file::find(const std::string& id) const {
    const auto at = std::find_if(sections_.begin(), sections_.end(),
                                 [&](const section& s) { return s.id == id; });
    return at == sections_.end() ? nullptr : &*at;
}

void result_file::save() const {
    auto json = nlohmann::json::array();
    for (const section& s : sections_) {
        json.push_back({{"id", s.id},
                        {"title", s.title},
                        {"about", s.about},
                        {"columns", s.columns},
                        {"rows", s.rows},
                        {"seconds", s.seconds},
                        {"where", s.where}});
    }
    std::ofstream(file_) << json.dump(1) << '\n';
}

void write_page(const std::filesystem::path& page, const result_file& results,
                const std::vector<std::string>& order, const std::filesystem::path& notes) {
    const auto said = read_notes(notes);
    const auto note = [&](const std::string& id) {
        const auto at = said.find(id);
        return at == said.end() ? std::string() : at->second;
    };
    std::ofstream out(page);
    out << "<!-- Written by billow_thesis. Change benchmarks/thesis, not this page. -->\n";
    out << note("head") << '\n';
    std::vector<std::string> machines;
    for (const std::string& id : order) {
        const section* s = results.find(id);
        if (s == nullptr) continue;
        if (std::find(machines.begin(), machines.end(), s->where) == machines.end()) {
            machines.push_back(s->where);
        }
    }
    for (const std::string& machine : machines) out << "\nMeasured on: " << machine << ".\n";
    for (const std::string& id : order) {
        const section* s = results.find(id);
        if (s == nullptr) continue;
        out << "\n## " << s->title << "\n\n" << s->about << "\n\n";
        write_table(out, *s);
        if (const std::string text = note(id); !text.empty()) out << '\n' << text << '\n';
    }
    if (const std::string text = note("tail"); !text.empty()) out << '\n' << text << '\n';
}

std::string this_machine() {
    std::string name = "unknown processor";
    std::ifstream in("/proc/cpuinfo");
    for (std::string line; std::getline(in, line);) {
        if (!line.starts_with("model name")) continue;
        const std::size_t at = line.find(':');
        if (at != std::string::npos) name = line.substr(std::min(line.size(), at + 2));
        break;
    }
    const unsigned processors = std::thread::hardware_concurrency();
    std::ostringstream text;
    text << name << ", " << processors << (processors == 1 ? " processor" : " processors");
#if defined(__clang__)
    text << ", clang " << __clang_major__ << '.' << __clang_minor__;
#elif defined(__GNUC__)
    text << ", g++ " << __GNUC__ << '.' << __GNUC_MINOR__;
#endif
    return text.str();
}

std::string number(double value, int decimals) {
    if (!std::isfinite(value)) return "-";
    char text[64];
    std::snprintf(text, sizeof text, "%.*f", decimals, value);
    // No minus before a zero.
    if (std::strtod(text, nullptr) == 0) std::snprintf(text, sizeof text, "%.*f", decimals, 0.0);
    return text;
}

std::string percent(double share, int decimals) { return number(100 * share, decimals) + " %"; }

}  // namespace thesis
