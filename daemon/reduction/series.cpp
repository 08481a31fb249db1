#include "daemon/reduction/series.hpp"

#include <cmath>
#include <numbers>

namespace shaker::reduction {

namespace {

constexpr double same_phase = 1e-6;  // rad: phases closer than this count as equal
// A second harmonic of v_D(phi) of 5 % moves the null by this much for the widest bracket; the effect falls
// with the square of the bracket.
constexpr double bend = 1e-3;  // rad

bool alike(const Drive& a, const Drive& b) {
    return a.frequency == b.frequency && a.gamma == b.gamma && a.rho == b.rho && a.biharmonic() &&
           b.biharmonic();
}

// a - b, wrapped to -pi..pi.
double between(double a, double b) { return std::remainder(a - b, two_pi); }

NullPhase null_between(const DrivenPoint& a, const DrivenPoint& b) {
    const double width = between(b.phi.value, a.phi.value);
    const double rise = b.v_D.value - a.v_D.value;
    const double share = -a.v_D.value / rise;  // share of the way from a to b
    NullPhase null;
    null.phi0.value = std::remainder(a.phi.value + share * width, two_pi);
    const double slope = std::abs(rise / width);
    null.phi0.sigma = std::hypot((1 - share) * a.v_D.sigma / slope, share * b.v_D.sigma / slope,
                                 std::hypot((1 - share) * a.phi.sigma, share * b.phi.sigma,
                                            bend * width * width / (widest_bracket * widest_bracket)));
    null.theta = {null.phi0.value - std::numbers::pi / 2, null.phi0.sigma};
    return null;
}

}  // namespace

bool mirrored(const Drive& a, const Drive& b) {
    return alike(a, b) && std::abs(std::abs(between(a.phi, b.phi)) - std::numbers::pi) <= same_phase;
}

std::optional<MirrorPair> mirror_pair(std::span<const DrivenPoint> points) {
    if (points.empty()) return std::nullopt;
    const DrivenPoint& a = points.back();
    for (std::size_t i = points.size() - 1; i-- > 0;) {
        const DrivenPoint& b = points[i];
        if (!mirrored(a.asked, b.asked)) continue;
        const double sigma = std::hypot(a.v_D.sigma, b.v_D.sigma) / 2;
        return MirrorPair{{(a.v_D.value - b.v_D.value) / 2, sigma}, {(a.v_D.value + b.v_D.value) / 2, sigma}};
    }
    return std::nullopt;
}

std::optional<NullPhase> null_phase(std::span<const DrivenPoint> points) {
    if (points.empty()) return std::nullopt;
    const DrivenPoint& a = points.back();
    const DrivenPoint* nearest = nullptr;
    const auto width = [&](const DrivenPoint& p) { return between(p.phi.value, a.phi.value); };
    if (a.asked.rho != 0.5) return std::nullopt;
    for (const DrivenPoint& b : points.first(points.size() - 1)) {
        if (!alike(a.asked, b.asked) || std::abs(width(b)) > widest_bracket) continue;
        const bool across = (b.v_D.value - a.v_D.value) * width(b) < 0 && a.v_D.value * b.v_D.value <= 0;
        if (across && (nearest == nullptr || std::abs(width(b)) <= std::abs(width(*nearest)))) nearest = &b;
    }
    if (nearest == nullptr) return std::nullopt;
    return null_between(a, *nearest);
}

}  // namespace shaker::reduction
