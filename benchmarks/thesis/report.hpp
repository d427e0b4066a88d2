// Sections of docs/results.md: tables of text with what is said before them.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace thesis {

/// Numbers are text: as many digits as they are worth.
struct section {
    std::string id{};
    std::string title{};
    std::string about{};  ///< a paragraph before the table
    std::vector<std::string> columns{};
    std::vector<std::vector<std::string>> rows{};
    double seconds = 0;   ///< that measuring took, by the clock
    std::string where{};  ///< the machine and the compiler
};

/// Sections by id, kept in a JSON file between runs.
class result_file {
public:
    explicit result_file(std::filesystem::path file);
    void put(section made);
    [[nodiscard]] const section* find(const std::string& id) const;
    void save() const;

private:
    std::filesystem::path file_;
    std::vector<section> sections_{};
};

/// The page: `order` of sections with the notes below each. Notes are paragraphs under "## id" lines;
/// those of "head" come first.
void write_page(const std::filesystem::path& page, const result_file& results,
                const std::vector<std::string>& order, const std::filesystem::path& notes);

/// Processor, number of processors, compiler.
[[nodiscard]] std::string this_machine();

/// With so many decimals; - instead of what is no number.
[[nodiscard]] std::string number(double value, int decimals = 2);
[[nodiscard]] std::string percent(double share, int decimals = 1);

}  // namespace thesis
