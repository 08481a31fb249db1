#pragma once
// Plans that clients order by name, and plans of a few numbers.
#include <filesystem>
#include <string>
#include <vector>

#include "drivers/drive.hpp"

namespace shaker::campaign {

/// Names of the plans NAME.toml in a folder, sorted; at most `most_plans`. Empty without the folder.
std::vector<std::string> plans_in(const std::filesystem::path& folder);
inline constexpr std::size_t most_plans = 200;
/// The text of the plan NAME.toml. InputError for a name that plans_in() does not list, with the names that
/// it lists, and for a text of more than 64 kB.
std::string plan_text(const std::filesystem::path& folder, const std::string& name);

/// A scan of phi or gamma at otherwise one drive.
struct Scan {
    bool phi = true;          // else of gamma
    double from = 0, to = 0;  // rad or m/s^2, both ends are measured
    int steps = 1;
    Drive rest{};  // the other parameters
    int periods = 40;
    int repeats = 1;
};
/// The plan of a scan. Its parser checks the ranges.
std::string text_of(const Scan& scan);

}  // namespace shaker::campaign
