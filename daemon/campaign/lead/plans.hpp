#pragma once
// Plans that clients order by name, plans of a few numbers, and what the check of a plan needs to know of a
// bench.
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "daemon/bench/bench.hpp"
#include "daemon/campaign/plan_check.hpp"
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

/// Largest gamma of a return at each frequency of the points that the limits of the bench allow, m/s^2;
/// infinite where the data sheet has no response at the second harmonic.
std::map<double, double> most_return_gamma(const std::vector<Point>& points, const bench::Bench& bench);

/// Walker, limits and swing of the base at each drive of the points. Does not refer to the bench afterwards.
/// The caller adds the length of the view, and the walker's place where it is known.
CheckSettings check_settings(const Plan& plan, const std::vector<Point>& points, const bench::Bench& bench);

}  // namespace shaker::campaign
