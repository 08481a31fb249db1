#include "daemon/reduction/timeline.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

namespace shaker::reduction {
namespace {

MotionMatrix unknown() { return Eigen::Vector4d{1e8, 1e8, 1e6, 0}.asDiagonal(); }

MotionState start(std::span<const Node> nodes) {
    const auto first = std::ranges::find_if(nodes, &Node::seen);
    return {first == nodes.end() ? 0 : first->x, 0, 0, 0};
}

}  // namespace

Timeline::Timeline(const BaseCycle& base, Scales scales, double jump, double blur, const Looseness& loose)
    : base_{base},
      period_{base.period_s() / scales.t_s},
      scales_{scales},
      jump_{jump},
      blur_{blur},
      loose_{loose} {}

// Stretches from phase `from` on. intensity: outside the zones.
std::vector<Stretch> Timeline::stretches(std::span<const Zone> zones, double intensity, double from,
                                         double to) const {
    std::vector<Stretch> out;
    bool rests = !zones.empty() && zones.back().rests_after;
    double reached = from;
    for (double turn = std::floor(from) - 1; turn <= to; ++turn) {
        for (const Zone& z : zones) {
            const double begin = z.middle - z.length / 2 + turn, end = begin + z.length;
            if (begin > to) break;
            if (end >= from) {
                const double length = z.length * period_;
                const bool sharp = length < 1e-3;
                reached = std::max(reached, begin);
                out.push_back({reached, intensity, sharp ? jump_ * jump_ : 0, 0, rests});
                if (!sharp && end > reached) {
                    const double change = jump_ / length;
                    out.push_back({end, shape * shape * jump_ * change, 0, change * change, false});
                    reached = end;
                }
            }
            rests = z.rests_after;
        }
    }
    out.push_back({std::numeric_limits<double>::infinity(), intensity, 0, 0, rests});
    return out;
}

// Carries mean and covariance from phase `from` to `to`; `at`: the stretch of `from`, moved on. Returns what
// it makes of a small change of the state.
MotionMatrix Timeline::advance(MotionState& m, MotionMatrix& P, double from, double to,
                               std::vector<Stretch>::const_iterator& at) const {
    MotionMatrix all = MotionMatrix::Identity();
    for (;;) {
        const double end = std::min(to, at->to);
        if (end > from) all = step(m, P, from, end, *at) * all;
        from = std::max(from, end);
        if (at->to > to) return all;
        P(2, 2) += at->jump;
        m(3) = 0;  // the jerk of a zone is its own
        P.row(3).setZero();
        P.col(3).setZero();
        all.row(3).setZero();
        ++at;
        P(3, 3) = at->jerk;
    }
}

// Takes a position in. Returns its -2 ln likelihood.
double Timeline::observe(MotionState& m, MotionMatrix& P, const Node& n) const {
    const Eigen::RowVector4d H{1, 0, blur_, 0};
    const MotionState PH = P * H.transpose();
    const double S = H * PH + n.variance, off = n.x - H * m;
    m += PH * (off / S);
    P -= PH * PH.transpose() / S;
    return off * off / S + std::log(S);
}

double Timeline::misfit(std::span<const Node> nodes, std::span<const Zone> zones, double intensity) const {
    const auto all = stretches(zones, intensity, nodes.front().p, nodes.back().p);
    auto at = all.begin();
    MotionState m = start(nodes);
    MotionMatrix P = unknown();
    double sum = 0, p = nodes.front().p;
    for (const Node& n : nodes) {
        if (!n.seen) continue;
        advance(m, P, p, n.p, at);
        p = n.p;
        sum += observe(m, P, n);
    }
    return sum;
}

void Timeline::smooth(std::span<const Node> nodes, std::span<const Zone> zones, double intensity,
                      std::vector<double>& first, std::vector<double>& second) const {
    const std::size_t n = nodes.size();
    std::vector<MotionState> m(n), m_before(n);
    std::vector<MotionMatrix> P(n), P_before(n), F(n);
    const auto all = stretches(zones, intensity, nodes.front().p, nodes.back().p);
    auto at = all.begin();
    MotionState mean = start(nodes);
    MotionMatrix covariance = unknown();
    double p = nodes.front().p;
    for (std::size_t i = 0; i < n; ++i) {
        F[i] = advance(mean, covariance, p, nodes[i].p, at);
        p = nodes[i].p;
        m_before[i] = mean;
        P_before[i] = covariance;
        if (nodes[i].seen) observe(mean, covariance, nodes[i]);
        m[i] = mean;
        P[i] = covariance;
    }
    for (std::size_t i = n; i-- > 0;) {
        if (i + 1 < n) {
            MotionMatrix before = P_before[i + 1];
            if (before(3, 3) == 0) before(3, 3) = 1;  // no jerk outside the zones
            const MotionMatrix G = before.ldlt().solve(F[i + 1] * P[i]).transpose();
            m[i] += G * (m[i + 1] - m_before[i + 1]);
            P[i] += G * (P[i + 1] - P_before[i + 1]) * G.transpose();
        }
        if (nodes[i].wanted < 0) continue;
        const auto k = static_cast<std::size_t>(nodes[i].wanted);
        first[k] += m[i](1);
        second[k] += m[i](1) * m[i](1) + P[i](1, 1);
    }
}

MotionMatrix Timeline::step(MotionState& m, MotionMatrix& P, double from, double to, const Stretch& s) const {
    const double h = (to - from) * period_, middle = (from + to) / 2;
    const auto n = static_cast<double>(loose_.share.size());
    const auto at =
        std::min(static_cast<std::size_t>((middle - std::floor(middle)) * n), loose_.share.size() - 1);
    const double q = s.intensity * (s.jerk > 0 ? 1 : loose_.share[at]) + loose_.more[at];
    MotionMatrix F = MotionMatrix::Identity();
    F(0, 1) = F(1, 2) = F(2, 3) = h;
    F(0, 2) = F(1, 3) = h * h / 2;
    F(0, 3) = h * h * h / 6;
    m = F * m;
    P = F * P * F.transpose();
    const double h2 = h * h, h3 = h2 * h;
    P(0, 0) += q * h3 * h2 / 20;
    P(0, 1) += q * h2 * h2 / 8;
    P(1, 0) += q * h2 * h2 / 8;
    P(0, 2) += q * h3 / 6;
    P(2, 0) += q * h3 / 6;
    P(1, 1) += q * h3 / 3;
    P(1, 2) += q * h2 / 2;
    P(2, 1) += q * h2 / 2;
    P(2, 2) += q * h;
    if (!s.rests) return F;
    const double t = scales_.t_s, x = scales_.x_m, a = base_.a(from) * t * t / x, v = base_.v(from) * t / x;
    m(0) += (base_.x(to) - base_.x(from)) / x - v * h - a * h * h / 2;
    m(1) += base_.v(to) * t / x - v - a * h;
    m(2) += base_.a(to) * t * t / x - a;
    return F;
}

}  // namespace shaker::reduction
