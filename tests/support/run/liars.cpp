#include "tests/support/run/liars.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <fstream>
#include <numbers>
#include <random>

#include "daemon/run/runner.hpp"
#include "tests/support/run/bench_on_call.hpp"

namespace shaker::test {

namespace {

constexpr double beyond = 1.25;  // times the limit

std::string sensor(const std::string& keys) { return "[accelerometer]\n" + keys; }
std::string camera(const std::string& name, double true_over_told) {
    return fmt::format("[{}]\ntrue_mm_per_px = {}\n", name, 0.4 * true_over_told);
}

double peak_mm(const Drive& drive) {
    double most = 0;
    for (int i = 0; i < 2000; ++i) {
        std::complex<double> x = 0;
        for (int q = 1; q <= max_harmonics; ++q)
            x -= harmonics(drive).at(q) / std::pow(two_pi * drive.frequency * q, 2) *
                 std::polar(1.0, two_pi * q * i / 2000);
        most = std::max(most, std::abs(x.imag()));
    }
    return 1e3 * most;
}

// Largest half range of a period, and the time with more than `limit_mm`.
void follow(const std::vector<simulated::PoseTruth>& poses, double frequency, double limit_mm, Judged& out) {
    std::deque<simulated::PoseTruth> period;
    for (const simulated::PoseTruth& p : poses) {
        period.push_back(p);
        while (seconds(p.time) - seconds(period.front().time) > 1 / frequency) period.pop_front();
        const auto [low, high] = std::ranges::minmax(period, {}, &simulated::PoseTruth::base);
        const double mm = 500 * (high.base - low.base);
        out.largest_mm = std::max(out.largest_mm, mm);
        if (mm > limit_mm && poses.size() > 1)
            out.beyond_s += seconds(poses[1].time) - seconds(poses[0].time);
    }
}

Liar along(double size) {
    return {fmt::format("sensor along the shaker x {:.3g}", size), sensor(fmt::format("gain_x = {}\n", size)),
            size};
}
Liar on_all_axes(double size) {
    return {fmt::format("sensor on all axes x {:.3g}", size),
            sensor(fmt::format("gain_x = {0}\ngain_y = {0}\ngain_z = {0}\n", size)), size};
}
Liar one_camera(double size) {
    return {fmt::format("scale of one camera x {:.3g}", size), camera("side", size), size};
}
Liar both_cameras(double size) {
    return {fmt::format("scale of both cameras x {:.3g}", size), camera("top", size) + camera("side", size),
            size};
}
constexpr std::array instruments{along, on_all_axes, one_camera, both_cameras};

}  // namespace

std::vector<Liar> liars() {
    std::vector<Liar> all{{"nobody", "", 1}};
    for (const auto& instrument : instruments)
        for (const double size : {0.25, 0.4, 0.62, 0.75, 0.9, 1.1, 1.4, 2.0, 4.0})
            all.push_back(instrument(size));
    all.push_back({"sensor's sign, its axis fitted", sensor("gain_x = -1\n"), -1});
    all.push_back({"sensor's sign, its axis given", sensor("gain_x = -1\naxis_told = 1\n"), -1});
    all.push_back({"sensor's axis across", sensor("gain_x = 0.02\ncross_yx = 1\naxis_told = 1\n"), 0.02});
    return all;
}

Liar drawn_liar(unsigned seed) {
    std::mt19937 random{seed};
    const double size =
        std::exp(std::uniform_real_distribution<double>{std::log(0.25), std::log(4.0)}(random));
    const auto which = std::uniform_int_distribution<std::size_t>{0, instruments.size()}(random);
    return which == instruments.size() ? along(-size) : instruments.at(which)(size);
}

Honest drawn_honest(unsigned seed) {
    std::mt19937 random{seed};
    const auto draw = [&](double from, double to) {
        return std::exp(std::uniform_real_distribution<double>{std::log(from), std::log(to)}(random));
    };
    const double f = draw(5, 60), g = draw(0.1, 1.5), rate = draw(100, 1000);
    const double rho = std::uniform_real_distribution<double>{0, 1}(random);
    return {{fmt::format("honest at {:.3g} Hz, {:.2g} g, rho {:.2g}, {:.4g} pictures/s", f, g, rho, rate),
             fmt::format("[top]\nframe_rate_hz = {0}\n[side]\nframe_rate_hz = {0}\n", rate)},
            {.frequency = f, .gamma = g * paper_g, .rho = rho}};
}

Judged judge(const Liar& liar, const std::filesystem::path& folder, bool identify, const Drive& drive) {
    Judged out;
    out.asked_mm = peak_mm(drive);
    out.limit_mm = 1.2 * out.asked_mm;
    // A walker that stays on its base.
    std::string scene = fmt::format(
        "[walker]\nmu_k = 3\nstart_mm = 0\n[limits]\ndisplacement_warn_mm = {0}\n"
        "displacement_abort_mm = {0}\n",
        out.limit_mm);
    for (const char* name : {"top", "side"}) {
        const std::string table = fmt::format("[{}]\n", name), keys = "positions = 1\n";
        scene += table + keys;
        if (const auto at = liar.scene.find(table); at != std::string::npos) {
            const auto from = at + table.size();
            scene += liar.scene.substr(from, liar.scene.find('[', from) - from);
        }
    }
    if (const auto at = liar.scene.find("[accelerometer]"); at != std::string::npos)
        scene += liar.scene.substr(at);
    std::ofstream{folder / "scene.toml"} << scene;
    run::RunnerSettings settings{.run = quick(), .recordings = folder};
    settings.run.scene = folder / "scene.toml";
    settings.run.trips = folder;
    settings.run.drive = drive;
    settings.run.identify = identify;
    settings.run.plan.periods = 40;
    run::Runner runner{settings};
    const run::FinishedRun ended = runner.run();
    out.trip = runner.sequence().trip();
    for (const std::string& note : runner.sequence().notes())
        if (note.find("the base move") != std::string::npos && note.find("camera \"") != std::string::npos)
            out.note = note;
    out.measured = !runner.sequence().measured().empty();
    follow(runner.bench().world->truth(0), drive.frequency, beyond * out.limit_mm, out);
    return out;
}

}  // namespace shaker::test
