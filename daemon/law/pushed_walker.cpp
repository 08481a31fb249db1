#include "daemon/law/pushed_walker.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/walker/steady_state.hpp"

namespace shaker::law {

namespace {

using walker::Contact;
using walker::WalkerLaw;

constexpr double same_base = 1e-8;  // of gamma, change of Q
constexpr int most_rounds = 40;

walker::WalkerSetting setting_of(const Harmonics<Acceleration>& free, double frequency, const Coulomb& law) {
    return {.frequency = frequency,
            .base = free,
            .tilt = law.tilt,
            .g = law.g * (1 + law.push),
            .friction = {law.mu, law.mu}};
}

std::vector<Segment> segments_of(const walker::SteadyState& cycle) {
    if (cycle.events.empty()) return {{0, two_pi, cycle.contact0}};
    std::vector<Segment> out;
    for (std::size_t i = 0; i < cycle.events.size(); ++i) {
        const bool last = i + 1 == cycle.events.size();
        const double to = last ? cycle.events.front().phase + 1 : cycle.events[i + 1].phase;
        out.push_back({two_pi * cycle.events[i].phase, two_pi * to, cycle.events[i].to});
    }
    return out;
}

}  // namespace

std::array<double, 2> slip_acceleration(const Coulomb& law) noexcept {
    const double pull = law.g * std::sin(law.tilt), rubs = law.mu * law.g * std::cos(law.tilt);
    return {pull + rubs, pull - rubs};
}

std::vector<std::complex<double>> segment_harmonics(const std::vector<Segment>& segments,
                                                    const std::array<double, 2>& slip,
                                                    const Harmonics<Acceleration>& stick, int last) {
    using namespace std::complex_literals;
    using Complex = std::complex<double>;
    const auto n = static_cast<std::size_t>(last);
    std::vector<Complex> out(n), ends(n + max_harmonics + 1);  // ends: integral of e^{-i k theta}
    for (const Segment& s : segments) {
        const bool sticks = s.contact == Contact::stick;
        const Complex from = std::polar(1.0, -s.from), to = std::polar(1.0, -s.to);
        Complex a = 1, b = 1;
        ends[0] = s.to - s.from;
        for (std::size_t k = 1; k <= (sticks ? n + max_harmonics : n); ++k) {
            a *= from;
            b *= to;
            ends[k] = (a - b) * Complex{0, -1.0 / static_cast<double>(k)};
        }
        for (std::size_t q = 1; q <= n; ++q) {
            if (!sticks) out[q - 1] += slip[s.contact == Contact::forward ? 1 : 0] * ends[q];
            for (std::size_t p = 1; sticks && p <= max_harmonics; ++p) {  // (A e^{ip theta} - conjugate) / 2i
                const Complex A = stick.a[p - 1];
                const Complex difference = p >= q ? std::conj(ends[p - q]) : ends[q - p];
                if (A != 0.0) out[q - 1] += (A * difference - std::conj(A) * ends[p + q]) * -0.5i;
            }
        }
    }
    for (Complex& a : out) a *= 1i / std::numbers::pi;
    return out;
}

Amplitudes segment_harmonics(const std::vector<Segment>& segments, const std::array<double, 2>& slip,
                             const Harmonics<Acceleration>& stick) {
    Amplitudes out{};
    std::ranges::copy(segment_harmonics(segments, slip, stick, max_harmonics), out.begin());
    return out;
}

PushedCycle pushed_cycle(const Harmonics<Acceleration>& measured, double frequency, const Coulomb& law,
                         const PushedCycle* start) {
    PushedCycle out;
    double gamma = 0;
    for (const auto& a : measured.a) gamma += std::abs(a);
    out.free = measured;
    if (start != nullptr) {
        out.v0 = start->v0;
        for (std::size_t i = 0; i < max_harmonics; ++i) out.free.a[i] += law.push * start->walker[i];
    }
    for (int round = 0; round < most_rounds; ++round) {
        const WalkerLaw walker{setting_of(out.free, frequency, law)};
        const walker::SteadyState cycle = settle_quickly(walker, out.v0);
        ++out.settles;
        out.v_D = cycle.D * frequency;
        out.v0 = cycle.v0;
        out.segments = segments_of(cycle);
        Harmonics<Acceleration> held = out.free;
        for (auto& a : held.a) a /= 1 + law.push;
        out.walker = segment_harmonics(out.segments, slip_acceleration(law), held);
        double change = 0;
        for (std::size_t i = 0; i < max_harmonics; ++i) {
            const std::complex<double> next = measured.a[i] + law.push * out.walker[i];
            change = std::max(change, std::abs(next - out.free.a[i]));
            out.free.a[i] = next;
        }
        if (change <= same_base * gamma) break;
    }
    return out;
}

}  // namespace shaker::law
