#pragma once
// One simulated life of the whole daemon: runner, service, the engines of its doors and the recorder, in
// lockstep on virtual time. Only devices, disk, sockets and clock are replaced.
#include <filesystem>

#include "tests/orders/coverage.hpp"
#include "tests/orders/laws.hpp"
#include "tests/orders/plan.hpp"

namespace shaker::orders {

struct Outcome {
    std::vector<Violation> violations{};
    std::uint64_t fingerprint = 0;  // of all volts
    double virtual_s = 0;
    double slowest_abort_s = 0;  // from an abort to silence
    std::uint64_t aborts = 0, trips = 0, recordings = 0, replayed = 0, recovered = 0;
    double most_bytes = 0;  // memory of the process that played it; by play_alone() only
    Coverage coverage{};
    std::vector<std::string> log{};  // events of the bench, one line each
};

/// Plays a plan in an empty folder. The same plan gives the same outcome.
Outcome simulate(const Plan& plan, const std::filesystem::path& folder);

}  // namespace shaker::orders
