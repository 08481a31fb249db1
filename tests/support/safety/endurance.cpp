#include "tests/support/safety/endurance.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <random>

#include "daemon/safety/preflight.hpp"
#include "drivers/simulated/shaker_plant.hpp"
#include "tests/support/run/virtual_run.hpp"

namespace shaker::test {

namespace {

class Chance {
public:
    explicit Chance(std::uint64_t seed) : rng_{seed} {}
    double operator()(double from, double to) { return std::uniform_real_distribution{from, to}(rng_); }
    /// Logarithmic: as many between 1 and 2 as between 2 and 4.
    double by_ratio(double from, double to) { return from * std::pow(to / from, (*this)(0, 1)); }
    bool one_of(double n) { return (*this)(0, n) < 1; }

private:
    std::mt19937_64 rng_;
};

struct Loaded {
    const char* model;
    double base_kg;
};
constexpr Loaded shakers[] = {{"B&K 4809", 0.5}, {"LDS V203", 0.3}, {"Modal Shop 2100E11", 1}};

// Share of the limits that a set-point may use: the walker reacts on the base, and a change overshoots.
constexpr double headroom = 0.6;
constexpr double most_gamma = 3 * paper_g;
constexpr double most_patience_s = 20;  // for a set-point that is not reached

/// Set-points over the whole range of the bench.
class SetPoints {
public:
    SetPoints(const simulated::Scene& scene, std::uint64_t seed)
        : scene_{scene}, limits_{limits_of(scene)}, chance_{seed} {}
    Drive next() {
        Drive d{.gamma = 1};
        frequency_ = chance_.one_of(3) ? chance_(15, 25) : frequency_;
        d.frequency = frequency_;
        d.rho = chance_.one_of(10) ? std::round(chance_(0, 1)) : chance_(0, 1);
        d.phi = chance_(0, two_pi);
        double most = most_gamma;
        for (const safety::Demand& q : demands(planned(d), limits_))
            most = std::min(most, headroom * q.limit / q.value);
        d.gamma = chance_.by_ratio(std::min(0.25 * paper_g, most), most);
        return d;
    }
    [[nodiscard]] double stays_s() { return chance_.by_ratio(1, 20); }

private:
    [[nodiscard]] safety::PlannedMotion planned(const Drive& d) const {
        const simulated::ShakerTruth& s = scene_.shaker;
        safety::PlannedMotion plan{.target = harmonics(d),
                                   .frequency = d.frequency,
                                   .moving_kg = s.moving_mass_kg + s.base_mass_kg + scene_.walker.mass_kg};
        for (std::size_t q = 0; q < max_harmonics; ++q) {
            const auto [re, im] =
                simulated::ShakerPlant::response(scene_, static_cast<double>(q + 1) * d.frequency);
            plan.response[q] = {re, im};
        }
        return plan;
    }

    simulated::Scene scene_;
    safety::Limits limits_;
    Chance chance_;
    double frequency_ = 20;
};

}  // namespace

Endurance& Endurance::operator+=(const Endurance& more) {
    simulated_s += more.simulated_s;
    locked_s += more.locked_s;
    set_points += more.set_points;
    runs += more.runs;
    trips.insert(trips.end(), more.trips.begin(), more.trips.end());
    return *this;
}

simulated::Scene sound_bench(std::uint64_t seed, double length_s) {
    Chance chance{1000 + seed};
    const Loaded& loaded = shakers[seed % std::size(shakers)];
    simulated::Scene s = simulated::paper_scene();
    s.seed = seed;
    s.tilt_deg = chance(-0.5, 0.5);
    s.dac_rate_hz = 8000;
    s.dac_buffer_s = chance(0, 0.02);
    s.shaker = simulated::read_shaker(
        SettingsTable::from_text(fmt::format("model = \"{}\"\n", loaded.model), "model"));
    s.shaker.base_mass_kg = loaded.base_kg;
    s.shaker.gain_drift_per_min = chance(-0.1, 0.1) / (length_s / 60);
    s.walker.mass_kg = chance(0.03, 0.08);
    s.walker.mu_k = chance(0.08, 0.15);
    s.walker.mu_s = s.walker.mu_k * (1 + chance(0, 0.2));
    simulated::AccelerometerTruth& a = s.accelerometer;
    a.rate_hz = 1000;
    a.lowpass_hz = 400;
    a.clock_ppm = chance(-150, 150);
    a.yaw_deg = chance(-180, 180);
    a.axis_told = chance.one_of(2) ? 1 : 0;
    a.latency_s = chance(0.0002, 0.002);
    a.latency_jitter_s = chance(20e-6, 500e-6);
    a.block_samples = static_cast<int>(chance(1, 16));
    a.mains_mps2 = chance(0, 0.005);
    a.mains_hz = chance(49.9, 50.1);
    for (double t = 30; t < length_s; t += chance(60, 300)) {
        s.faults.push_back({.what = simulated::FaultKind::walker_off, .at_s = t, .camera = {}});
        s.faults.push_back(
            {.what = simulated::FaultKind::walker_on, .at_s = t + chance(1, 20), .camera = {}});
    }
    return s;
}

Endurance endure(std::uint64_t seed, double length_s) {
    const simulated::Scene scene = sound_bench(seed, length_s);
    SetPoints points{scene, 2000 + seed};
    Endurance e{.runs = 1, .trips = {}};
    double next_s = 0, latest_s = 0, before_s = 0, reached_s = 0;
    Drive now = points.next();
    const auto each = [&](run::Sequence& sequence, acquisition::Channels& channels, double now_s) {
        if (sequence.state() == run::RunState::run && sequence.controller().report().locked)
            e.locked_s += now_s - before_s;
        before_s = now_s;
        reached_s = now_s;
        if (sequence.state() != run::RunState::run) {
            next_s = now_s + points.stays_s();
            latest_s = now_s + most_patience_s;
            return;
        }
        const bool reached = sequence.controller().report().locked;
        if (now_s < (reached ? next_s : latest_s) || now_s > length_s) return;
        now = points.next();
        sequence.set(now, sequence.plan().task, channels);
        ++e.set_points;
        next_s = now_s + points.stays_s();
        latest_s = now_s + most_patience_s;
    };
    const VirtualRun run = run_virtually({.scene = scene_text(scene),
                                          .drive = now,
                                          .periods = 600,
                                          .line_hz = 50,
                                          .each = each,
                                          .longest_s = length_s + 120});
    e.simulated_s = reached_s;
    if (run.trip)
        e.trips.push_back(fmt::format(
            "seed {}, {:.3f} s, in {}, at {:.2f} Hz gamma {:.3f} rho {:.3f} phi {:.3f}: {}", seed, reached_s,
            name(run.tripped_in), now.frequency, now.gamma, now.rho, now.phi, text(*run.trip)));
    else if (run.ended != run::RunState::idle)
        e.trips.push_back(fmt::format("seed {}: it ended in state {}", seed, name(run.ended)));
    return e;
}

}  // namespace shaker::test
