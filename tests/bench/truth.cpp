// Truth: bias, error, z, coverage and cost of every number of a reduction, on records with known truth
//   --runs N (400): of each row, a quarter of it from 400 periods on   --scenes NAME (all): rows with NAME
//   --seed N (1): of the first run
// Rows of "friction": mu against v_R from 12 drives each, of three laws, with an eightieth of the runs.
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "daemon/law/slope_mu.hpp"
#include "daemon/reduction/reduction.hpp"
#include "drivers/walker/changing_walker.hpp"
#include "drivers/walker/steady_state.hpp"
#include "tests/bench/option.hpp"
#include "tests/bench/table.hpp"
#include "tests/support/cost.hpp"

namespace {

using namespace shaker;
using calibration::Estimate;

struct Scene {
    std::string name;
    int periods = 40;
    double jitter = 0, memory = 0;  // of mu, per period
    double gamma = 1, phi = 0;      // g, rad
    double noise_um = 2;            // of a position, white
    double frame_rate_hz = 1000;
    int views = 2;
    walker::Friction friction{};  // with jitter and memory only where it is Coulomb's
};

/// White noise; friction that scatters, with memory; other drives; other noise; long records.
std::vector<Scene> scenes() {
    std::vector<Scene> out;
    for (const int n : {5, 10, 20, 40, 100}) out.push_back({"white", n});
    for (const int n : {5, 10, 20, 40, 100}) out.push_back({"jitter 1 %", n, 0.01});
    for (const double r : {0.5, 0.8, 0.9, 0.98})
        for (const int n : {10, 20, 40, 100}) out.push_back({"jitter 2 %", n, 0.02, r});
    for (const int n : {10, 40}) out.push_back({"jitter 10 %", n, 0.1});
    out.push_back({"jitter 10 %", 100, 0.1, 0.8});
    for (const int n : {10, 40}) out.push_back({"jitter 0.1 %", n, 1e-3});
    for (const double gamma : {0.5, 1.5, 3.0})
        for (const double phi : {1.5708, 3.1416}) out.push_back({"drive", 40, 0.01, 0.5, gamma, phi});
    out.push_back({"drive", 40, 0, 0, 2, 3.1416});
    out.push_back({"noise 6 um, 400/s", 40, 0, 0, 1, 0, 6, 400});
    out.push_back({"noise 6 um, 400/s", 40, 0.01, 0.5, 1, 0, 6, 400});
    out.push_back({"noise 0.5 um, 1 view", 20, 0, 0, 1, 0, 0.5, 1000, 1});
    for (const double r : {0.0, 0.9, 0.98}) out.push_back({"long", 400, 0.02, r, 1, 0, 2, 400, 1});
    out.push_back({"long, white", 400, 0, 0, 1, 0, 2, 400, 1});
    out.push_back({"long, white", 1000, 0, 0, 1, 0, 2, 400, 1});
    out.push_back({"long", 1000, 0.02, 0.98, 1, 0, 2, 400, 1});
    return out;
}

constexpr double frequency = 20, late_s = 0.0031, ppm = 20, third = 0.02;  // third harmonic: share of gamma
constexpr double accel_rate_hz = 2000, accel_noise = 1.1e-3;

walker::WalkerSetting setting_of(const Scene& s) {
    walker::WalkerSetting out;
    out.base = harmonics(Drive{.frequency = frequency, .gamma = s.gamma * paper_g, .phi = s.phi});
    out.base.at(3) = third * s.gamma * paper_g;
    out.friction = s.friction;
    out.friction.change = {.jitter = s.jitter, .memory = s.memory};
    return out;
}

/// Mean of an endless record. With jitter: of 60 000 periods, corrected for the mean of their mu.
double true_v_D(const Scene& s) {
    walker::WalkerSetting setting = setting_of(s);
    const auto at = [&](double factor) {
        walker::WalkerSetting constant = setting;
        constant.friction.change = {};
        constant.friction.mu_k *= factor;
        constant.friction.mu_s *= factor;
        return walker::settle(constant).v_D;
    };
    if (s.jitter == 0) return at(1);
    setting.friction.change.seed = 99;
    const walker::MeanWalk walk = walker::mean_walk(setting, 0, 1000, 60000);
    constexpr double small = 1e-3;
    return walk.v_D - (at(1 + small) - at(1 - small)) / (2 * small) * (walk.mu_factor - 1);
}

/// A settled walker at many phases of each period, for positions between them.
class Walk {
public:
    Walk(const Scene& s, std::uint64_t seed) {
        walker::WalkerSetting setting = setting_of(s), constant = setting;
        setting.friction.change.seed = seed;
        walker::MuHistory history{setting.friction.change, 1 / frequency};
        constant.friction.change = {};
        if (s.jitter == 0) {
            record(setting, s.periods + 2);
            return;
        }
        double v = 0, x = 0;
        for (int k = -settling; k < s.periods + 2; ++k) {
            const double factor = history.next();
            walker::WalkerSetting now = constant;
            now.friction.mu_k *= factor;
            now.friction.mu_s *= factor;
            const walker::WalkerLaw law{now};
            walker::Walker walker{law, v};
            if (k >= 0)
                for (int i = 0; i < steps; ++i) {
                    const walker::WalkerPoint p = walker.advance_to(static_cast<double>(i) / steps);
                    x_.push_back(x + p.x);
                    v_.push_back(p.v);
                }
            x += walker.advance_period();
            v = walker.now().v;
        }
    }
    /// Cubic between the phases; 0.1 nm at the kinks.
    [[nodiscard]] double at(double t) const {
        const double u = t * frequency * steps;
        const auto i = static_cast<std::size_t>(u);
        const double w = u - static_cast<double>(i), h = 1 / (frequency * steps), a = x_[i], b = x_[i + 1];
        return a + w * w * (3 - 2 * w) * (b - a) + h * w * (1 - w) * ((1 - w) * v_[i] - w * v_[i + 1]);
    }

private:
    void record(const walker::WalkerSetting& setting, int periods) {
        constexpr std::size_t finer = 10;  // steps between two phases, for x at the kinks
        walker::IntegratedWalker walker{setting};
        const double D = settle(walker).D;
        walker.observe(finer * steps);
        walker.advance_period();
        const auto v_base = walker::base_velocity(setting);
        std::vector<double> x{0}, v;
        for (std::size_t i = 0; i < finer * steps; ++i) {
            v.push_back(walker.relative()[i] +
                        v_base(two_pi * static_cast<double>(i) / static_cast<double>(finer * steps)));
            if (i > 0)
                x.push_back(x.back() +
                            (v[i - 1] + v[i]) / (2 * frequency * static_cast<double>(finer * steps)));
        }
        for (int k = 0; k < periods; ++k)
            for (std::size_t i = 0; i < finer * steps; i += finer) {
                x_.push_back(k * D + x[i]);
                v_.push_back(v[i]);
            }
    }

    static constexpr int steps = 200, settling = 60;
    std::vector<double> x_, v_;
};

reduction::MotionSeries seen(const Scene& s, double start, std::mt19937_64& random, auto position) {
    std::normal_distribution<double> noise{0, 1e-6 * s.noise_um};
    reduction::MotionSeries out;
    const auto frames = std::lround(s.periods * s.frame_rate_hz / frequency);
    for (long i = 0; i < frames; ++i) {
        const double t = start + static_cast<double>(i) / s.frame_rate_hz;
        out.t_s.push_back(t);
        out.x_m.push_back(position(t) + noise(random));
        out.sd_m.push_back(1e-6 * s.noise_um);
    }
    return out;
}

reduction::Measurement measured(const Scene& s, std::uint64_t seed) {
    std::mt19937_64 random{seed};
    const Walk walk{s, seed + 1000000};
    Harmonics<Acceleration> a = setting_of(s).base, x = a;
    for (int q = 1; q <= 3; ++q) x.at(q) /= -std::pow(two_pi * frequency * q, 2);
    const double start = std::uniform_real_distribution<double>{0, 1 / frequency}(random);
    const auto angle = [](double t) { return two_pi * std::remainder(frequency * t, 1.0); };
    reduction::Measurement m;
    m.frequency_hz = frequency;
    for (int view = 0; view < s.views; ++view) {
        m.walkers.push_back(seen(s, start, random, [&](double t) { return walk.at(t); }));
        m.bases.push_back(seen(s, start, random, [&](double t) { return value_at(x, angle(t)); }));
        m.walkers.back().view = m.bases.back().view = view == 0 ? "top" : "side";
    }
    std::normal_distribution<double> noise{0, accel_noise};
    const double last = start + s.periods / frequency + 0.02;
    for (int i = 0; i / accel_rate_hz <= last; ++i) {
        const double t = i / accel_rate_hz;
        m.accelerometer.t_s.push_back(t);
        m.accelerometer.a_mps2.push_back({value_at(a, angle(t * (1 + 1e-6 * ppm) - late_s)) + noise(random),
                                          noise(random), paper_g + noise(random)});
    }
    return m;
}

/// Errors that do not know of jitter: of the line by least squares, and by Newey and West (lags up to 4
/// periods) from the means of the periods.
struct Naive {
    double least_squares = 0, hac = 0;
};

Naive naive_errors(const reduction::Reduction& r) {
    std::vector<double> y{0};
    for (const reduction::PeriodResult& p : r.periods)
        if (std::isfinite(p.drift.value)) y.push_back(y.back() + p.drift.value - r.D.value);
    const double n = static_cast<double>(y.size()), middle = (n - 1) / 2;
    double mean = 0, total = 0, variance = 0;
    for (const double value : y) mean += value / n;
    std::vector<double> score;
    for (std::size_t i = 0; i < y.size(); ++i) {
        const double k = static_cast<double>(i) - middle;
        total += k * k;
        score.push_back(k * (y[i] - mean));
    }
    for (std::size_t lag = 0; lag <= 4; ++lag) {
        double product = 0;
        for (std::size_t i = lag; i < score.size(); ++i) product += score[i] * score[i - lag];
        variance += (lag == 0 ? 1 : 2 * (1 - static_cast<double>(lag) / 5)) * product;
    }
    return {r.fit_residual_x_m.value * std::sqrt(12 / (r.frames * (n * n - 1))) * frequency,
            std::sqrt(std::max(variance, 0.0)) / total * frequency};
}

/// Errors over their standard errors.
struct Coverage {
    double count = 0, bias = 0, squares = 0, sigmas = 0, z2 = 0, within = 0;
    void add(double error, double sigma) {
        const double z = sigma > 0 ? error / sigma : (error == 0 ? 0 : 1e3);
        ++count;
        bias += error;
        squares += error * error;
        sigmas += sigma;
        z2 += z * z;
        within += std::abs(z) <= 2 ? 1 : 0;
    }
};

struct Found {
    std::string unit;
    double scale = 1;
    Coverage here, least_squares, hac;
    double cost_ms = NAN;  // of a whole reduction
};

void add_row(const std::string& name, double periods, double independent, const std::string& what,
             const Found& f, bench::Table& table) {
    const Coverage& c = f.here;
    bench::Row row{{"scene", name},
                   {"N", periods},
                   {"independent", independent},
                   {"number", what},
                   {"unit", f.unit},
                   {"runs", c.count},
                   {"bias", f.scale * c.bias / c.count},
                   {"rms error", f.scale * std::sqrt(c.squares / c.count)},
                   {"mean se", f.scale * c.sigmas / c.count},
                   {"z rms", std::sqrt(c.z2 / c.count)},
                   {"within 2 se", c.within / c.count}};
    if (std::isfinite(f.cost_ms)) row.push_back({"reduction", f.cost_ms, "ms"});
    if (f.hac.count > 0) {
        row.push_back({"least squares: z rms", std::sqrt(f.least_squares.z2 / c.count)});
        row.push_back({"within", f.least_squares.within / c.count});
        row.push_back({"HAC: z rms", std::sqrt(f.hac.z2 / c.count)});
        row.push_back({"within, HAC", f.hac.within / c.count});
    }
    table.add(std::move(row));
}

/// Adds the errors of one reduction of frames from first_s on.
void add(const reduction::Reduction& r, const Scene& s, double v_D, double first_s,
         std::map<std::string, Found>& to) {
    const double gamma = s.gamma * paper_g, w = two_pi * frequency, V = gamma / w;
    const double v_rms = std::hypot(V * std::sqrt(5.0 / 32), third * gamma / (3 * w) / std::sqrt(2.0));
    const auto one = [&](const char* name, const char* unit, double scale, const Estimate& e, double truth,
                         double turn = INFINITY) {
        Found& f = to[name];
        f.unit = unit;
        f.scale = scale;
        f.here.add(std::remainder(e.value - truth, turn), e.sigma);
    };
    one("v_D", "um/s", 1e6, r.v_D, v_D);
    one("D", "um", 1e6, r.D, v_D / frequency);
    one("efficiency", "1e-6", 1e6, r.efficiency, std::abs(v_D) / v_rms);
    one("gamma", "mm/s^2", 1e3, r.gamma, gamma);
    one("rho", "1e-6", 1e6, r.rho, 0.5);
    one("phi", "mrad", 1e3, r.phi, s.phi, two_pi);
    one("v_rms", "um/s", 1e6, r.v_rms, v_rms);
    one("third harmonic", "mm/s^2", 1e3, r.harmonics.at(2).amplitude, third * gamma);
    one("third's phase", "mrad", 1e3, r.harmonics.at(2).phase, 0, two_pi);
    one("frequency", "uHz", 1e6, r.frequency, frequency);
    one("late", "us", 1e6, r.accelerometer_late_s, late_s);
    one("ppm", "1e-6", 1, r.accelerometer_ppm, ppm);
    const double middle_s = first_s + 0.5 * s.periods / frequency;
    one("delay", "us", 1e6, r.delay_s, late_s - 1e-6 * ppm * middle_s);
    const Naive naive = naive_errors(r);
    to["v_D"].least_squares.add(r.v_D.value - v_D, naive.least_squares);
    to["v_D"].hac.add(r.v_D.value - v_D, naive.hac);
}

/// mu against v_R, without a law, from measurements at 12 drives: of each part of a slip, and of each step of
/// v_R. The truth is the acceleration of the walker in the same parts, with the same weights.
void add_friction(const walker::Friction& friction, double frame_rate_hz, int runs, int seed,
                  bench::Table& table) {
    Found parts{"1e-3", 1e3, {}, {}, {}, NAN}, means = parts;
    for (int i = 0; i < runs; ++i) {
        std::vector<law::Point> points, exact;
        for (const double gamma : {1.0, 1.5, 2.0, 3.0})
            for (const double phi : {0.0, 1.6, 4.0}) {
                const Scene s{.name = "friction",
                              .gamma = gamma,
                              .phi = phi,
                              .frame_rate_hz = frame_rate_hz,
                              .friction = friction};
                const auto number = static_cast<std::uint64_t>(1000 * (seed + i)) + points.size();
                const reduction::Reduction r = reduction::reduce(measured(s, number));
                law::Point p =
                    law::point_of(r, {.frequency = frequency, .gamma = gamma * paper_g, .phi = phi});
                p.phases_per_period = frame_rate_hz / frequency;
                points.push_back(p);
                const Walk walk{s, number + 1000000};
                for (std::size_t k = 0; k < p.cycle.phase.size(); ++k) {
                    constexpr double h = 1e-6;
                    const double t = 1 / frequency + p.cycle.phase[k] / frequency;
                    p.cycle.v_mps[k] = (walk.at(t + h) - walk.at(t - h)) / (2 * h);
                }
                exact.push_back(std::move(p));
                const auto measured_parts = law::slip_forces(points.back()),
                           true_parts = law::slip_forces(exact.back());
                for (const law::SlipForce& f : measured_parts)
                    for (const law::SlipForce& e : true_parts)
                        if (e.from == f.from && e.to == f.to)
                            parts.here.add((f.a.value - e.a.value) / paper_g, f.a.sigma / paper_g);
            }
        const auto found = law::friction_by_velocity(points, paper_g, {0, 0}, "level").at,
                   truth = law::friction_by_velocity(exact, paper_g, {0, 0}, "level").at;
        for (const law::FrictionAt& at : found)
            for (const law::FrictionAt& e : truth)
                if (std::abs(e.v_R - at.v_R) < 0.05 * std::abs(at.v_R) && e.pieces == at.pieces)
                    means.here.add(at.mu.value - e.mu.value, at.mu.sigma);
    }
    const std::string name =
        fmt::format("friction, {}, {:.0f}/s",
                    walker::friction_laws.at(static_cast<std::size_t>(friction.law)), frame_rate_hz);
    add_row(name, 40, 40, "mu of a part", parts, table);
    add_row(name, 40, 40, "mu(v_R)", means, table);
}

}  // namespace

int main(int argc, char** argv) {
    const int runs = bench::whole_option(argc, argv, "--runs", 400, 4);
    const int seed = bench::whole_option(argc, argv, "--seed", 1, 0);
    const std::string only = bench::option(argc, argv, "--scenes", "");
    bench::Table table;
    std::map<std::string, Found> pooled;
    std::map<std::array<double, 4>, double> truths;
    Coverage rows;  // of v_D, of records with at least 4 independent values
    for (const Scene& s : scenes()) {
        if (s.name.find(only) == std::string::npos) continue;
        const std::array key{s.jitter, s.memory, s.gamma, s.phi};
        if (!truths.contains(key)) truths[key] = true_v_D(s);
        const double v_D = truths[key], independent = s.periods * (1 - s.memory) / (1 + s.memory);
        std::map<std::string, Found> found;
        std::vector<double> costs_ms;
        for (int i = 0; i < (s.periods >= 400 ? std::max(runs / 4, 1) : runs); ++i) {
            reduction::Measurement m = measured(s, static_cast<std::uint64_t>(seed + i));
            const double first_s = m.walkers.front().t_s.front(), before = bench::cpu_ns();
            const reduction::Reduction r = reduction::reduce(std::move(m));
            costs_ms.push_back(1e-6 * (bench::cpu_ns() - before));
            add(r, s, v_D, first_s, found);
            add(r, s, v_D, first_s, pooled);
            if (independent >= 4) rows.add(r.v_D.value - v_D, r.v_D.sigma);
        }
        std::ranges::nth_element(costs_ms, costs_ms.begin() + std::ssize(costs_ms) / 2);
        found.at("v_D").cost_ms = costs_ms[costs_ms.size() / 2];
        add_row(s.name, s.periods, independent, "v_D", found.at("v_D"), table);
        if (s.name == "white")
            for (const char* name : {"gamma", "phi", "delay"})
                add_row(s.name, s.periods, independent, name, found.at(name), table);
    }
    using enum walker::FrictionLaw;
    if (std::string{"friction"}.find(only) != std::string::npos)
        for (const double rate_hz : {500.0, 1000.0})
            for (const walker::Friction& friction : {walker::Friction{.viscous = 3.5},
                                                     {.mu_s = 0.12, .law = stribeck, .stribeck = 0.02},
                                                     {.law = dahl}})
                add_friction(friction, rate_hz, std::max(runs / 80, 1), seed, table);
    for (const auto& [name, found] : pooled)
        if (name != "v_D") add_row("all", NAN, NAN, name, found, table);
    if (rows.count > 0)
        add_row("all with 4 independent", NAN, NAN, "v_D", {"um/s", 1e6, rows, {}, {}, NAN}, table);
    table.print(argc, argv);
    return 0;
}
