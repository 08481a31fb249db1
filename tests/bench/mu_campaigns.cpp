// Campaigns on simulated benches with drawn friction, tilt and noise: bias, scatter and coverage of the fits
//   --count N (20): campaigns   --seed N (1): of the first   --jobs N (2): at a time
//   --mu VALUE: the same friction in all of them, instead of 0.07 to 0.2   --folder PATH (the temporary one)
//   --lowpass HZ (1000): of the accelerometer, which states it with an error of 10 %
//   --jitter SHARE (0), --memory R (0): of mu, from period to period   --periods N (40): of a point
//   --times N (0): bench time against error, of the adaptive choice, of even sweeps and of the paper's
//   procedure, on N benches
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <random>
#include <thread>

#include "tests/bench/option.hpp"
#include "tests/bench/table.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/program.hpp"

namespace {

using namespace shaker;

struct Truth {
    double mu = 0, tilt = 0;  // rad
};
struct Benches {
    double mu = NAN;  // of all, or drawn
    double lowpass_hz = 1000;
    double jitter = 0, memory = 0;  // of mu
    int periods = 40;
};

/// What the campaigns say of one quantity: z are errors over stated errors; chi^2 of fits over its freedom.
struct Found {
    std::string unit;
    double scale = 1;
    std::vector<double> errors, z;
    double chi2 = 0, freedom = 0;
};

Truth draw(std::uint64_t seed, const Benches& benches, const std::filesystem::path& folder) {
    std::mt19937_64 random{seed};
    std::uniform_real_distribution<double> unit{0, 1};
    const double drawn = 0.07 + 0.13 * unit(random);
    const Truth truth{std::isfinite(benches.mu) ? benches.mu : drawn, 2e-3 * (unit(random) - 0.5)};
    std::ofstream{folder / "scene.toml"} << fmt::format(
        "seed = {0}\ntilt_deg = {1}\n[walker]\nmu_k = {2}\nmu_s = {2}\nmu_jitter = {4}\nmu_memory = {5}\n"
        "[accelerometer]\nlowpass_hz = {3}\ntold_low_pass_hz = {3}\n",
        seed, truth.tilt * 180 / M_PI, truth.mu, benches.lowpass_hz, benches.jitter, benches.memory);
    return truth;
}

/// The fits of a campaign; empty when it failed. bench_s: its bench time.
nlohmann::json measured(const std::filesystem::path& folder, const std::string& plan,
                        double* bench_s = nullptr) {
    const auto run = test::shakerd(fmt::format("campaign {} --scene scene.toml -o points", plan), folder);
    const auto fits = test::shakerd("mu points --json", folder);
    if (run.status != 0 || fits.status != 0) {
        fmt::print(stderr, "{}: {}{}{}\n", folder.string(), run.out, run.err, fits.err);
        return nlohmann::json::array();
    }
    const std::size_t at = run.out.find("points measured; ");
    if (bench_s != nullptr && at != std::string::npos) *bench_s = std::atof(run.out.c_str() + at + 17);
    return nlohmann::json::parse(fits.out)["fits"];
}

/// Three gammas at equal phases, about the null phases of mu 0.07 to 0.2.
constexpr const char* plan =
    "[[series]]\ngamma = [\"0.68g\", \"1g\", \"2g\"]\nperiods = {}\n"
    "phi = {{from = \"1.75rad\", to = \"2.8rad\", steps = 4}}\norder = \"mirror\"\n";

void add(const std::filesystem::path& folder, const Truth& truth, int periods,
         std::map<std::string, Found>& all, std::mutex& guard) {
    std::ofstream{folder / "plan.toml"} << fmt::format(plan, periods);
    const auto fits = measured(folder, "plan.toml");
    const std::scoped_lock lock{guard};
    for (const auto& fit : fits) {
        const std::string name = fit["name"];
        if (!fit["value"].is_number() || !fit["error"].is_number()) continue;
        const double value = fit["value"];
        const auto take = [&](const char* unit, double scale, double true_value) {
            Found& found = all[name];
            found.unit = unit;
            found.scale = scale;
            found.errors.push_back(value - true_value);
            found.z.push_back(found.errors.back() / fit["error"].get<double>());
            if (!fit["chi2"].is_number()) return;
            found.chi2 += fit["chi2"].get<double>();
            found.freedom += fit["freedom"].get<double>();
        };
        if (name == "mu_ac" || name == "mu_k") take("1e-6", 1e6, truth.mu);
        if (name == "tilt") take("urad", 1e6, truth.tilt);
        if (name == "phi_0" && fit["truth"].is_number()) take("urad", 1e6, fit["truth"]);
        if (name == "gamma of reversal" && fit["truth"].is_number()) take("mm/s^2", 1e3, fit["truth"]);
    }
}

struct Procedure {
    std::string name, plan, fit;
};

/// 14 gammas from 0.4 to 3 g and 12 phases are the candidates of the adaptive choice; even sweeps have every
/// n-th of them.
std::vector<Procedure> procedures() {
    constexpr const char* series = "[[series]]\norder = \"mirror\"\n";
    std::vector<Procedure> all;
    for (const auto& [target, periods] : {std::pair{0.5, 5}, {0.2, 10}, {0.05, 20}, {0.02, 40}, {0.01, 40}})
        all.push_back({fmt::format("adaptive, {} %, {} periods", target, periods),
                       fmt::format("stop_at = \"mu {} %\"\n{}periods = {}\n"
                                   "gamma = {{from = \"0.4g\", to = \"3g\", steps = 13}}\n"
                                   "phi = {{from = \"0deg\", to = \"165deg\", steps = 11}}\n",
                                   target, series, periods),
                       "mu_ac"});
    for (const auto& [gammas, phases] : {std::pair{1, 1}, {1, 3}, {3, 3}, {5, 5}})
        all.push_back({fmt::format("even sweep, {} gammas x {} phases", gammas + 1, phases + 1),
                       fmt::format("{}gamma = {{from = \"0.4g\", to = \"3g\", steps = {}}}\n"
                                   "phi = {{from = \"0deg\", to = \"{}deg\", steps = {}}}\n",
                                   series, gammas, 180 * phases / (phases + 1), phases),
                       "mu_ac"});
    const std::string around = "phi = {from = \"1.59rad\", to = \"2.71rad\", steps = 5}\n";
    all.push_back({"the paper's: null phases at 8 gammas, 6 phases each",
                   fmt::format("{}gamma = {{from = \"0.5g\", to = \"3g\", steps = 7}}\n{}", series, around),
                   "mu_ns"});
    return all;
}

/// One table: bench time and error of mu for each procedure, over `count` benches.
bench::Table times(int count, int first, const Benches& benches, const std::filesystem::path& folder) {
    bench::Table table;
    for (const Procedure& p : procedures()) {
        double bench_s = 0, points = 0, squares = 0, stated = 0, n = 0;
        for (int i = 0; i < count; ++i) {
            const std::filesystem::path own = folder / "times";
            std::filesystem::remove_all(own);
            std::filesystem::create_directories(own);
            const Truth truth = draw(static_cast<std::uint64_t>(first + i), benches, own);
            std::ofstream{own / "plan.toml"} << p.plan;
            double spent_s = 0;
            for (const auto& fit : measured(own, "plan.toml", &spent_s)) {
                if (fit["name"] != p.fit || !fit["value"].is_number()) continue;
                squares += std::pow(fit["value"].get<double>() / truth.mu - 1, 2);
                stated += std::pow(fit["error"].get<double>() / truth.mu, 2);
                points += fit["points"].get<double>();
                bench_s += spent_s;
                ++n;
            }
        }
        table.add({{"procedure", p.name},
                   {"fit", p.fit},
                   {"benches", n},
                   {"points", points / n},
                   {"bench time", bench_s / n, "s"},
                   {"error of mu, rms", 100 * std::sqrt(squares / n), "%"},
                   {"stated", 100 * std::sqrt(stated / n), "%"}});
    }
    return table;
}

}  // namespace

int main(int argc, char** argv) {
    const auto folder = bench::own_folder(argc, argv, "mu-campaigns");
    const int count = bench::whole_option(argc, argv, "--count", 20, 2);
    const int first = bench::whole_option(argc, argv, "--seed", 1, 0);
    const Benches drawn{.mu = std::atof(bench::option(argc, argv, "--mu", "nan").c_str()),
                        .lowpass_hz = std::atof(bench::option(argc, argv, "--lowpass", "1000").c_str()),
                        .jitter = std::atof(bench::option(argc, argv, "--jitter", "0").c_str()),
                        .memory = std::atof(bench::option(argc, argv, "--memory", "0").c_str()),
                        .periods = bench::whole_option(argc, argv, "--periods", 40, 3)};
    if (const int benches = bench::whole_option(argc, argv, "--times", 0, 0); benches > 0) {
        times(benches, first, drawn, folder).print(argc, argv);
        std::filesystem::remove_all(folder);
        return 0;
    }
    std::map<std::string, Found> all;
    std::mutex guard;
    std::atomic<int> next{0};
    {
        std::vector<std::jthread> jobs;
        for (int job = bench::whole_option(argc, argv, "--jobs", 2, 1); job > 0; --job)
            jobs.emplace_back([&] {
                for (int i = next++; i < count; i = next++) {
                    const std::filesystem::path own = folder / std::to_string(first + i);
                    std::filesystem::create_directories(own);
                    const Truth truth = draw(static_cast<std::uint64_t>(first + i), drawn, own);
                    add(own, truth, drawn.periods, all, guard);
                    std::filesystem::remove_all(own);
                }
            });
    }
    bench::Table table;
    for (const auto& [name, found] : all) {
        const auto n = static_cast<double>(found.errors.size());
        double mean = 0, squares = 0, z2 = 0;
        for (const double e : found.errors) mean += e / n;
        for (const double e : found.errors) squares += (e - mean) * (e - mean) / (n - 1);
        for (const double z : found.z) z2 += z * z / n;
        const auto within = std::ranges::count_if(found.z, [](double z) { return std::abs(z) < 2; });
        table.add({{"fit", name},
                   {"fits", n},
                   {"unit", found.unit},
                   {"mean error", found.scale * mean},
                   {"of the mean", found.scale * std::sqrt(squares / n)},
                   {"scatter", found.scale * std::sqrt(squares)},
                   {"z rms", std::sqrt(z2)},
                   {"within 2 errors", static_cast<double>(within) / n},
                   {"chi^2 over freedom", found.freedom > 0 ? found.chi2 / found.freedom : NAN}});
    }
    table.print(argc, argv);
    std::filesystem::remove_all(folder);
    return 0;
}
