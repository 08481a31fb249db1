// Walker: event-driven stepping, Moreau time-stepping and all laws of friction: cost and error per period
#include "drivers/walker/walker.hpp"

#include <time.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "drivers/walker/changing_walker.hpp"
#include "tests/bench/table.hpp"
#include "tests/support/walker/fine_walker.hpp"
#include "tests/support/walker/walker_settings.hpp"

namespace shaker {
namespace {

constexpr int error_periods = 20;  // from rest at phase 0
constexpr int repeats = 7;

double cpu_seconds() {
    timespec t{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

volatile double result;  // result of the timed work

/// Median CPU time of one of `count` runs of `work`, in ns. The result of each run is written to volatile
/// memory: otherwise the compiler removes the work.
template <class Work>
double median_ns(int count, Work work) {
    std::vector<double> times;
    for (int i = 0; i < repeats; ++i) {
        const double start = cpu_seconds();
        for (int k = 0; k < count; ++k) result = work();
        times.push_back((cpu_seconds() - start) / count * 1e9);
    }
    std::nth_element(times.begin(), times.begin() + repeats / 2, times.end());
    return times[repeats / 2];
}

/// Moreau's time-stepping: a whole step sticks if friction can hold it, otherwise it slips. First order.
class Moreau {
public:
    Moreau(const walker::WalkerLaw& law, int steps) : h_{law.period() / steps} {
        const walker::Friction& friction = law.setting().friction;
        most_change_ = friction.mu_k * law.setting().g * h_;
        for (int i = 1; i <= steps; ++i) v_base_.push_back(law.v_base(two_pi * i / steps));
    }
    double advance_period() {
        double x = 0, v = v_;
        for (const double v_base : v_base_) {
            const double next = v + std::clamp(v_base - v, -most_change_, most_change_);
            x += h_ * (v + next) / 2;
            v = next;
        }
        v_ = v;
        return x;
    }

private:
    double h_;
    double most_change_ = 0;  // of v in a step
    double v_ = 0;
    std::vector<double> v_base_;
};

struct BenchDrive {
    std::string name;
    walker::WalkerSetting setting;
};

walker::WalkerSetting sixteen_harmonics() {
    std::mt19937_64 random{16};
    walker::WalkerSetting s;
    s.base = random_harmonics(random, 16, 2 * paper_g);
    return s;
}

double sincos_ns() {
    double x = 0.5;
    return median_ns(200000, [&] {
        const Turn z = turn(x);
        return x = 3 * z.s + z.c;
    });
}

struct Measured {
    double ns;
    double error;  // of x after error_periods, m
};

double exact_distance(const walker::WalkerSetting& setting) {
    FineWalker fine{setting};
    long double x = 0;
    for (int k = 0; k < error_periods; ++k) x += fine.advance_period();
    return static_cast<double>(x);
}

Measured event_driven(const walker::WalkerLaw& law, double exact) {
    walker::Walker walker{law};
    for (int k = 0; k < error_periods; ++k) walker.advance_period();
    const double error = std::abs(walker.now().x - exact);
    return {median_ns(20000, [&] { return walker.advance_period(); }), error};
}

double sampled_ns(const walker::WalkerLaw& law) {
    walker::Walker walker{law};
    return median_ns(2000, [&] {
        double sum = 0;
        for (int i = 0; i < 50; ++i) {
            const walker::WalkerPoint point = walker.advance_to(i / 50.0);
            sum += point.x + point.v;
        }
        return sum + walker.advance_period();
    });
}

Measured moreau(const walker::WalkerLaw& law, int steps, double exact) {
    Moreau walker{law, steps};
    double x = 0;
    for (int k = 0; k < error_periods; ++k) x += walker.advance_period();
    const double error = std::abs(x - exact);
    return {median_ns(std::max(3, 200000 / steps), [&] { return walker.advance_period(); }), error};
}

bench::Row row(const std::string& drive, const std::string& method, double ns, double error,
               const std::string& conditions) {
    return {{"drive", drive},
            {"method", method},
            {"cost", ns, "ns/period", 4},
            {"error", error, "V T", 2},
            {"conditions", conditions}};
}

/// Rows of one drive. Errors of x after 20 periods from rest, per period, against a long double walker.
void add_drive(bench::Table& table, const BenchDrive& drive, double sincos) {
    const walker::WalkerLaw law{drive.setting};
    const double scale = error_periods * law.velocity_scale() * law.period();
    const double exact = exact_distance(drive.setting);
    const Measured events = event_driven(law, exact);
    table.add(
        row(drive.name, "event-driven", events.ns, events.error / scale, "D and events of each period"));
    table.add(row(drive.name, "event-driven, sampled", sampled_ns(law), events.error / scale,
                  "and x, v at 50 instants a period"));
    table.add(row(drive.name, "setting up its tables",
                  median_ns(200, [&] { return walker::WalkerLaw{drive.setting}.v_base_at_0(); }), NAN,
                  "once a drive"));
    std::vector<double> log_steps, log_error;
    double moreau_1000_ns = NAN;
    for (const int steps : {100, 1000, 10000, 100000}) {
        const Measured m = moreau(law, steps, exact);
        table.add(row(drive.name, "Moreau " + std::to_string(steps), m.ns, m.error / scale,
                      "steps a period, tabulated base"));
        log_steps.push_back(std::log10(steps));
        log_error.push_back(std::log10(m.error));
        if (steps == 1000) moreau_1000_ns = m.ns;
    }
    table.add({{"drive", drive.name},
               {"method", "summary"},
               {"event-driven : Moreau 1000", events.ns / moreau_1000_ns, "", 2},
               {"event-driven : sincos", events.ns / sincos, "", 3},
               {"Moreau slope",
                (log_error.back() - log_error.front()) / (log_steps.front() - log_steps.back()), "", 3},
               {"conditions", "same run; order of the error in the step"}});
}

struct BenchLaw {
    std::string name;
    walker::Friction friction;
};

std::vector<BenchLaw> bench_laws() {
    using walker::FrictionLaw;
    std::vector<BenchLaw> laws{{"coulomb", {}},
                               {"coulomb, viscous 3.5/s", {}},
                               {"coulomb, backward 0.8", {}},
                               {"coulomb, jitter 2 %, memory 0.9", {}},
                               {"coulomb, ageing 5 %", {}},
                               {"coulomb, roughness 10 %", {}},
                               {"logarithmic", {}},
                               {"dahl 7.2 um, viscous 4.2/s", {}},
                               {"lugre 7.2 um", {}}};
    laws[1].friction.viscous = 3.5;
    laws[2].friction.backward = 0.8;
    laws[3].friction.change = {.jitter = 0.02, .memory = 0.9};
    laws[4].friction.ageing = 0.05;
    laws[5].friction.roughness.share = 0.1;
    laws[6].friction.law = FrictionLaw::logarithmic;
    laws[7].friction.law = FrictionLaw::dahl;
    laws[7].friction.viscous = 4.2;
    laws[8].friction.law = FrictionLaw::lugre;
    return laws;
}

double integrated_distance(const walker::WalkerSetting& setting, double tolerance) {
    walker::IntegratedWalker walker{setting, 0, tolerance};
    walker::MuHistory history{setting.friction.change, 1 / setting.frequency};
    for (int k = 0; k < error_periods; ++k) {
        walker.set_mu_factor(history.next());
        walker.advance_period();
    }
    return walker.now().x;
}

/// Rows of one law at 2 g, phi pi/2, where the walker sticks. Errors as above, against the integrator at its
/// smallest tolerance.
void add_law(bench::Table& table, const BenchLaw& law) {
    walker::WalkerSetting setting = paper_setting(2, std::numbers::pi / 2);
    setting.friction = law.friction;
    const double scale = error_periods * 2 * paper_g / two_pi / setting.frequency / setting.frequency;
    const double right = integrated_distance(setting, 1e-13);
    if (law.friction.closed_form()) {
        walker::ChangingWalker walker{setting};
        for (int k = 0; k < error_periods; ++k) walker.advance_period();
        const double error = std::abs(walker.now().x - right);
        table.add(row(law.name, "event-driven", median_ns(2000, [&] { return walker.advance_period(); }),
                      error / scale, "with a start for each period"));
    }
    for (const double tolerance : {1e-4, 1e-6, 1e-8, 1e-10}) {
        walker::IntegratedWalker walker{setting, 0, tolerance};
        for (int k = 0; k < error_periods; ++k) walker.advance_period();
        const double ns = median_ns(50, [&] { return walker.advance_period(); });
        table.add(row(law.name, "odeint", ns,
                      std::abs(integrated_distance(setting, tolerance) - right) / scale,
                      "tolerance 1e" + std::to_string(std::lround(std::log10(tolerance)))));
    }
}

}  // namespace
}  // namespace shaker

int main(int argc, char** argv) {
    using namespace shaker;
    bench::Table table;
    const double sincos = sincos_ns();
    table.add(row("-", "one dependent sincos", sincos, NAN, "each waits for the one before"));
    for (const BenchDrive& drive : {BenchDrive{"0.5 g, phi 0", paper_setting(0.5, 0)},
                                    BenchDrive{"2 g, phi pi/2", paper_setting(2, std::numbers::pi / 2)},
                                    BenchDrive{"3 g, phi 0", paper_setting(3, 0)},
                                    BenchDrive{"50 g, phi pi/2", paper_setting(50, std::numbers::pi / 2)},
                                    BenchDrive{"16 harmonics", sixteen_harmonics()}}) {
        add_drive(table, drive, sincos);
    }
    for (const BenchLaw& law : bench_laws()) add_law(table, law);
    table.print(argc, argv);
}
