#include "tests/support/control/control_bench.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <random>

#include "drivers/simulated/sensor.hpp"

namespace shaker::test {

namespace {

constexpr int controlled = control::controlled_harmonics;
constexpr std::size_t block = 240;  // DAC samples

// True motion of the base: harmonics of one period of the drive.
class Truth {
public:
    void add(double turns, double a) {
        const auto period = static_cast<std::int64_t>(std::floor(turns));
        if (period != period_) {
            if (n_ > 0) {
                for (auto& h : sum_.a) h /= 0.5 * n_;
                periods.push_back(sum_);
            }
            period_ = period;
            sum_ = {};
            n_ = 0;
        }
        const std::complex<double> z = std::polar(1.0, -two_pi * (turns - std::floor(turns)));
        std::complex<double> power = a * std::complex<double>{0, 1};
        for (auto& h : sum_.a) h += power *= z;
        ++n_;
    }
    std::vector<Harmonics<Acceleration>> periods;

private:
    std::int64_t period_ = -1;
    Harmonics<Acceleration> sum_;
    int n_ = 0;
};

class Bench {
public:
    Bench(const ControlCase& c, std::uint64_t seed)
        : case_{c},
          scene_{seeded(c.scene, seed)},
          plant_{scene_},
          sensor_{scene_},
          synthesiser_{scene_.dac_rate_hz, c.drive.frequency, 1e3},
          windows_{scene_.dac_rate_hz, info(), c.drive.frequency, controlled, c.mains_hz},
          timebase_{
              {.dac_rate_hz = scene_.dac_rate_hz, .accelerometer_rate_hz = info().rate_hz, .cameras = {}}},
          volts_(block) {}

    using Each = std::function<void(const control::PeriodWindows::Window&)>;
    void play(const Harmonics<Voltage>& volts, double frequency, int ramp, int delay) {
        const auto at = synthesiser_.tick().n +
                        static_cast<std::int64_t>(delay * scene_.dac_rate_hz / case_.drive.frequency);
        waiting_.push_back({at, {volts, frequency, ramp, ++sequence_}});
    }
    [[nodiscard]] std::uint64_t sequence() const { return sequence_; }
    [[nodiscard]] simulated::ShakerPlant& plant() { return plant_; }
    Truth truth;
    double sensor_sign = 1;

    void step(const Each& each) {
        for (; !waiting_.empty() && waiting_.front().at <= synthesiser_.tick().n; waiting_.pop_front())
            synthesiser_.set(waiting_.front().command);
        const std::int64_t first = synthesiser_.tick().n;
        synthesiser_.fill(volts_);
        if (const DriveChange* change = synthesiser_.change()) windows_.add(*change);
        for (std::size_t i = 0; i < block; ++i) {
            const std::int64_t n = first + static_cast<std::int64_t>(i);
            plant_.step(converted(volts_[i]));
            truth.add(windows_.history().turns(static_cast<double>(n + 1) / scene_.dac_rate_hz),
                      plant_.state().a);
            if (auto accel = sensor_.step(n + 1, sensor_sign * plant_.state().a)) take(*accel, each);
        }
        timebase_.add(
            PlayTime{synthesiser_.tick(),
                     simulated::host_time(static_cast<double>(synthesiser_.tick().n) / scene_.dac_rate_hz)});
    }

private:
    void take(const AccelBlock& samples, const Each& each) {
        timebase_.add(samples);
        for (const auto& w : windows_.add(samples, timebase_)) each(w);
    }
    struct Waiting {
        std::int64_t at;
        DriveCommand command;
    };
    static simulated::Scene seeded(simulated::Scene s, std::uint64_t seed) {
        s.seed = seed;
        return s;
    }
    double converted(double volts) {
        if (case_.dac_bits > 0) {
            const double lsb = std::ldexp(1.0, 1 - case_.dac_bits);
            volts = lsb * std::round(volts / lsb + dither_(rng_) - dither_(rng_));
        }
        return std::clamp(volts, -1.0, 1.0);
    }
    [[nodiscard]] AccelerometerInfo info() const {
        AccelerometerInfo i = sensor_.info();
        const double yaw = scene_.accelerometer.yaw_deg * two_pi / 360;
        i.shaker_axis = {std::cos(yaw), -std::sin(yaw), 0};
        return i;
    }
    const ControlCase& case_;
    simulated::Scene scene_;
    simulated::ShakerPlant plant_;
    simulated::AccelerometerModel sensor_;
    Synthesiser synthesiser_;
    control::PeriodWindows windows_;
    calibration::Timebase timebase_;
    std::vector<double> volts_;
    std::deque<Waiting> waiting_;
    std::uint64_t sequence_ = 0;
    std::mt19937_64 rng_{99};
    std::uniform_real_distribution<double> dither_{0, 1};
};

double decibel(double share) { return 20 * std::log10(std::max(share, 1e-9)); }

// Errors of a mean of periods against the target, after the time shift with the best fit.
struct Misfit {
    std::array<double, controlled> share{};  // of gamma
    double amplitude = 0, phi = 0;           // of harmonics 1 and 2 in shares of gamma; rad
};
Misfit misfit(const Harmonics<Acceleration>& mean, const Drive& drive, double reached) {
    Drive wanted = drive;
    wanted.gamma *= reached;
    const Harmonics<Acceleration> target = harmonics(wanted);
    const Harmonics<Acceleration> fit = control::turned(target, control::best_lag(target, mean));
    Misfit m;
    for (int q = 1; q <= controlled; ++q)
        m.share[static_cast<std::size_t>(q - 1)] = std::abs(mean.at(q) - fit.at(q)) / wanted.gamma;
    for (int q = 1; q <= 2; ++q)
        m.amplitude =
            std::max(m.amplitude, std::abs(std::abs(mean.at(q)) - std::abs(fit.at(q))) / wanted.gamma);
    const bool both = drive.rho > 0 && drive.rho < 1;
    m.phi = both ? std::remainder(drive_of(mean, drive.frequency).phi - drive.phi, two_pi) : 0;
    return m;
}

Harmonics<Acceleration> mean_of(const std::vector<Harmonics<Acceleration>>& all, std::size_t from,
                                std::size_t to) {
    Harmonics<Acceleration> sum;
    for (std::size_t i = from; i < to; ++i)
        for (std::size_t q = 0; q < max_harmonics; ++q)
            sum.a[q] += all[i].a[q] / static_cast<double>(to - from);
    return sum;
}

bool holds(const Misfit& m, double level) {
    return m.amplitude < 1e-3 && std::abs(m.phi) < 1e-3 &&
           std::ranges::all_of(m.share.begin() + 2, m.share.end(), [&](double s) { return s < level; });
}

void judge(ControlResult& r, const std::vector<Harmonics<Acceleration>>& truth, const Drive& drive) {
    constexpr std::size_t ten = 10, hundred = 100;
    for (const auto& [level, lock] : {std::pair{1e-3, &r.lock60}, std::pair{1e-4, &r.lock80}}) {
        std::size_t from = truth.size() - ten + 1;
        while (from > 0 && holds(misfit(mean_of(truth, from - 1, from - 1 + ten), drive, r.reached), level))
            --from;
        *lock = from + ten > truth.size() ? -1 : static_cast<int>(from);
    }
    const Misfit last = misfit(mean_of(truth, truth.size() - hundred, truth.size()), drive, r.reached);
    r.mean_db = decibel(*std::ranges::max_element(last.share));
    r.delta_mrad = 1e3 * last.phi;
    std::array<double, controlled> squares{};
    double tail = 0;
    for (std::size_t i = truth.size() - hundred; i < truth.size(); ++i) {
        const Misfit m = misfit(truth[i], drive, r.reached);
        for (std::size_t q = 0; q < controlled; ++q) squares[q] += m.share[q] * m.share[q] / hundred;
        for (int q = controlled + 1; q <= max_harmonics; ++q) tail += std::norm(truth[i].at(q)) / hundred;
    }
    r.rms_db = decibel(std::sqrt(*std::ranges::max_element(squares)));
    r.tail_db = decibel(std::sqrt(tail) / drive.gamma);
}

// The response given to the law at the start: the identified one, or that of the data sheet.
Known find_out(const ControlCase& c, Bench& bench, ControlResult& result) {
    Known known{.drive = c.drive, .response = {}, .sheet = {}, .volts_limit = c.volts_limit};
    known.sheet = [scene = c.scene](double hz) {
        const auto [re, im] = simulated::ShakerPlant::response(scene, hz);
        return std::complex<double>{re, im};
    };
    control::IdentificationSettings settings{
        .harmonics = controlled, .gamma = c.drive.gamma, .volts_limit = c.volts_limit};
    for (std::size_t q = 0; q < max_harmonics; ++q)
        settings.nominal[q] = known.sheet(static_cast<double>(q + 1) * c.drive.frequency);
    control::Identification identification{settings};
    bool listened = false;
    while (!listened || (c.identify && !identification.done()))
        bench.step([&](const control::PeriodWindows::Window& w) {
            if (!listened && w.estimate.period > 20) {
                known.noise = w.estimate.sd;
                listened = true;
                if (c.identify) bench.play(identification.volts(), c.drive.frequency, 10, 0);
            }
            if (w.motion.steady && w.sequence == bench.sequence() && !identification.done() &&
                identification.take(w.estimate) && !identification.done())
                bench.play(identification.volts(), c.drive.frequency, 5, 0);
        });
    result.response = identification.response();
    result.response.frequency = c.drive.frequency;
    known.response = result.response;
    for (std::size_t q = 0; q < max_harmonics; ++q)
        known.response.h[q] = c.misjudged * (c.identify ? result.response.h[q] : settings.nominal[q]);
    return known;
}

}  // namespace

ControlResult run_control(const ControlCase& c, const MakeLaw& make, std::uint64_t seed) {
    Bench bench{c, seed};
    ControlResult result;
    const auto law = make(find_out(c, bench, result));
    Drive drive = c.drive;
    bench.play(law->volts(), drive.frequency, 1, 0);
    std::size_t begin = bench.truth.periods.size();
    const auto passed = [&](int periods) {
        return bench.truth.periods.size() >= begin + static_cast<std::size_t>(periods);
    };
    auto event = c.events.begin();
    while (!passed(c.periods)) {
        for (; event != c.events.end() && passed(event->period); ++event) {
            if (event->plant) event->plant(bench.plant());
            bench.sensor_sign = event->sensor_sign;
            if (!event->drive) continue;
            drive = *event->drive;
            law->set(drive);
            bench.play(law->volts(), drive.frequency, 1, 0);
        }
        bench.step([&](const control::PeriodWindows::Window& w) {
            if (law->take(w, w.sequence == bench.sequence()))
                bench.play(law->volts(), drive.frequency, 1, c.latency);
        });
        result.gave_up = result.gave_up || law->gave_up();
    }
    result.reached = law->reached();
    begin += static_cast<std::size_t>(c.judged_from);
    judge(result,
          {bench.truth.periods.begin() + static_cast<std::ptrdiff_t>(begin), bench.truth.periods.end()},
          drive);
    return result;
}

}  // namespace shaker::test
