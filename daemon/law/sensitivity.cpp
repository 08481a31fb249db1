#include "daemon/law/sensitivity.hpp"

#include <cmath>

namespace shaker::law {

namespace {

using walker::Contact;
constexpr int last_of_tail = 96;       // the terms fall as q^-3
constexpr int push_rounds = 12;        // at most; the push of a push falls by three to ten each time
constexpr double push_settled = 1e-5;  // of the result

std::size_t side(Contact contact) { return contact == Contact::forward ? 1 : 0; }

// Im sum a_q e^{i q theta} / (i q omega)^power.
double value(const Amplitudes& a, const Amplitudes& turns, double omega, int power) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        const double w = omega * static_cast<double>(i + 1);
        const std::complex<double> term = a[i] * turns[i];
        sum += power == 0 ? term.imag() : power == 1 ? -term.real() / w : -term.imag() / (w * w);
    }
    return sum;
}

}  // namespace

Sensitivity::Sensitivity(const PushedCycle& cycle, double frequency, const Coulomb& law)
    : cycle_{&cycle}, omega_{two_pi * frequency}, law_{law}, slip_{slip_acceleration(law)} {
    for (double& a : slip_) a *= 1 + law.push;
    for (const Segment& s : cycle.segments) {
        Amplitudes powers{};
        const std::complex<double> z = std::polar(1.0, s.from);
        std::complex<double> power = 1;
        for (auto& p : powers) p = power *= z;
        turns_.push_back(powers);
        a_base_.push_back(value(cycle.free.a, powers, omega_, 0));
    }
}

// The offset of v at the start of segment 0 one period later, from its offset there now. at: offset at the
// start of each segment; shift: of each event, s.
double Sensitivity::offset_after(const std::vector<double>& v_base, const std::array<double, 2>& slip,
                                 double offset, std::vector<double>* at, std::vector<double>* shift) const {
    const auto& segments = cycle_->segments;
    for (std::size_t i = 0; i < segments.size(); ++i) {
        if (at != nullptr) (*at)[i] = offset;
        const Segment& s = segments[i];
        const std::size_t next = (i + 1) % segments.size();
        const Contact then = segments[next].contact;
        if (s.contact == Contact::stick) {  // released where v and its slope are those of the base
            offset = v_base[next];
            if (shift != nullptr) (*shift)[next] = 0;
            continue;
        }
        const double before = slip_[side(s.contact)];
        offset += slip[side(s.contact)] * (s.to - s.from) / omega_;
        const double late = (v_base[next] - offset) / (before - a_base_[next]);
        if (shift != nullptr) (*shift)[next] = late;
        offset = then == Contact::stick ? v_base[next] : offset + (before - slip_[side(then)]) * late;
    }
    return offset;
}

// Change of v_D from changes of v_B and x_B at the events and of the slips. shift: of each event, s.
double Sensitivity::drift_of(const std::vector<double>& v_base, const std::vector<double>& x_base,
                             const std::array<double, 2>& slip, std::vector<double>* shift) const {
    const auto& segments = cycle_->segments;
    const std::size_t n = segments.size();
    std::vector<double> at(n);
    const double from_0 = offset_after(v_base, slip, 0, nullptr, nullptr);
    const double left = offset_after(v_base, slip, 1, nullptr, nullptr) - from_0;
    offset_after(v_base, slip, from_0 / (1 - left), &at, shift);
    double way = 0;
    for (std::size_t i = 0; i < n; ++i) {
        const double lasts = (segments[i].to - segments[i].from) / omega_;
        if (segments[i].contact == Contact::stick)
            way += x_base[(i + 1) % n] - x_base[i];
        else
            way += at[i] * lasts + slip[side(segments[i].contact)] * lasts * lasts / 2;
    }
    return way * omega_ / two_pi;
}

Sensitivity::Moved Sensitivity::moved(const Harmonics<Acceleration>& free, const std::array<double, 2>& a_w,
                                      double push) const {
    const auto& segments = cycle_->segments;
    const std::size_t n = segments.size();
    Moved out;
    if (n < 2) return out;         // rest on the base
    std::array<double, 2> slip{};  // change of the slips on the free base
    for (std::size_t i = 0; i < 2; ++i)
        slip[i] = (1 + law_.push) * a_w[i] + push * slip_[i] / (1 + law_.push);
    std::vector<double> v_base(n), x_base(n), shift(n);
    for (std::size_t i = 0; i < n; ++i) {
        v_base[i] = value(free.a, turns_[i], omega_, 1);
        x_base[i] = value(free.a, turns_[i], omega_, 2);
    }
    out.v_D = drift_of(v_base, x_base, slip, &shift);
    if (law_.push == 0) return out;
    Harmonics<Acceleration> held;  // change of a_w in stick: Q / (1 + r)
    for (std::size_t i = 0; i < max_harmonics; ++i)
        held.a[i] = (free.a[i] - push * cycle_->free.a[i] / (1 + law_.push)) / (1 + law_.push);
    out.walker = segment_harmonics(segments, a_w, held);
    for (std::size_t i = 0; i < n; ++i) {  // the jump of a_w at an event moves with it
        const auto level = [&](std::size_t k) {
            const Contact c = segments[k].contact;
            return (c == Contact::stick ? a_base_[i] : slip_[side(c)]) / (1 + law_.push);
        };
        const double area = (level((i + n - 1) % n) - level(i)) * shift[i] * omega_ / std::numbers::pi;
        for (std::size_t q = 0; q < max_harmonics; ++q)
            out.walker[q] += std::complex<double>{0, area} * std::conj(turns_[i][q]);
    }
    return out;
}

double Sensitivity::by_drag() const {
    const auto& segments = cycle_->segments;
    const std::size_t n = segments.size();
    if (n < 2) return 0;
    Harmonics<Acceleration> held = cycle_->free;
    for (auto& a : held.a) a /= 1 + law_.push;
    std::vector<double> v_base(n), x_base(n);
    const auto walker = segment_harmonics(segments, slip_acceleration(law_), held, last_of_tail);
    for (std::size_t i = 0; i < n; ++i) {
        const std::complex<double> z = std::polar(1.0, segments[i].from);
        std::complex<double> power = turns_[i].back();
        for (int q = max_harmonics + 1; q <= last_of_tail; ++q) {
            power *= z;
            const double w = q * omega_;
            const std::complex<double> term =
                std::complex<double>{0, -1.0 / q} * walker[static_cast<std::size_t>(q - 1)] * power;
            v_base[i] -= term.real() / w;
            x_base[i] -= term.imag() / (w * w);
        }
    }
    return drift_of(v_base, x_base, {}, nullptr);
}

double Sensitivity::operator()(const Change& change) const {
    const double sine = std::sin(law_.tilt), cosine = std::cos(law_.tilt);
    std::array<double, 2> a_w{};  // change of the walker's acceleration in backward and forward slip
    for (std::size_t i = 0; i < 2; ++i) {
        const double sign = i == 0 ? 1 : -1;
        a_w[i] = change.gravity * (sine + sign * law_.mu * cosine) + sign * change.mu * law_.g * cosine +
                 change.tilt * law_.g * (cosine - sign * law_.mu * sine);
    }
    Harmonics<Acceleration> free = change.base;
    Moved now = moved(free, a_w, change.push);
    for (int round = 0; round < push_rounds && law_.push != 0; ++round) {
        for (std::size_t i = 0; i < max_harmonics; ++i)
            free.a[i] = change.base.a[i] + change.push * cycle_->walker[i] + law_.push * now.walker[i];
        const double before = now.v_D;
        now = moved(free, a_w, change.push);
        if (std::abs(now.v_D - before) <= push_settled * std::abs(now.v_D)) break;
    }
    return now.v_D;
}

Amplitudes Sensitivity::by_base() const {
    Amplitudes out{};
    const std::size_t n = cycle_->segments.size();
    if (n < 2) return out;
    std::vector<double> v_base(n), x_base(n);
    for (std::size_t q = 0; q < max_harmonics; ++q) {
        const double w = omega_ * static_cast<double>(q + 1);
        std::array<double, 2> parts{};
        for (std::size_t part = 0; part < 2; ++part) {
            for (std::size_t i = 0; i < n; ++i) {
                const std::complex<double> term =
                    turns_[i][q] * (part == 0 ? std::complex<double>{1, 0} : std::complex<double>{0, 1});
                v_base[i] = -term.real() / w;
                x_base[i] = -term.imag() / (w * w);
            }
            parts[part] = drift_of(v_base, x_base, {}, nullptr);
        }
        out[q] = {parts[0], parts[1]};
    }
    return out;
}

}  // namespace shaker::law
