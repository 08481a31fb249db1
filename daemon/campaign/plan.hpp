#pragma once
// Plan: which set-points a campaign measures, as its file states them. Point: one of them, in the order of
// measurement.
// daemon/campaign/README.md describes the file's format.
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/point_fields.hpp"

namespace shaker::campaign {

/// Order of the points of a series.
enum class Order {
    listed,   // as they are nested
    mirror,   // each followed by its mirror partner, phi + pi, whose drift is the opposite
    random,   // shuffled, by a seed
    up_down,  // as they are nested, then back
};

using Overtones = decltype(Drive::overtones);

/// The Cartesian product of its values. Nesting, outermost first: frequency (a new recording for each),
/// overtones, rho, gamma, phi. No list is empty; a value that the series does not give is the default of the
/// plan.
struct Series {
    std::string name{};
    std::vector<double> frequency{}, rho{}, gamma{}, phi{};  // SI units
    std::vector<Overtones> overtones{{}};
    PointSettings settings{};  // measuring and settling; its drive does not count
    Order order = Order::listed;
    std::uint64_t seed = 1;  // of order random
    int repeats = 1;         // of the whole series
    std::size_t line = 0;    // of the plan's file
    std::size_t gamma_line = 0;
};

struct Plan {
    std::string file;  // name of the file, for messages
    std::string title;
    double mu = 0.113;          // friction coefficient for predictions until the campaign has measured it
    double mu_target = 0;       // relative standard error of mu at which the campaign ends; 0: all points
    double edge_margin_mm = 2;  // a pass ends softly so far inside the limit at the edge
    std::vector<Series> series{};
};

struct Point {
    int id = 0;  // 1, 2, ... in the order of measurement
    std::string series{};
    PointSettings asked{};
    int repeat = 1;   // 1, 2, ... of this set-point in its series
    int partner = 0;  // id of the mirror partner in this repeat; 0: none
};

inline constexpr std::size_t most_points = 10'000;  // of a new plan: work at its start grows with them
// Of a folder, which an earlier version may have begun.
inline constexpr std::size_t most_stored_points = 100'000;

/// The drive whose drift is the opposite for any friction that is the same in both directions, on a level
/// base: half a period later it is the mirror image. phi differs by pi, the harmonics 4, 6 and 8 by their
/// sign.
Drive mirror_partner(const Drive& drive);

/// Series after series, each as its order says, `repeats` times; an up_down series goes up and down in each
/// repeat. Equal plans give equal points on any machine: order random is Fisher and Yates' shuffle from the
/// last point to the second, with x mod i of successive numbers x of std::mt19937_64 {seed}. InputError for
/// more than `most`.
std::vector<Point> schedule(const Plan& plan, std::size_t most = most_points);

inline constexpr int most_steps = 10'000;    // of a range
inline constexpr int most_repeats = 10'000;  // of a series

/// InputError with file, line, key, value and what is allowed: for unknown keys, values out of range or given
/// twice, empty lists, a number of periods beside a precision, a range without steps, and a list of order
/// mirror that has a mirror partner.
Plan read_plan(const std::filesystem::path& file);
Plan parse_plan(std::string_view text, const std::string& file_name);

}  // namespace shaker::campaign
