#include "daemon/reduction/stick.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace shaker::reduction {
namespace {

struct Region {
    double from, to;  // phase; `to` may exceed 1
};

/// Intervals of the cycle in which the relative velocity is near zero or changes its sign.
std::vector<Region> near_rest(const Cycle& c) {
    const std::size_t n = c.phase.size();
    double largest = 0;
    for (const double v : c.v_base_mps) largest = std::max(largest, std::abs(v));
    std::vector<double> relative;
    std::vector<bool> near;
    for (std::size_t i = 0; i < n; ++i) {
        relative.push_back(c.v_mps[i] - c.v_base_mps[i]);
        near.push_back(std::abs(relative[i]) < std::max(3 * c.v_sd_mps[i], 0.02 * largest));
    }
    for (std::size_t i = 0; i < n; ++i) {
        const std::size_t next = (i + 1) % n;
        if (relative[i] * relative[next] < 0) near[i] = near[next] = true;
    }
    std::vector<Region> out;
    const auto away = std::find(near.begin(), near.end(), false);
    if (away == near.end()) return {};
    const auto offset = static_cast<std::size_t>(away - near.begin());
    for (std::size_t j = 0; j < n; ++j) {
        const std::size_t i = (offset + j) % n;
        if (!near[i]) continue;
        const double p = c.phase[i] + (i < offset ? 1 : 0);
        const bool joins = near[(i + n - 1) % n] && !out.empty();
        if (joins) {
            out.back().to = p;
        } else {
            out.push_back({p, p});
        }
    }
    return out;
}

/// True if the walker follows the base during the whole period: the relative velocity is noise, and the noise
/// is much smaller than the base's motion.
bool rests_always(const Cycle& c) {
    double largest = 0, squares = 0, noise = 0;
    for (const double v : c.v_base_mps) largest = std::max(largest, std::abs(v));
    for (std::size_t i = 0; i < c.phase.size(); ++i) {
        const double sd = std::max(c.v_sd_mps[i], 0.005 * largest);
        squares += std::pow((c.v_mps[i] - c.v_base_mps[i]) / sd, 2);
        noise = std::max(noise, sd);
    }
    return squares < 2 * static_cast<double>(c.phase.size()) && noise < 0.1 * largest;
}

struct Point {
    double p;       // phase, unwrapped
    double x;       // walker, drift included, m
    double base_x;  // m
    double weight;
};

/// The folded positions between two phases, merged in bins much narrower than a frame.
std::vector<Point> points_between(std::span<const Folded> folded, const BaseCycle& base, double v_D,
                                  Region r) {
    constexpr double bin = 1 / 500.0;
    std::vector<Point> out;
    double begin = -1e300;
    for (double turn = std::floor(r.from); turn <= std::floor(r.to); ++turn) {
        for (const Folded& s : folded) {
            const double p = s.phase + turn, w = 1 / (s.sd_m * s.sd_m);
            if (p < r.from || p > r.to) continue;
            if (p - begin > bin) {
                begin = p;
                out.push_back({0, 0, 0, 0});
            }
            Point& b = out.back();
            b.weight += w;
            b.p += (p - b.p) * w / b.weight;
            b.x += (s.x_m + v_D * p * base.period_s() - b.x) * w / b.weight;
        }
    }
    for (Point& b : out) b.base_x = base.x(b.p);
    return out;
}

struct SlipFit {
    double chi2 = std::numeric_limits<double>::infinity();
    double before = 0, after = 0;  // accelerations, m/s^2
};

/// Weighted sums over the points of a slip; y: distance from uniform motion with the base's velocity at its
/// end.
struct SlipSums {
    std::size_t from = 0, to = 0;  // indices of the points
    double weight = 0, y = 0, squares = 0;
    double with_one = 0, with_itself = 0, with_y = 0;  // of t^2/2, t from the end
};

/// Weighted sums over the points from the first on; y: distance from the base.
struct StickSums {
    double weight = 0, y = 0, squares = 0;
};

class StickModel {
public:
    StickModel(std::vector<Point> points, const BaseCycle& base) : points_(std::move(points)), base_(base) {
        StickSums sum;
        sums_.push_back(sum);
        for (const Point& b : points_) {
            const double y = b.x - b.base_x;
            sum.weight += b.weight;
            sum.y += b.weight * y;
            sum.squares += b.weight * y * y;
            sums_.push_back(sum);
        }
    }

    [[nodiscard]] int freedom() const { return static_cast<int>(points_.size()) - 5; }
    /// The points before a stick that begins at `from`.
    [[nodiscard]] SlipSums before(double from) const {
        return slip(from, 0, index(std::ranges::lower_bound(points_, from, {}, &Point::p)));
    }
    /// The points after a stick that ends at `to`.
    [[nodiscard]] SlipSums after(double to) const {
        return slip(to, index(std::ranges::upper_bound(points_, to, {}, &Point::p)), points_.size());
    }
    /// A constant distance from the base within the stick, the same at the ends of both slips.
    [[nodiscard]] SlipFit fit(const SlipSums& early, const SlipSums& late) const {
        if (!(early.with_itself > 0) || !(late.with_itself > 0)) return {};
        const StickSums &first = sums_[early.to], &last = sums_[late.from];
        const double early_share = early.with_one / early.with_itself,
                     late_share = late.with_one / late.with_itself;
        const double weight = early.weight + (last.weight - first.weight) + late.weight,
                     y = early.y + (last.y - first.y) + late.y;
        const double own = weight - early_share * early.with_one - late_share * late.with_one,
                     right = y - early_share * early.with_y - late_share * late.with_y;
        const double distance = own > 1e-12 * weight ? right / own : 0;
        const double a = (early.with_y - early.with_one * distance) / early.with_itself,
                     b = (late.with_y - late.with_one * distance) / late.with_itself;
        const double squares = early.squares + (last.squares - first.squares) + late.squares;
        return {std::max(squares - distance * y - a * early.with_y - b * late.with_y, 0.0), a, b};
    }

    /// The same phases and errors, with the positions of a walker that slips with the accelerations of
    /// `slips`, sticks from `from` to `to` and is seen without noise.
    [[nodiscard]] StickModel with_stick(double from, double to, const SlipFit& slips) const {
        std::vector<Point> points = points_;
        const double T = base_.period_s();
        const double x1 = base_.x(from), v1 = base_.v(from), x2 = base_.x(to), v2 = base_.v(to);
        for (Point& b : points) {
            b.x = b.base_x;
            if (b.p >= from && b.p <= to) continue;
            const bool early = b.p < from;
            const double t = (b.p - (early ? from : to)) * T;
            b.x =
                (early ? x1 : x2) + (early ? v1 : v2) * t + (early ? slips.before : slips.after) * t * t / 2;
        }
        return {std::move(points), base_};
    }

private:
    [[nodiscard]] std::size_t index(std::vector<Point>::const_iterator at) const {
        return static_cast<std::size_t>(at - points_.begin());
    }
    [[nodiscard]] SlipSums slip(double end, std::size_t from, std::size_t to) const {
        SlipSums out{.from = from, .to = to};
        const double T = base_.period_s(), x = base_.x(end), v = base_.v(end);
        for (std::size_t i = from; i < to; ++i) {
            const Point& b = points_[i];
            const double t = (b.p - end) * T, y = b.x - x - v * t, half = t * t / 2;
            const double weighted = b.weight * y, share = b.weight * half;
            out.weight += b.weight;
            out.y += weighted;
            out.squares += weighted * y;
            out.with_one += share;
            out.with_itself += share * half;
            out.with_y += share * y;
        }
        return out;
    }

    std::vector<Point> points_;    // by phase
    std::vector<StickSums> sums_;  // of the points before each one, and of all
    const BaseCycle& base_;
};

struct Best {
    double from = 0, to = 0;
    SlipFit fit;
};

/// Least chi^2 over from and to: grid around a start, then refined. crossing: from = to.
Best search(const StickModel& model, Region from, Region to, bool crossing) {
    Best best;
    constexpr int steps = 24;
    double step_from = 0, step_to = 0;
    for (int level = 0; level < 5; ++level) {
        step_from = (from.to - from.from) / steps;
        step_to = (to.to - to.from) / steps;
        std::array<SlipSums, steps + 1> late;
        if (!crossing)
            for (int j = 0; j <= steps; ++j)
                late[static_cast<std::size_t>(j)] = model.after(to.from + j * step_to);
        for (int i = 0; i <= steps; ++i) {
            const double a = from.from + i * step_from;
            const SlipSums early = model.before(a);
            for (int j = 0; j <= (crossing ? 0 : steps); ++j) {
                const double b = crossing ? a : to.from + j * step_to;
                if (b < a) continue;
                const SlipFit fit =
                    model.fit(early, crossing ? model.after(a) : late[static_cast<std::size_t>(j)]);
                if (fit.chi2 < best.fit.chi2) best = {a, b, fit};
            }
        }
        from = {best.from - 2 * step_from, best.from + 2 * step_from};
        to = {best.to - 2 * step_to, best.to + 2 * step_to};
    }
    return best;
}

/// Change of either end (the other end free) that raises chi^2 by `unit`; the larger of both.
double end_sd(const StickModel& model, const Best& best, double unit, double reach) {
    double sd = 0;
    for (double d = 1e-3 * reach; d <= reach; d *= 1.25) {
        double least = std::numeric_limits<double>::infinity();
        const auto least_of = [&](double from, const SlipSums& early, double to, const SlipSums& late) {
            if (from <= to) least = std::min(least, model.fit(early, late).chi2);
        };
        const std::array from{best.from - d, best.from + d}, to{best.to - d, best.to + d};
        const std::array early{model.before(from[0]), model.before(from[1])};
        const std::array late{model.after(to[0]), model.after(to[1])};
        for (int k = -8; k <= 8; ++k) {
            const double follow = d * k / 4;
            const double other_from = best.from + follow, other_to = best.to + follow;
            const SlipSums other_early = model.before(other_from), other_late = model.after(other_to);
            for (std::size_t side = 0; side < 2; ++side) {
                least_of(from[side], early[side], other_to, other_late);
                least_of(other_from, other_early, to[side], late[side]);
            }
        }
        sd = d;
        if (least > best.fit.chi2 + unit) break;
    }
    return sd;
}

/// True if friction can hold the base's acceleration within the stick: it is not larger than that of the
/// slips.
bool holdable(const BaseCycle& base, const Best& b) {
    const double limit = 1.3 * std::max(std::abs(b.fit.before), std::abs(b.fit.after));
    for (int i = 1; i < 10; ++i) {
        if (std::abs(base.a(b.from + (b.to - b.from) * i / 10)) > limit) return false;
    }
    return true;
}

/// Length of a stick about a crossing that is seen 19 times of 20; `unit`: residual chi^2.
double shortest_visible(const StickModel& model, const Best& crossing, Region range, double unit) {
    constexpr double seen = 37.5;  // (sqrt(20) + 1.65)^2
    const double middle = crossing.from;
    double hidden = 0, visible = 1;
    for (int i = 0; i < 10; ++i) {
        const double length = (hidden + visible) / 2;
        const StickModel stuck = model.with_stick(middle - length / 2, middle + length / 2, crossing.fit);
        const Region wide{std::min(range.from, middle - length / 2), std::max(range.to, middle + length / 2)};
        (search(stuck, wide, wide, true).fit.chi2 > seen * unit ? visible : hidden) = length;
    }
    return visible;
}

}  // namespace

Sticks find_sticks(std::span<const Folded> folded, const Cycle& cycle, const BaseCycle& base,
                   const calibration::Estimate& v_D, double frames_per_period) {
    if (rests_always(cycle)) {
        const bool moves = std::abs(v_D.value) > 3 * v_D.sigma;
        if (moves) return {.found = {}, .shortest_visible = 1, .kinks = {}};
        return {
            .found = {{0, 1, 0.5 / frames_per_period}}, .shortest_visible = NAN, .kinks = {{0, 0, 0, true}}};
    }
    const auto regions = near_rest(cycle);
    Sticks out;
    double& least = out.shortest_visible;
    const double frame = 1 / frames_per_period;
    const auto kink = [&](double at, double reach, double longest, bool rests_after) {
        out.kinks.push_back({at - std::floor(at), reach, longest, rests_after});
    };
    const std::size_t n = regions.size();
    for (std::size_t i = 0; i < n; ++i) {
        const Region& here = regions[i];
        const double before = i > 0 ? regions[i - 1].to : regions[n - 1].to - 1;
        const double after = i + 1 < n ? regions[i + 1].from : regions[0].from + 1;
        // A slip ends where the next interval begins. Only a part of it is used, since friction may depend on
        // speed.
        constexpr double slip = 0.25, slack = 0.05;
        const double usual = std::max(0.08, 3 * frame),
                     longest = std::max(usual, here.to - here.from + 2 * frame);
        const Region window{std::max(before, here.from - slip), std::min(after, here.to + slip)};
        const StickModel model(points_between(folded, base, v_D.value, window), base);
        if (model.freedom() < 3) {
            least = 1;
            kink((here.from + here.to) / 2, (here.to - here.from) / 2 + frame, longest, false);
            continue;
        }
        const Region range{std::max(window.from, here.from - slack), std::min(window.to, here.to + slack)};
        const Best crossing = search(model, range, range, true), stick = search(model, range, range, false);
        const double unit = std::max(stick.fit.chi2 / model.freedom(), 1e-6);
        const double sd = end_sd(model, stick, unit, slack);
        const bool found = crossing.fit.chi2 - stick.fit.chi2 > 20 * unit && stick.to - stick.from > 2 * sd;
        if (found && holdable(base, stick)) {
            const double turn = std::floor(stick.from);
            out.found.push_back({stick.from - turn, stick.to - turn, std::max(sd, 0.5 * frame)});
            kink(stick.from, 2 * out.found.back().sd, usual, true);
            kink(stick.to, 2 * out.found.back().sd, usual, false);
            continue;
        }
        kink(crossing.from, 1.5 * frame, longest, false);
        least = std::fmax(least, std::max(shortest_visible(model, crossing, range, unit), frame));
    }
    std::ranges::sort(out.found, {}, &StickInterval::from);
    std::ranges::sort(out.kinks, {}, &Kink::phase);
    return out;
}

}  // namespace shaker::reduction
