#include "calibration/accelerometer/response_fit.hpp"

#include <spdlog/fmt/fmt.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <numbers>
#include <optional>

#include "drivers/drive.hpp"
#include "drivers/errors.hpp"

namespace shaker::calibration {

namespace {

constexpr double bias_of_gain = 2e-4, bias_of_phase = 1e-4;  // of a line: trackers, exposure
constexpr double unseen = 30;                                // times the highest line: no low-pass
constexpr double likely = 3.84;                              // of chi^2, one unknown: 95 %

/// Unknowns in order: ln of the gain, delay of each run in s, corner in Hz, 1 / low-pass in s.
struct ResponseModel {
    SensorResponse kind;
    bool lower = false, upper = false;
    int runs = 1;
    [[nodiscard]] Eigen::Index unknowns() const { return 1 + runs + (lower ? 1 : 0) + (upper ? 1 : 0); }
    [[nodiscard]] Eigen::Index lower_at() const { return 1 + runs; }
    [[nodiscard]] Eigen::Index upper_at() const { return unknowns() - 1; }
    [[nodiscard]] SensorResponse at(const Eigen::VectorXd& x) const {
        SensorResponse out = kind;
        if (lower) out.lower.hz = x(lower_at());
        if (upper) out.upper.hz = 1 / x(upper_at());
        return out;
    }
};

/// Lines minus model over their errors, amplitudes first; `by`: derivative of the model over the errors.
Eigen::VectorXd off_response(std::span<const ResponseLine> lines, const ResponseModel& model,
                             const Eigen::VectorXd& x, Eigen::MatrixXd* by) {
    const auto n = std::ssize(lines);
    const SensorResponse response = model.at(x);
    Eigen::VectorXd r(2 * n);
    if (by != nullptr) *by = Eigen::MatrixXd::Zero(2 * n, model.unknowns());
    for (Eigen::Index i = 0; i < n; ++i) {
        const ResponseLine& line = lines[static_cast<std::size_t>(i)];
        const std::complex<double> h = response.at(line.hz);
        const double gain_error = std::hypot(line.log_gain.sigma, bias_of_gain),
                     phase_error = std::hypot(line.lead_rad.sigma, bias_of_phase), w = two_pi * line.hz;
        r(i) = (line.log_gain.value - x(0) - std::log(std::abs(h))) / gain_error;
        r(n + i) =
            std::remainder(line.lead_rad.value - std::arg(h) + w * x(1 + line.run), two_pi) / phase_error;
        if (by == nullptr) continue;
        const auto set = [&](Eigen::Index k, std::complex<double> rate) {
            (*by)(i, k) = rate.real() / gain_error;
            (*by)(n + i, k) = rate.imag() / phase_error;
        };
        set(0, 1);
        set(1 + line.run, {0, -w});
        if (model.lower) set(model.lower_at(), response.lower.log_rate(line.hz));
        if (model.upper)
            set(model.upper_at(), -response.upper.log_rate(line.hz) * response.upper.hz * response.upper.hz);
    }
    return r;
}

struct Solved {
    Eigen::VectorXd x;
    Eigen::MatrixXd covariance;
    double chi2 = 0;
};

/// Gauss-Newton with steps halved until they gain; the first `moved` unknowns move, the others stay.
Solved solved(std::span<const ResponseLine> lines, const ResponseModel& model, Eigen::VectorXd x,
              Eigen::Index moved) {
    constexpr int most_steps = 60, halvings = 12;
    Eigen::MatrixXd by;
    Eigen::VectorXd r = off_response(lines, model, x, &by);
    for (int step = 0; step < most_steps; ++step) {
        const Eigen::MatrixXd J = by.leftCols(moved);
        const Eigen::VectorXd full = J.colPivHouseholderQr().solve(r);
        double share = 1, gained = 0;
        for (int k = 0; k < halvings; ++k, share /= 2) {
            Eigen::VectorXd next = x;
            next.head(moved) += share * full;
            const bool allowed =
                (!model.lower || next(model.lower_at()) > 0) && (!model.upper || next(model.upper_at()) > 0);
            if (!allowed) continue;
            const double before = r.squaredNorm(),
                         after = off_response(lines, model, next, nullptr).squaredNorm();
            if (!(after < before)) continue;
            gained = before - after;
            x = next;
            r = off_response(lines, model, x, &by);
            break;
        }
        if (gained < 1e-9) break;
    }
    const Eigen::MatrixXd J = by.leftCols(moved);
    return {x, (J.transpose() * J).inverse(), r.squaredNorm()};
}

/// From the best of a grid of corners and low-passes.
Solved best_response(std::span<const ResponseLine> lines, const ResponseModel& model) {
    constexpr std::array none{0.0};
    constexpr std::array corners{0.03, 0.1, 0.3, 1.0, 3.0, 10.0};
    constexpr std::array passes{100.0, 200.0, 400.0, 800.0, 2000.0};
    const std::span<const double> lower = model.lower ? std::span<const double>{corners} : none,
                                  upper = model.upper ? std::span<const double>{passes} : none;
    std::optional<Solved> best;
    for (const double corner : lower)
        for (const double pass : upper) {
            Eigen::VectorXd x = Eigen::VectorXd::Zero(model.unknowns());
            if (model.lower) x(model.lower_at()) = corner;
            if (model.upper) x(model.upper_at()) = 1 / pass;
            const Solved found = solved(lines, model, x, 1 + model.runs);
            if (!best || found.chi2 < best->chi2) best = found;
        }
    return solved(lines, model, best->x, model.unknowns());
}

std::vector<ResponseModel> response_models(int runs, bool gravity) {
    constexpr double butterworth = 1 / std::numbers::sqrt2;
    std::vector<LowerCorner> lower{{}};
    if (!gravity)
        lower.insert(
            lower.end(),
            {{.hz = 1, .poles = 1}, {.hz = 1, .poles = 2}, {.hz = 1, .poles = 2, .damping = butterworth}});
    std::vector<ResponseModel> out;
    for (const LowerCorner& corner : lower)
        for (const LowPass& pass : {LowPass{}, LowPass{.hz = 1, .poles = 1}, LowPass{.hz = 1, .poles = 2}})
            out.push_back({{corner, pass, {}}, corner.hz > 0, pass.hz > 0, runs});
    return out;
}

/// The low-pass of two poles whose chi^2 exceeds that of `found`, which has none, by `likely`.
double least_low_pass(std::span<const ResponseLine> lines, const ResponseModel& without, const Solved& found,
                      double scale) {
    ResponseModel with = without;
    with.upper = true;
    Eigen::VectorXd x(with.unknowns());
    x << found.x, 0;
    const auto excess = [&](double hz) {
        x(with.upper_at()) = 1 / hz;
        return solved(lines, with, x, with.unknowns() - 1).chi2 / scale - found.chi2 / scale;
    };
    double low = 10, high = 1e6;
    if (!(excess(low) > likely)) return low;
    while (high / low > 1.01) {
        const double middle = std::sqrt(low * high);
        (excess(middle) > likely ? low : high) = middle;
    }
    return low;
}

void require_lines(std::span<const ResponseLine> lines, int runs) {
    std::vector<double> hz;
    for (const ResponseLine& line : lines) hz.push_back(line.hz);
    std::ranges::sort(hz);
    const auto again = std::ranges::unique(hz, [](double a, double b) { return b - a < 1e-3 * a; });
    hz.erase(again.begin(), again.end());
    if (std::ssize(hz) >= 2) return;
    throw InputError{
        fmt::format("{} line{} of {} run{} at {} frequenc{} in accelerometer and reference; a response needs "
                    "lines at 2 or more frequencies",
                    lines.size(), lines.size() == 1 ? "" : "s", runs, runs == 1 ? "" : "s", hz.size(),
                    hz.size() == 1 ? "y" : "ies")};
}

/// Standard error in Hz of a part of the response by the spread of its phi among the models.
template <class Part>
double by_models(Part SensorResponse::*part, const FittedResponse& fit, double hz) {
    const Part& chosen = fit.response.*part;
    double spread = 0;
    for (const TriedResponse& t : fit.tried)
        spread += t.share * std::pow(phi_turned(t.response.*part, hz) - phi_turned(chosen, hz), 2);
    return std::sqrt(spread) / std::abs(phi_turned_by_hz(chosen, hz));
}

template <class Part>
std::string poles_at(const Part& part) {
    const char* kind = part.poles == 1     ? "1 pole"
                       : part.damping == 1 ? "2 equal poles"
                                           : "2 poles (Butterworth)";
    return fmt::format("{} at {:.4g}{} Hz", kind, part.hz,
                       part.error_hz > 0 ? fmt::format(" +- {:.2g}", part.error_hz) : "");
}

}  // namespace

std::string words(const LowerCorner& corner) {
    if (corner.hz != 0) return "lower corner of " + poles_at(corner);
    if (std::isinf(corner.error_hz)) return "a lower corner that is not known";
    return corner.error_hz > 0 ? fmt::format("no lower corner (+- {:.2g} Hz)", corner.error_hz)
                               : "no lower corner";
}

std::string words(const LowPass& pass) {
    if (!pass.none()) return "low-pass of " + poles_at(pass);
    return pass.above_hz > 0
               ? fmt::format(
                     "no low-pass that differs from a delay: one of two poles is above {:.3g} Hz (95 %)",
                     pass.above_hz)
               : "no low-pass";
}

FittedResponse fit_response(std::span<const ResponseLine> lines, bool gravity) {
    int runs = 0;
    double lowest = 1e9, highest = 0;
    for (const ResponseLine& line : lines) {
        runs = std::max(runs, line.run + 1);
        lowest = std::min(lowest, line.hz);
        highest = std::max(highest, line.hz);
    }
    require_lines(lines, runs);
    FittedResponse out;
    std::vector<std::pair<ResponseModel, Solved>> all;
    double scale = INFINITY;  // of chi^2, where no model describes the lines
    for (const ResponseModel& model : response_models(runs, gravity)) {
        const Eigen::Index freedom = 2 * std::ssize(lines) - model.unknowns();
        if (freedom <= 0) continue;
        Solved found = best_response(lines, model);
        if (model.upper && 1 / found.x(model.upper_at()) > unseen * highest) continue;
        scale = std::min(scale, found.chi2 / static_cast<double>(freedom));
        out.tried.push_back({model.at(found.x), found.chi2, static_cast<int>(model.unknowns())});
        all.emplace_back(model, std::move(found));
    }
    if (all.empty())
        throw InputError{fmt::format("{} lines of {} runs: too few for a gain and a delay of each run",
                                     lines.size(), runs)};
    scale = std::max(scale, 1.0);
    std::vector<double> evidence;
    for (const auto& [model, found] : all)
        evidence.push_back(found.chi2 / scale + static_cast<double>(model.unknowns()) *
                                                    std::log(2.0 * static_cast<double>(lines.size())));
    const auto best = all.begin() + (std::ranges::min_element(evidence) - evidence.begin());
    const double least = std::ranges::min(evidence);
    double sum = 0;
    for (std::size_t i = 0; i < evidence.size(); ++i)
        sum += out.tried[i].share = std::exp((least - evidence[i]) / 2);
    for (TriedResponse& t : out.tried) t.share /= sum;

    const auto& [model, found] = *best;
    out.chi2 = found.chi2;
    out.freedom = static_cast<int>(2 * std::ssize(lines) - model.unknowns());
    const double scatter = std::sqrt(std::max(1.0, found.chi2 / std::max(1, out.freedom)));
    const auto error = [&](Eigen::Index k) { return scatter * std::sqrt(found.covariance(k, k)); };
    out.response = model.at(found.x);
    out.log_gain = {found.x(0), error(0)};
    for (int k = 0; k < runs; ++k) out.delay_s.push_back(found.x(1 + k));
    if (LowPass& pass = out.response.upper; model.upper)
        pass.error_hz = std::hypot(error(model.upper_at()) * pass.hz * pass.hz,
                                   by_models(&SensorResponse::upper, out, lowest));
    else
        pass.above_hz = least_low_pass(lines, model, found, scale);
    if (!gravity)
        out.response.lower.error_hz = std::hypot(model.lower ? error(model.lower_at()) : 0,
                                                 by_models(&SensorResponse::lower, out, lowest));
    if (!std::isfinite(out.response.lower.error_hz) || !std::isfinite(out.response.upper.error_hz))
        throw InputError{
            fmt::format("{} lines of {} runs do not determine the response", lines.size(), runs)};
    const Eigen::VectorXd r = off_response(lines, model, found.x, nullptr);
    for (std::size_t i = 0; i < lines.size(); ++i) {
        ResponseLine rest = lines[i];
        const auto k = static_cast<Eigen::Index>(i);
        rest.log_gain.sigma = std::hypot(rest.log_gain.sigma, bias_of_gain);
        rest.lead_rad.sigma = std::hypot(rest.lead_rad.sigma, bias_of_phase);
        rest.log_gain.value = r(k) * rest.log_gain.sigma;
        rest.lead_rad.value = r(std::ssize(lines) + k) * rest.lead_rad.sigma;
        out.rest.push_back(rest);
    }
    return out;
}

}  // namespace shaker::calibration
