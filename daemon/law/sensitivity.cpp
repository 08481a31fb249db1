#include "daemon/law/sensitivity.hpp"

#include <cmath>

namespace shaker::law {

namespace {

using simulated::Contact;
constexpr int push_rounds = 4;  // the push of a push: its share falls by about ten each time

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

Sensitivity::Moved Sensitivity::moved(const Harmonics<Acceleration>& free, const std::array<double, 2>& a_w,
                                      double push) const {
    const auto& segments = cycle_->segments;
    const std::size_t n = segments.size();
    Moved out;
    if (n < 2) return out;         // rest on the base
    std::array<double, 2> slip{};  // change of the slips on the free base
    for (std::size_t i = 0; i < 2; ++i)
        slip[i] = (1 + law_.push) * a_w[i] + push * slip_[i] / (1 + law_.push);
    std::vector<double> v_base(n), at(n), shift(n);
    for (std::size_t i = 0; i < n; ++i) v_base[i] = value(free.a, turns_[i], omega_, 1);
    const double from_0 = offset_after(v_base, slip, 0, nullptr, nullptr);
    const double left = offset_after(v_base, slip, 1, nullptr, nullptr) - from_0;
    offset_after(v_base, slip, from_0 / (1 - left), &at, &shift);
    Harmonics<Acceleration> held;  // change of a_w in stick: Q / (1 + r)
    for (std::size_t i = 0; i < max_harmonics; ++i)
        held.a[i] = (free.a[i] - push * cycle_->free.a[i] / (1 + law_.push)) / (1 + law_.push);
    out.walker = segment_harmonics(segments, a_w, held);
    for (std::size_t i = 0; i < n; ++i) {
        const Segment& s = segments[i];
        const double lasts = (s.to - s.from) / omega_;
        const std::size_t next = (i + 1) % n, before = (i + n - 1) % n;
        if (s.contact == Contact::stick)
            out.v_D += value(free.a, turns_[next], omega_, 2) - value(free.a, turns_[i], omega_, 2);
        else
            out.v_D += at[i] * lasts + slip[side(s.contact)] * lasts * lasts / 2;
        // The jump of a_w at this event moves with it.
        const auto level = [&](std::size_t k) {
            const Contact c = segments[k].contact;
            return (c == Contact::stick ? a_base_[i] : slip_[side(c)]) / (1 + law_.push);
        };
        const double area = (level(before) - level(i)) * shift[i] * omega_ / std::numbers::pi;
        for (std::size_t q = 0; q < max_harmonics; ++q)
            out.walker[q] += std::complex<double>{0, area} * std::conj(turns_[i][q]);
    }
    out.v_D *= omega_ / two_pi;
    return out;
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
        now = moved(free, a_w, change.push);
    }
    return now.v_D;
}

Amplitudes Sensitivity::by_base() const {
    Amplitudes out{};
    for (std::size_t i = 0; i < max_harmonics; ++i) {
        Change real, imaginary;
        real.base.a[i] = 1;
        imaginary.base.a[i] = {0, 1};
        out[i] = {(*this)(real), (*this)(imaginary)};
    }
    return out;
}

}  // namespace shaker::law
