#include "drivers/footage/picture_clock.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "drivers/errors.hpp"
#include "drivers/footage/csv.hpp"
#include "drivers/footage/grid.hpp"
#include "drivers/quantity.hpp"
#include "drivers/time.hpp"

namespace shaker::footage {

namespace {

constexpr double rounded = 0.6;      // of the unit of the stamps: as far as rounding moves a stamp
constexpr double jitter = 0.02;      // of a step, which a grid may have besides
constexpr double near_rate = 0.1;    // a stated rate and uneven stamps describe the same pictures
constexpr double longest_gap = 1e6;  // steps; no recording goes on after it
constexpr double most_coarse = 0.5;  // of a step: a coarser unit cannot separate two pictures
constexpr double clear_gap = 1.8;    // usual steps; less is jitter

std::string rounded_text(double value) { return to_text(std::round(1e3 * value) / 1e3); }

std::vector<double> read_times(const std::filesystem::path& file) {
    const std::array<std::string, 1> column{"t_s"};
    const CsvColumns table = read_csv(file, column);
    require_increasing(table);
    return table.values.front();
}

double median_step(const std::vector<double>& t) {
    std::vector<double> steps;
    for (std::size_t i = 1; i < t.size(); ++i) steps.push_back(t[i] - t[i - 1]);
    const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
    std::nth_element(steps.begin(), middle, steps.end());
    return *middle;
}

/// Median of the steps near the one before t[i]: the rate may change within a movie.
double usual_step_near(const std::vector<double>& t, std::size_t i) {
    constexpr std::size_t each_side = 6;
    const std::size_t from = i > each_side ? i - each_side : 0, to = std::min(i + each_side, t.size());
    return median_step(
        {t.begin() + static_cast<std::ptrdiff_t>(from), t.begin() + static_cast<std::ptrdiff_t>(to)});
}

bool repeats(const std::vector<double>& at_s) {
    return std::adjacent_find(at_s.begin(), at_s.end()) != at_s.end();
}

void require_forward(const std::string& file, const std::vector<double>& at_s) {
    std::size_t wrong = 0, first = 0;
    for (std::size_t i = 1; i < at_s.size(); ++i)
        if (!(at_s[i] > at_s[i - 1]) && wrong++ == 0) first = i;
    if (wrong == 0) return;
    throw InputError{file + ": the stamps of " + std::to_string(wrong) + " of its " +
                     std::to_string(at_s.size()) + " pictures step back or repeat, first that of picture " +
                     std::to_string(first) + ", " + to_text(at_s[first]) + " s after " +
                     to_text(at_s[first - 1]) + " s; give the times of the pictures as a table (`times`)"};
}

double allowed_s(const Stamps& stamps, double step_s) {
    return rounded * stamps.resolution_s + jitter * step_s;
}

/// A grid of about this rate that all stamps are on, most of them directly behind another.
std::optional<Grid> grid_of(const Stamps& stamps, double rate_hz) {
    if (!(rate_hz > 0)) return {};
    Grid grid = fitted_grid(stamps.at_s, 1 / rate_hz);
    const bool near = std::abs(grid.step_s * rate_hz - 1) < near_rate;
    std::int64_t in_a_row = 0;
    for (std::size_t i = 1; i < grid.ticks.size(); ++i)
        in_a_row += grid.ticks[i] == grid.ticks[i - 1] + 1 ? 1 : 0;
    const bool dense = 2 * in_a_row >= std::ssize(grid.ticks) - 1;
    if (!near || !dense || grid.off_s > allowed_s(stamps, grid.step_s)) return {};
    return grid;
}

/// True when steps of this rate stay on the grid from its first to its last stamp.
bool keeps_to(const Grid& grid, double rate_hz, double allowed) {
    return std::abs(1 / rate_hz - grid.step_s) * static_cast<double>(grid.ticks.back()) <= allowed;
}

}  // namespace

PictureClock::PictureClock(const LabCamera& camera, Media& media)
    : file_{camera.file.string()},
      stated_hz_{camera.frame_rate_hz.value_or(0)},
      first_s_{camera.first_exposure_s} {
    if (camera.times) {
        std::vector<double> times_s = read_times(*camera.times);
        rows_ = times_s.size();
        rate_hz_ = stated_hz_;
        take_times(std::move(times_s));
    } else {
        const Stamps stamps = media.stamps();
        const double header_hz = media.rate_hz().value_or(0);
        rate_hz_ = stated_hz_ > 0 ? stated_hz_ : header_hz;
        if (stamps.at_s.size() > 1) take(stamps, header_hz);
    }
    if (rate_hz_ > 0) return;
    throw InputError{"camera \"" + camera.view.camera + "\": " + file_ +
                     " does not state its frame rate; set frame_rate_hz or times"};
}

void PictureClock::take_times(std::vector<double> times_s) {
    times_s_ = std::move(times_s);
    if (rate_hz_ <= 0 && times_s_.size() > 1) rate_hz_ = 1 / median_step(times_s_);
    ticks_.assign(1, 0);
    for (std::size_t i = 1; i < times_s_.size(); ++i) {
        const double steps = std::clamp(std::round((times_s_[i] - times_s_[i - 1]) * rate_hz_), 1.0, 1e15);
        ticks_.push_back(ticks_.back() + static_cast<std::int64_t>(steps));
    }
}

// With a unit of 1 ms two pictures of 2000/s have the same stamp, and a rate computed from such stamps is
// wrong.
void PictureClock::take(const Stamps& stamps, double header_hz) {
    const std::vector<double>& at_s = stamps.at_s;
    const double steps = static_cast<double>(at_s.size() - 1), span_s = at_s.back() - at_s.front();
    const bool coarse = stamps.resolution_s * std::max(rate_hz_, steps / span_s) > most_coarse;
    if (coarse && repeats(at_s)) {
        if (stated_hz_ > 0 || std::abs(steps / header_hz - span_s) <= 2 * stamps.resolution_s) return;
        throw InputError{
            file_ + ": the unit of its stamps, " + rounded_text(1e3 * stamps.resolution_s) +
            " ms, is too coarse, so that the rate of its pictures is not known; set frame_rate_hz or times"};
    }
    Stamps believed = stamps;
    if (const double step_s = at_s.size() > 2 ? median_step(at_s) : 0;
        step_s > 0 && at_s.back() - at_s[at_s.size() - 2] > longest_gap * step_s) {
        believed.at_s.back() = at_s[at_s.size() - 2] + step_s;
        notes_.push_back(file_ + ": the stamp of its last picture, " +
                         rounded_text(at_s.back() - at_s[at_s.size() - 2]) +
                         " s after the one before, is not believed");
    }
    require_forward(file_, believed.at_s);
    if (!take_grid(believed, header_hz) && !coarse) take_uneven(believed);
}

// Stated rates are tried first: when the unit of the stamps is as long as a step, only a stated rate
// separates a gap from rounding.
bool PictureClock::take_grid(const Stamps& stamps, double header_hz) {
    const std::vector<double>& at_s = stamps.at_s;
    const double mean_hz = static_cast<double>(at_s.size() - 1) / (at_s.back() - at_s.front());
    for (const double rate_hz : {stated_hz_, header_hz, 1 / usual_step(at_s), mean_hz}) {
        const std::optional<Grid> grid = grid_of(stamps, rate_hz);
        if (!grid) continue;
        const double allowed = allowed_s(stamps, grid->step_s), grid_hz = 1 / grid->step_s;
        ticks_ = grid->ticks;
        if (stated_hz_ <= 0)
            rate_hz_ = header_hz > 0 && keeps_to(*grid, header_hz, allowed) ? header_hz : grid_hz;
        else if (!keeps_to(*grid, stated_hz_, allowed))
            notes_.push_back(file_ + ": frame_rate_hz = " + to_text(stated_hz_) +
                             " is used, but the stamps of its pictures are those of " +
                             rounded_text(grid_hz) + " pictures/s (slow motion?)");
        std::int64_t longest = 0;
        for (std::size_t i = 1; i < ticks_.size(); ++i)
            longest = std::max(longest, ticks_[i] - ticks_[i - 1] - 1);
        if (longest > 0)
            notes_.push_back(file_ + ": by the stamps of its pictures, " +
                             std::to_string(ticks_.back() + 1 - std::ssize(ticks_)) + " are lost, at most " +
                             std::to_string(longest) + " in a row");
        return true;
    }
    return false;
}

void PictureClock::take_uneven(const Stamps& stamps) {
    const double median_s = median_step(stamps.at_s);
    if (stated_hz_ > 0 && std::abs(stated_hz_ * median_s - 1) > near_rate)
        throw InputError{file_ + ": the stamps of its pictures are uneven, and frame_rate_hz = " +
                         to_text(stated_hz_) + " is not their usual rate of " + rounded_text(1 / median_s) +
                         "; leave frame_rate_hz out, or give the times of the pictures as a table (`times`)"};
    const Grid grid = fitted_grid(stamps.at_s, median_s);
    notes_.push_back(file_ + ": its pictures are not evenly spaced (up to " + rounded_text(1e3 * grid.off_s) +
                     " ms from a grid of " + rounded_text(1 / grid.step_s) +
                     "/s); their own stamps are used as times");
    rate_hz_ = 1 / median_s;
    std::vector<double> times_s = stamps.at_s;
    for (double& t : times_s) t += first_s_ - stamps.at_s.front();
    times_s_ = std::move(times_s);
    ticks_.assign(1, 0);
    for (std::size_t i = 1; i < times_s_.size(); ++i) {
        const double steps = (times_s_[i] - times_s_[i - 1]) / usual_step_near(times_s_, i);
        ticks_.push_back(ticks_.back() + (steps < clear_gap ? 1 : std::llround(steps)));
    }
}

PictureClock::Exposure PictureClock::exposure(std::int64_t number, std::int64_t given) const {
    const std::int64_t n = rows_ > 0 ? given : number;
    const auto at = static_cast<std::size_t>(n);
    const std::int64_t tick = ticks_.empty() ? n : ticks_.at(at);
    if (has_times()) return {tick, times_s_.at(at)};
    return {tick, first_s_ + duration_s(tick, rate_hz_)};
}

}  // namespace shaker::footage
