#include "daemon/reduction/bad_samples.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "calibration/accelerometer/transverse.hpp"
#include "daemon/reduction/check/bench_check.hpp"
#include "daemon/reduction/selection.hpp"
#include "drivers/errors.hpp"

namespace shaker::reduction {
namespace {

constexpr double far_sigmas = 8, far_share = 0.05;  // of the residuals' deviation; of gamma
constexpr double sigma_per_median = 1.4826;         // of the absolute value of normal residuals
constexpr std::size_t least_run = 4;                // equal values that may be a frozen stretch
constexpr double moved_share = 0.25;                // of the motion's range, during a frozen stretch
constexpr double share_of_largest = 0.25;  // a large one moves the fit, so others seem bad; these wait a pass
constexpr int most_passes = 8;

/// A sample that was left out, at a time of the sensor's own clock.
struct Removed {
    double t_s;
    bool frozen;
};

enum class Mark : char { good, single, frozen };

double median(std::vector<double> values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

void mark_far(std::span<const double> deviation, double least, std::vector<Mark>& marks) {
    std::vector<double> sizes;
    sizes.reserve(deviation.size());
    for (const double d : deviation) sizes.push_back(std::abs(d));
    const double largest = std::ranges::max(sizes);
    if (largest <= least) return;
    const double limit =
        std::max({far_sigmas * sigma_per_median * median(sizes), least, share_of_largest * largest});
    for (std::size_t i = 0; i < sizes.size(); ++i)
        if (sizes[i] > limit) marks[i] = Mark::single;
}

/// Without a model: values that are so far from the median that they would spoil the alignment. The limit is
/// ten times the largest value of a biharmonic motion.
std::vector<Mark> gross(const AccelSeries& s) {
    constexpr double limit_medians = 30, least_rms = 6, most_share = 0.01;
    std::vector<Mark> marks(s.a_mps2.size(), Mark::good);
    const auto n = static_cast<double>(s.a_mps2.size());
    for (std::size_t axis = 0; axis < 3; ++axis) {
        double mean = 0, squares = 0, most = 0;
        for (const auto& a : s.a_mps2) mean += a[axis] / n;
        for (const auto& a : s.a_mps2) {
            squares += (a[axis] - mean) * (a[axis] - mean);
            most = std::max(most, std::abs(a[axis] - mean));
        }
        if (most <= least_rms * std::sqrt(squares / n)) continue;  // at most 1 % are gross
        std::vector<double> values;
        for (const auto& a : s.a_mps2) values.push_back(a[axis]);
        const double centre = median(values);
        for (double& v : values) v = std::abs(v - centre);
        const double limit = limit_medians * median(values);
        if (!(limit > 0)) continue;  // no more than single steps of the sensor's resolution
        for (std::size_t i = 0; i < values.size(); ++i)
            if (values[i] > limit) marks[i] = Mark::single;
    }
    const auto marked = std::ranges::count(marks, Mark::single);
    if (static_cast<double>(marked) > most_share * n) std::ranges::fill(marks, Mark::good);
    return marks;
}

/// Marks runs of equal values. `model`: the base's motion along the axis at these samples, m/s^2.
void mark_frozen(std::span<const std::array<double, 3>> a, const std::array<double, 3>& u,
                 std::span<const double> model, std::vector<Mark>& marks) {
    constexpr double least_cosine = 0.1;
    const auto [low, high] = std::ranges::minmax(model);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        if (std::abs(u[axis]) < least_cosine) continue;
        double step = INFINITY;  // resolution of the sensor
        for (std::size_t i = 1; i < a.size(); ++i)
            if (const double d = std::abs(a[i][axis] - a[i - 1][axis]); d > 0) step = std::min(step, d);
        const double moved = std::max(moved_share * (high - low), 2 * step / std::abs(u[axis]));
        for (std::size_t from = 0, to = 0; from < a.size(); from = to) {
            while (to < a.size() && a[to][axis] == a[from][axis]) ++to;
            if (to - from < least_run) continue;
            const auto [least, most] = std::ranges::minmax(model.subspan(from, to - from));
            const auto begin = marks.begin() + static_cast<std::ptrdiff_t>(from),
                       end = marks.begin() + static_cast<std::ptrdiff_t>(to);
            if (most - least > moved || std::any_of(begin, end, [](Mark m) { return m != Mark::good; }))
                std::fill(begin, end, Mark::frozen);
        }
    }
}

std::vector<Mark> against_motion(const AccelSeries& s, const Alignment& drive) {
    const std::size_t n = drive.t_s.size();
    const std::span samples(s.a_mps2.data() + drive.first_sample, n);
    std::vector<double> model(n), deviation(n);
    drive.acceleration.periodic(drive.t_s, model);
    const auto [low, high] = std::ranges::minmax(model);
    const double least = far_share * (high - low) / 2;
    std::vector<Mark> marks(n, Mark::good);
    for (std::size_t i = 0; i < n; ++i)
        deviation[i] = drive.along_mps2[i] - drive.acceleration.constants[0] - model[i];
    mark_far(deviation, least, marks);
    const auto axes = calibration::across_axes(drive.shaker_axis);
    for (std::size_t k = 0; k < axes.size(); ++k) {
        const calibration::HarmonicFit& fit = drive.across[k];
        fit.periodic(drive.t_s, deviation);
        for (std::size_t i = 0; i < n; ++i) {
            const auto& a = samples[i];
            const double y = a[0] * axes[k][0] + a[1] * axes[k][1] + a[2] * axes[k][2];
            deviation[i] = y - fit.constants[0] - deviation[i];
        }
        mark_far(deviation, least, marks);
    }
    mark_frozen(samples, drive.shaker_axis, model, marks);
    return marks;
}

/// Removes the marked samples; marks[0] belongs to sample `first`. True when there were some.
bool remove(AccelSeries& s, std::size_t first, const std::vector<Mark>& marks,
            std::vector<Removed>& removed) {
    if (std::ranges::count(marks, Mark::good) == std::ssize(marks)) return false;
    std::size_t kept = first;
    for (std::size_t i = first; i < s.t_s.size(); ++i) {
        if (const Mark mark = i - first < marks.size() ? marks[i - first] : Mark::good; mark != Mark::good) {
            removed.push_back({s.t_s[i], mark == Mark::frozen});
            continue;
        }
        s.t_s[kept] = s.t_s[i];
        s.a_mps2[kept++] = s.a_mps2[i];
    }
    s.t_s.resize(kept);
    s.a_mps2.resize(kept);
    return true;
}

/// Whether more of these phases (0..1) lie within a window of this width than chance allows. With n phases,
/// the probability of m in a window is at most n C(n-1, m-1) width^(m-1).
bool coincide(std::vector<double> phases, double width) {
    constexpr double unlikely = 1e-3;
    std::ranges::sort(phases);
    const std::size_t n = phases.size();
    std::size_t most = 0;
    for (std::size_t i = 0, j = 0; i < n; ++i) {
        while (j < i + n && phases[j % n] + (j >= n ? 1 : 0) <= phases[i] + width) ++j;
        most = std::max(most, j - i);
    }
    if (most < 2) return false;
    const auto N = static_cast<double>(n), M = static_cast<double>(most);
    const double log_choose = std::lgamma(N) - std::lgamma(M) - std::lgamma(N - M + 1);
    return std::log(N) + log_choose + (M - 1) * std::log(width) < std::log(unlikely);
}

/// `covered`: the time of the cameras on the sensor's clock.
BadSamples judged(std::vector<Removed> removed, const Span& covered, const Alignment& drive) {
    BadSamples out{.tested = drive.t_s.size()};
    if (removed.empty()) return out;
    const double step = calibration::median_step(drive.t_s);
    const double turns_per_s = drive.frequency.value * (1 + 1e-6 * drive.ppm.value);
    std::ranges::sort(removed, {}, &Removed::t_s);
    std::vector<double> phases;
    double before = -INFINITY;
    for (const Removed& r : removed) {
        if (r.t_s < covered.from_s - step || r.t_s > covered.to_s + step) continue;
        ++out.tested;
        ++(r.frozen ? out.frozen : out.single);
        const double turns = (r.t_s - covered.from_s) * turns_per_s;
        if (r.t_s - before > 4 * step) phases.push_back(turns - std::floor(turns));
        before = r.t_s;
    }
    out.same_phase = coincide(std::move(phases), std::max(1.0 / 64, 1.5 * step * turns_per_s));
    return out;
}

void note(const BadSamples& bad, std::vector<std::string>& notes) {
    const double percent = 100 * static_cast<double>(bad.count()) / static_cast<double>(bad.tested);
    if (percent <= 0.1 && !bad.degrade()) return;
    std::array<char, 32> share{};
    std::snprintf(share.data(), share.size(), "%.2f %%", percent);
    const std::string counts = std::to_string(bad.count()) + " of " + std::to_string(bad.tested) +
                               " accelerometer samples (" + share.data() +
                               ") are bad: " + std::to_string(bad.single) + " single, " +
                               std::to_string(bad.frozen) + " in frozen stretches";
    if (percent > 50) {
        throw InputError(counts + "; at most 50 % may be. Check the sensor and its cable");
    }
    notes.push_back(counts + "; they are excluded");
    if (!bad.degrade()) return;
    notes.push_back(std::string{degraded_note}.append(
        bad.same_phase ? ": bad accelerometer samples come at the same phase of the period"
                       : ": more than 1 % of the accelerometer's samples are bad"));
}

}  // namespace

Alignment align_without_bad_samples(Measurement& m, BadSamples& found, std::vector<std::string>& notes) {
    std::vector<Removed> removed;
    Span covered{};
    remove(m.accelerometer, 0, gross(m.accelerometer), removed);
    for (int pass = 1;; ++pass) {
        std::vector<std::string> pass_notes;
        Alignment out = align(m, pass_notes);
        const AccelSeries& s = m.accelerometer;
        if (pass == 1) covered = {s.t_s[out.first_sample], s.t_s[out.first_sample + out.t_s.size() - 1]};
        const bool repeat =
            pass < most_passes && remove(m.accelerometer, out.first_sample, against_motion(s, out), removed);
        if (repeat) continue;
        found = judged(std::move(removed), covered, out);
        note(found, notes);
        notes.insert(notes.end(), pass_notes.begin(), pass_notes.end());
        return out;
    }
}

}  // namespace shaker::reduction
