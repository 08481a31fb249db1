#pragma once
// Campaign: many seeds, in several processes.
#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "tests/orders/coverage.hpp"

namespace shaker::orders {

struct Campaign {
    std::uint64_t first = 1, seeds = 50;
    int jobs = 2;  // processes
    /// Keeps the outcomes of seeds that broke no law. They are left out and count in the totals. Empty: no
    /// file.
    std::filesystem::path done{};
    /// Gets the shortest plan of each seed that broke a law: seed_N.plan. Empty: no plans.
    std::filesystem::path plans{};
    std::filesystem::path folder{};
};

struct Totals {
    std::uint64_t seeds = 0, aborts = 0, trips = 0, recordings = 0, recovered = 0;
    double virtual_s = 0, played_s = 0;  // of all seeds; of those that this call has played
    double wall_s = 0;
    double slowest_abort_s = 0, most_bytes = 0;
    std::vector<std::pair<std::uint64_t, std::string>> broken{};  // seed, law and words
    Coverage coverage{};
};

/// The file for the shortest plan of a seed.
std::filesystem::path plan_file(const std::filesystem::path& plans, std::uint64_t seed);

/// Plays the seeds, each in a process of its own.
Totals play(const Campaign& campaign);

}  // namespace shaker::orders
