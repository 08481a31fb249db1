#include "tests/support/run/synthetic_run.hpp"

#include <cmath>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>
#include <sstream>

#include "drivers/walker/steady_state.hpp"
#include "tests/support/paths.hpp"

namespace shaker {
namespace {

constexpr double friction = 0.113 * paper_g;  // m/s^2

/// A walker's settled motion: drift velocity and position about the drift line.
struct Motion {
    double v_D = 0;
    std::function<double(double t)> x;
};

/// Two slips of half a period: velocities meet where v_B(t0 + T/2) - v_B(t0) = mu g T/2.
Motion two_slips(const Drive& d) {
    const double T = 1 / d.frequency, w = two_pi * d.frequency;
    const double t0 = std::acos(std::numbers::pi * friction / (2 * d.rho * d.gamma)) / w;
    const double v0 =
        -d.gamma / w * (d.rho * std::cos(w * t0) + (1 - d.rho) / 2 * std::cos(2 * w * t0 + d.phi));
    const double v_D = v0 + friction * T / 4;
    return {v_D, [=](double t) {
                double u = std::fmod(t - t0, T);
                if (u < 0) u += T;
                const double h = T / 2, r = u - h;
                const double moved =
                    u < h ? v0 * u + friction * u * u / 2
                          : v0 * h + friction * h * h / 2 + (v0 + friction * h) * r - friction * r * r / 2;
                return moved - v_D * u;
            }};
}

/// Positions at uniform phases of a period, from 0 at its start to D at its end.
Motion tabulated(std::vector<double> x, double f) {
    const double D = x.back();
    return {D * f, [=, x = std::move(x)](double t) {
                const double p = t * f - std::floor(t * f), at = p * static_cast<double>(x.size() - 1);
                const auto i = std::min(static_cast<std::size_t>(at), x.size() - 2);
                return x[i] + (x[i + 1] - x[i]) * (at - static_cast<double>(i)) - D * p;
            }};
}

/// Steps of T/20000, friction as an impulse that at most stops the sliding: sticks exactly.
Motion stepped(const Drive& d) {
    constexpr int steps = 20000, periods = 80;
    const double h = 1 / (d.frequency * steps);
    Harmonics<Acceleration> v_B = harmonics(d);
    for (int q = 1; q <= 2; ++q) v_B.at(q) /= std::complex<double>(0, two_pi * d.frequency * q);
    std::vector<double> x(steps + 1, 0.0);
    double v = 0;
    for (int i = 0; i < periods * steps; ++i) {
        const int now = i % steps;
        if (now == 0) x[0] = 0;
        const double base = value_at(v_B, two_pi * (now + 1) / steps), sliding = v - base, before = v;
        v = base + std::copysign(std::max(std::abs(sliding) - friction * h, 0.0), sliding);
        x[static_cast<std::size_t>(now) + 1] = x[static_cast<std::size_t>(now)] + h * (v + before) / 2;
    }
    return tabulated(std::move(x), d.frequency);
}

/// A walker under any law of friction, settled.
Motion integrated(const SyntheticRun& run) {
    constexpr int steps = 20000;
    const double h = 1 / (run.drive.frequency * steps);
    const auto v = true_velocity(run, steps);
    std::vector<double> x{0};
    for (std::size_t i = 0; i < v.size(); ++i) x.push_back(x.back() + h * (v[i] + v[(i + 1) % v.size()]) / 2);
    return tabulated(std::move(x), run.drive.frequency);
}

Motion motion_of(const SyntheticRun& run) {
    if (run.friction) return integrated(run);
    return run.may_stick ? stepped(run.drive) : two_slips(run.drive);
}

class Noise {
public:
    Noise(std::uint64_t seed, double sd, double memory) : generator_(seed), sd_(sd), memory_(memory) {
        value_ = sd * normal_(generator_);
    }
    double next() {
        value_ = memory_ * value_ + std::sqrt(1 - memory_ * memory_) * sd_ * normal_(generator_);
        return value_;
    }

private:
    std::mt19937_64 generator_;
    std::normal_distribution<double> normal_;
    double sd_, memory_, value_ = 0;
};

/// Position of the drift line at each start of a period, jitter and settling included.
std::vector<double> drift_steps(const SyntheticRun& run, double v_D) {
    Noise jitter(run.seed * 7919 + 1, run.drift_jitter, run.drift_memory);
    const double D = v_D / run.drive.frequency;
    std::vector<double> x{0};
    double settling = run.settling;
    for (int k = 0; k < run.periods + 2; ++k) {
        x.push_back(x.back() + D * (1 + jitter.next() + settling));
        settling *= run.contraction;
    }
    return x;
}

reduction::MotionSeries see(const SyntheticRun& run, int view, double scale, auto position) {
    reduction::MotionSeries s;
    s.view = view == 0 ? "top" : "side";
    s.exposure_s = run.exposure_s;
    const auto frames = static_cast<int>(std::lround(run.periods * run.frame_rate_hz / run.drive.frequency));
    Noise noise(run.seed * 104729 + static_cast<std::uint64_t>(view) * 31 + (scale < 0 ? 17 : 0),
                run.position_noise_m, run.noise_memory);
    for (int i = 0; i < frames; ++i) {
        const double t = run.start_s + i / run.frame_rate_hz;
        s.t_s.push_back(t);
        constexpr int instants = 8;  // in one exposure
        double x = 0;
        for (int k = 0; k < instants; ++k)
            x += position(t + run.exposure_s * ((k + 0.5) / instants - 0.5)) / instants;
        s.x_m.push_back(0.05 + std::abs(scale) * x + noise.next());
        s.sd_m.push_back(std::max(run.position_noise_m, 1e-12));
    }
    return s;
}

Harmonics<Acceleration> base_harmonics(const SyntheticRun& r) {
    Harmonics<Acceleration> h = harmonics(r.drive);
    h.at(3) = r.third;
    return h;
}

double sensed_acceleration(const SyntheticRun& r, double t) {
    Harmonics<Acceleration> h = base_harmonics(r);
    for (int q = 1; q <= 3; ++q) {
        const double f = q * r.drive.frequency;
        const std::complex<double> s{0, r.lowpass_hz > 0 ? f / r.lowpass_hz : 0};
        h.at(q) *= r.corner.at(f) / (1.0 + std::numbers::sqrt2 * s + s * s);
    }
    return value_at(h, two_pi * std::remainder(r.drive.frequency * t, 1.0));
}

double base_position(const SyntheticRun& r, double t) {
    Harmonics<Acceleration> h = base_harmonics(r);
    for (int q = 1; q <= 3; ++q) h.at(q) /= -std::pow(two_pi * r.drive.frequency * q, 2);
    return value_at(h, two_pi * std::remainder(r.drive.frequency * t, 1.0));
}

}  // namespace

double drift_velocity(const SyntheticRun& run) { return motion_of(run).v_D; }

std::vector<double> true_velocity(const SyntheticRun& run, int n) {
    walker::WalkerSetting setting;
    setting.frequency = run.drive.frequency;
    setting.base = base_harmonics(run);
    setting.friction = run.friction.value();
    walker::IntegratedWalker walker{setting};
    walker::settle(walker);
    walker.observe(static_cast<std::size_t>(n));
    walker.advance_period();
    const auto v_base = walker::base_velocity(setting);
    std::vector<double> v(walker.relative().begin(), walker.relative().end());
    for (std::size_t i = 0; i < v.size(); ++i) v[i] += v_base(two_pi * static_cast<double>(i) / n);
    return v;
}

reduction::Measurement make_measurement(const SyntheticRun& run) {
    const Motion motion = motion_of(run);
    const auto line = drift_steps(run, motion.v_D);
    reduction::Measurement m;
    m.frequency_hz = run.drive.frequency;
    for (int v = 0; v < run.views; ++v) {
        m.walkers.push_back(see(run, v, run.track_scale, [&](double t) {
            const double periods = std::max(0.0, t * run.drive.frequency);
            const auto k = static_cast<std::size_t>(periods);
            return motion.x(t) + line[k] + (line[k + 1] - line[k]) * (periods - static_cast<double>(k));
        }));
        m.bases.push_back(see(run, v, -run.track_scale, [&](double t) { return base_position(run, t); }));
    }
    Noise noise(run.seed * 15485863 + 5, run.accel_noise_mps2, 0);
    const double last = run.start_s + run.periods / run.drive.frequency + run.late_s;
    for (int i = 0; i / run.accel_rate_hz <= last; ++i) {
        const double t = i / run.accel_rate_hz;
        const double a = sensed_acceleration(run, t * (1 + 1e-6 * run.ppm) - run.late_s);
        m.accelerometer.t_s.push_back(t);
        m.accelerometer.a_mps2.push_back({a * run.axis[0] + noise.next(), a * run.axis[1] + noise.next(),
                                          a * run.axis[2] + noise.next() + 9.8});
    }
    return m;
}

std::optional<WrittenSession> lab_session(double position_noise_m, std::uint64_t seed) {
    const std::filesystem::path folder = test::source_dir() + "/../shared/data/lab-session";
    std::ifstream truth_file(folder / "truth.json"), accel_file(folder / "accel.csv");
    if (!truth_file || !accel_file) return {};
    const auto truth = nlohmann::json::parse(truth_file);
    WrittenSession out{{},
                       1e-3 * truth["v_D_mmps"].get<double>(),
                       truth["gamma_mps2"],
                       truth["phi_rad"],
                       truth["accel_late_s"],
                       truth["ppm"],
                       truth["efficiency"],
                       truth["segments_t_over_T_kind"][1][0],
                       truth["segments_t_over_T_kind"][2][0]};
    reduction::Measurement& m = out.measurement;
    m.frequency_hz = truth["f_hz"];
    const auto series = [&](const char* key, std::uint64_t stream) {
        reduction::MotionSeries s;
        Noise noise(seed * 1000003 + stream, position_noise_m, 0);
        for (const double x_mm : truth[key]) {
            s.t_s.push_back(truth["t_first_frame_s"].get<double>() +
                            1e-3 * static_cast<double>(s.t_s.size()));
            s.x_m.push_back(1e-3 * x_mm + noise.next());
            s.sd_m.push_back(std::max(position_noise_m, 1e-12));
        }
        return s;
    };
    for (std::uint64_t v = 0; v < 2; ++v) {
        m.walkers.push_back(series("x_walker_mm_every_frame", 2 * v));
        m.bases.push_back(series("x_base_mm_every_frame", 2 * v + 1));
        m.walkers.back().view = m.bases.back().view = v == 0 ? "top" : "side";
    }
    std::string row;
    std::getline(accel_file, row);
    while (std::getline(accel_file, row)) {
        std::istringstream in(row);
        double t = 0;
        std::array<double, 3> a{};
        char comma = 0;
        in >> t >> comma >> a[0] >> comma >> a[1] >> comma >> a[2];
        m.accelerometer.t_s.push_back(t);
        m.accelerometer.a_mps2.push_back(a);
    }
    return out;
}

}  // namespace shaker
