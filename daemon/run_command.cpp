#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

#include <chrono>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "daemon/acquisition.hpp"
#include "daemon/commands.hpp"
#include "daemon/director.hpp"
#include "daemon/loops.hpp"
#include "daemon/recording.hpp"
#include "daemon/results.hpp"
#include "daemon/rigs.hpp"
#include "drivers/errors.hpp"

namespace shaker {

namespace {

constexpr std::size_t block_samples = 240;  // 5 ms at 48 kHz

std::string settings_text(const RunOptions& o) {
    return fmt::format(
        "[run]\nrig = \"{}\"\nfrequency_hz = {:?}\n", o.rig, o.drive.frequency);
}

// What the scene did, where it is known: the walker's exact displacement over the whole periods that were reduced.
std::optional<double> true_drift_velocity(const World& world, double from_s, double to_s, double frequency) {
    const std::vector<PoseTruth> poses = world.truth(0);
    const auto in = [&](const PoseTruth& p) { return seconds(p.time) >= from_s; };
    const auto first = std::ranges::find_if(poses, in);
    if (first == poses.end()) return std::nullopt;
    const double periods = std::floor((to_s - seconds(first->time)) * frequency);
    const double end = seconds(first->time) + periods / frequency;
    // Frames may not fall on whole periods: the two next to the end are joined by the base-frequency-free line.
    const auto after = std::ranges::find_if(poses, [&](const PoseTruth& p) { return seconds(p.time) >= end - 1e-9; });
    if (periods < 1 || after == poses.end()) return std::nullopt;
    if (std::abs(seconds(after->time) - end) > 1e-7) return std::nullopt;
    return (after->walker - first->walker) / (periods / frequency);
}

}  // namespace

}  // namespace shaker
