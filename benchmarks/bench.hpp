// What the benchmarks share: names of rows, inputs, units.
#pragma once

#include <benchmark/benchmark.h>

#include <chrono>
#include <ctime>
#include <map>
#include <string>

#include <billow/core/config.hpp>
#include <billow/core/parallel.hpp>
#include <billow/mesh/face_table.hpp>
#include <billow/shapes/leaf_soup.hpp>

namespace bench {

/// The instruction set that the lanes were compiled for.
inline const std::string isa = BILLOW_DETAIL_TEXT(BILLOW_ISA);

/// Adds the row `<header>/<input>/<size>/<isa>x<threads>`. Every family has a row of size 1000,
/// which is what the test runs.
template <class Body>
void add_row(const std::string& family, std::size_t size, const std::string& lanes,
             unsigned threads, const Body& body) {
    const std::string name =
        family + '/' + std::to_string(size) + '/' + lanes + 'x' + std::to_string(threads);
    benchmark::RegisterBenchmark(name.c_str(), body)->Unit(benchmark::kMillisecond);
}

/// A column: time by the clock, in 1 / per_second seconds, for each of `items`.
struct unit_time {
    const char* column;
    double per_second;
    double items;
};

inline unit_time ns_per_face(std::size_t faces) {
    return {"ns_per_face", 1e9, static_cast<double>(faces)};
}

/// Repeats `step` and reports its unit time and the processor time of all threads, which other work
/// on the machine disturbs less.
template <class Step>
void repeat(benchmark::State& state, const unit_time& unit, const Step& step) {
    const auto start = std::chrono::steady_clock::now();
    const std::clock_t busy = std::clock();
    for (auto _ : state) step();
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    const double busy_seconds = static_cast<double>(std::clock() - busy) / CLOCKS_PER_SEC;
    const auto count = static_cast<double>(state.iterations());
    state.counters[unit.column] = seconds.count() * unit.per_second / (unit.items * count);
    state.counters["cpu_ms"] = busy_seconds * 1e3 / count;
}

/// A mesh and its faces, made once.
struct scene {
    billow::mesh mesh;
    billow::face_table faces;

    explicit scene(billow::mesh m) : mesh(std::move(m)), faces(*billow::make_face_table(mesh)) {}
};

/// Leaves so small against an epsilon of 10 % of the radius that every face is valid for nearly
/// every orientation. No other input of as many faces costs the density more.
inline const scene& leaves(std::size_t face_count) {
    static std::map<std::size_t, scene> made;
    const auto found = made.find(face_count);
    if (found != made.end()) return found->second;
    return made.emplace(face_count, scene(billow::leaf_soup(face_count))).first->second;
}
inline constexpr double epsilon_share = 0.1;

}  // namespace bench
