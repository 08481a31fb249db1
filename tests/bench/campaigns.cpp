// Campaigns on the simulated bench: random plans in random views, kills in the middle of one, live repeats
//   --plans N (20): random plans   --seed N (1): of the first   --kills N (0): of --plan PLAN, at random
//   moments   --repeats N (0): measurements of one set-point and its mirror partner, with the loop closed
//   --folder PATH (the temporary one)
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>

#include "daemon/campaign/campaign_folder.hpp"
#include "daemon/campaign/points_table.hpp"
#include "tests/bench/option.hpp"
#include "tests/bench/table.hpp"
#include "tests/support/campaign/killed_campaign.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/program.hpp"

namespace {

using namespace shaker;

constexpr double mm_per_px = 0.4;

struct Sums {
    int plans = 0, points = 0, fit = 0, fit_measured = 0, failed = 0, without_reason = 0, trips = 0;
    double bench_s = 0, returning_s = 0;
    std::vector<double> return_errors_mm;
};

/// Writes a plan of 4 to 10 points and its scene.
void draw(std::uint64_t seed, const std::filesystem::path& folder) {
    std::mt19937_64 random{seed};
    std::uniform_real_distribution<double> unit{0, 1};
    const double view_mm = 60 + 100 * unit(random);
    const double way_mm = std::max(0.0, view_mm - 30 - 14);
    std::ofstream scene{folder / "scene.toml"};
    scene << fmt::format("seed = {}\n[walker]\nstart_mm = {}\n", seed, way_mm * (unit(random) - 0.5));
    for (const char* camera : {"top", "side"})
        scene << fmt::format("[{}]\nwidth_px = {}\n", camera, std::lround(view_mm / mm_per_px));
    std::ofstream plan{folder / "plan.toml"};
    plan << "[point]\nperiods = 20\n";
    for (int points = 4 + static_cast<int>(7 * unit(random)); points > 0; --points)
        plan << fmt::format("[[series]]\ngamma = \"{:.3f}g\"\nphi = {:.4f}\n", 0.15 + 2.85 * unit(random),
                            two_pi * unit(random));
}

void add(const std::filesystem::path& folder, Sums& sums) {
    const test::Outcome checked =
        test::shakerd("campaign plan.toml --scene scene.toml --check --json", folder);
    const test::Outcome run = test::shakerd("campaign plan.toml --scene scene.toml -o points", folder);
    ++sums.plans;
    if (run.status == 5) ++sums.trips;
    if (!std::filesystem::exists(folder / "points" / campaign::table_name)) {
        fmt::print(stderr, "{}: {}{}\n", folder.string(), run.out, run.err);
        return;
    }
    const auto check = nlohmann::json::parse(checked.out);
    const auto table = campaign::read_points(folder / "points" / campaign::table_name);
    for (std::size_t i = 0; i < table.points.size(); ++i) {
        const campaign::PointRow& row = table.points[i];
        const bool fits = check["points"][i]["fits"].get<bool>(), measured = row.outcome == "measured";
        ++sums.points;
        sums.fit += fits ? 1 : 0;
        sums.fit_measured += fits && measured ? 1 : 0;
        sums.failed += measured ? 0 : 1;
        sums.without_reason += !measured && row.reason.empty() ? 1 : 0;
    }
    for (const campaign::JournalEntry& entry : campaign::read_campaign(folder / "points").entries)
        if (const auto* r = std::get_if<campaign::Returned>(&entry.what)) {
            sums.returning_s += r->for_s;
            sums.return_errors_mm.push_back(1e3 * std::abs(r->x_to_m - r->x_asked_m));
        }
    const std::size_t at = run.out.find("points measured; ");
    if (at != std::string::npos) sums.bench_s += std::stod(run.out.substr(at + 17));
}

int play_plans(int argc, char** argv, const std::filesystem::path& folder, int count) {
    const int first = bench::whole_option(argc, argv, "--seed", 1, 0);
    Sums sums;
    for (int i = 0; i < count; ++i) {
        const std::filesystem::path own = folder / fmt::format("plan-{}", first + i);
        std::filesystem::create_directories(own);
        draw(static_cast<std::uint64_t>(first + i), own);
        add(own, sums);
    }
    std::ranges::sort(sums.return_errors_mm);
    const auto error_mm = [&](double share) {
        if (sums.return_errors_mm.empty()) return std::nan("");
        const auto n = static_cast<double>(sums.return_errors_mm.size() - 1);
        return sums.return_errors_mm[static_cast<std::size_t>(share * n)];
    };
    bench::Table table;
    table.add({{"plans", static_cast<double>(sums.plans)},
               {"trips", static_cast<double>(sums.trips)},
               {"points", static_cast<double>(sums.points)},
               {"fit by --check", static_cast<double>(sums.fit)},
               {"of these measured", 100.0 * sums.fit_measured / std::max(1, sums.fit), "%"},
               {"failed", static_cast<double>(sums.failed)},
               {"without a reason", static_cast<double>(sums.without_reason)},
               {"bench time", sums.bench_s, "s", 5},
               {"of it returning", 100 * sums.returning_s / std::max(1.0, sums.bench_s), "%"},
               {"returns", static_cast<double>(sums.return_errors_mm.size())},
               {"go-to-x error, median", error_mm(0.5), "mm"},
               {"95 %", error_mm(0.95), "mm"}});
    table.print(argc, argv);
    return sums.trips == 0 && sums.without_reason == 0 ? 0 : 1;
}

int play_kills(int argc, char** argv, const std::filesystem::path& folder, int count) {
    const std::filesystem::path plan =
        bench::option(argc, argv, "--plan", test::source_dir() + "/daemon/campaign/plans/fig3.toml");
    const test::KilledCampaigns campaigns{std::filesystem::absolute(plan), folder};
    std::mt19937_64 random{static_cast<std::uint64_t>(bench::whole_option(argc, argv, "--seed", 1, 0))};
    std::uniform_real_distribution<double> share{0, 1};
    bench::Table table;
    bool good = true;
    for (int i = 1; i <= count; ++i) {
        const double after_s = campaigns.lasts_s() * share(random);
        const test::Killed one = campaigns.kill(after_s, i);
        for (const std::string& finding : one.findings) fmt::print(stderr, "kill {}: {}\n", i, finding);
        good = good && one.findings.empty();
        table.add({{"kill", static_cast<double>(i)},
                   {"after", after_s, "s"},
                   {"killed", std::string{one.killed ? "yes" : "it had ended"}},
                   {"points ended before", static_cast<double>(one.ended_before)},
                   {"differences", static_cast<double>(one.findings.size())}});
    }
    table.print(argc, argv);
    return good ? 0 : 1;
}

// Scatter of live repeats over their stated error, and the distance from the truth in stated errors.
void add_repeats(const std::string& name, const std::string& walker, int repeats,
                 const std::filesystem::path& folder, bench::Table& table) {
    std::filesystem::create_directories(folder);
    std::ofstream{folder / "scene.toml"} << "[top]\npositions = 1\n[side]\npositions = 1\n[walker]\n"
                                         << walker;
    std::ofstream{folder / "plan.toml"} << fmt::format(
        "[[series]]\ngamma = \"1g\"\nphi = \"0deg\"\norder = \"mirror\"\nperiods = 20\nrepeats = {}\n",
        repeats / 2);
    test::shakerd("campaign plan.toml --scene scene.toml -o points", folder);
    std::array<std::vector<calibration::Estimate>, 2> measured;  // set-point, mirror partner
    double squares = 0, within = 0, count = 0;
    for (const campaign::PointRow& row :
         campaign::read_points(folder / "points" / campaign::table_name).points) {
        if (row.outcome != "measured") continue;
        measured[row.v_D.value > 0 ? 0 : 1].push_back(row.v_D);
        const double z = (row.v_D.value - row.true_v_D) / row.v_D.sigma;
        squares += z * z;
        within += std::abs(z) < 2 ? 1 : 0;
        count += 1;
    }
    double scatter = 0, stated = 0, freedom = 0;
    for (const auto& some : measured) {
        double mean = 0;
        for (const auto& v : some) mean += v.value / static_cast<double>(some.size());
        for (const auto& v : some) {
            scatter += (v.value - mean) * (v.value - mean);
            stated += v.sigma * v.sigma;
        }
        freedom += static_cast<double>(some.size()) - 1;
    }
    table.add({{"live repeats", name},
               {"measured", count},
               {"stated error", 1e6 * std::sqrt(stated / count), "um/s"},
               {"scatter", 1e6 * std::sqrt(scatter / freedom), "um/s"},
               {"scatter / stated", std::sqrt(scatter / freedom / (stated / count))},
               {"z rms", std::sqrt(squares / count)},
               {"within 2 errors", 100 * within / count, "%"}});
}

int play_repeats(int argc, char** argv, const std::filesystem::path& folder, int repeats) {
    bench::Table table;
    add_repeats("steady friction", "", repeats, folder / "steady", table);
    add_repeats("jitter 1 %", "mu_jitter = 0.01\n", repeats, folder / "jitter", table);
    add_repeats("jitter 2 %, memory 0.5", "mu_jitter = 0.02\nmu_memory = 0.5\n", repeats, folder / "memory",
                table);
    table.print(argc, argv);
    return 0;
}

}  // namespace

int main(int argc, char** argv) {
    const auto folder = bench::own_folder(argc, argv, "campaigns");
    const int kills = bench::whole_option(argc, argv, "--kills", 0, 0);
    const int repeats = bench::whole_option(argc, argv, "--repeats", 0, 0);
    const int status =
        kills > 0     ? play_kills(argc, argv, folder, kills)
        : repeats > 0 ? play_repeats(argc, argv, folder, repeats)
                      : play_plans(argc, argv, folder, bench::whole_option(argc, argv, "--plans", 20, 1));
    if (status == 0) std::filesystem::remove_all(folder);
    return status;
}
