// The whole daemon with random orders and faults on virtual time: laws broken, coverage, speed
//   --seeds N (50)   --first S (1): the first seed   --jobs N (2): seeds at a time
//   --done FILE: keeps the outcomes of seeds that broke no law, and leaves these seeds out
//   --plans FOLDER: gets the shortest plan of each seed that broke a law, as a file for tests/orders/plans
//   --seed S: one seed; prints its plan, and the shortest plan if it breaks a law
//   --folder PATH (the temporary one)
#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cstdio>

#include "tests/bench/option.hpp"
#include "tests/bench/table.hpp"
#include "tests/orders/alone.hpp"
#include "tests/orders/campaign.hpp"
#include "tests/orders/plan_text.hpp"

namespace {

using namespace shaker;

int show_seed(std::uint64_t seed, const std::filesystem::path& folder, const std::filesystem::path& plans) {
    const orders::Plan plan = orders::plan_of(seed);
    const orders::Outcome outcome = orders::play_alone(plan, folder / "run");
    std::fputs(text(plan).c_str(), stdout);
    fmt::print("{:.3f} s played, {} aborts, {} trips, {} recordings, volts {:016x}\n", outcome.virtual_s,
               outcome.aborts, outcome.trips, outcome.recordings, outcome.fingerprint);
    std::fflush(stdout);
    for (const orders::Violation& v : outcome.violations) fmt::print("BROKEN {}\n", text(v));
    if (outcome.violations.empty()) return 0;
    const orders::Shortest least = shortest(plan, outcome, folder);
    const orders::Violation& why = least.outcome.violations.front();
    fmt::print("shortest plan:\n# {}\n{}its events:\n{}\n", text(why), text(least.plan),
               fmt::join(least.outcome.log, "\n"));
    if (!plans.empty()) {
        write_plan(orders::plan_file(plans, seed), least.plan, why);
        fmt::print("written: {}\n", orders::plan_file(plans, seed).string());
    }
    return 1;
}

void print_coverage(int argc, char** argv, const std::vector<orders::Coverage::Pairs>& pairs,
                    std::size_t fourfold) {
    bench::Table met;
    for (const auto& p : pairs)
        met.add({{"pair", p.what},
                 {"all", static_cast<double>(p.all)},
                 {"met", static_cast<double>(p.met)},
                 {"met ten times", static_cast<double>(p.ten_times)}});
    met.add(
        {{"pair", std::string{"state, order, fault, fault"}}, {"met", static_cast<double>(fourfold), "", 6}});
    met.print(argc, argv);
}

int show_campaign(int argc, char** argv, const orders::Campaign& campaign) {
    const orders::Totals totals = orders::play(campaign);
    bench::Table table;
    table.add({{"seeds", static_cast<double>(totals.seeds)},
               {"broken", static_cast<double>(totals.broken.size())},
               {"simulated", totals.virtual_s / 3600, "h"},
               {"speed", totals.played_s / totals.wall_s, "x real time"},
               {"aborts", static_cast<double>(totals.aborts), "", 6},
               {"trips", static_cast<double>(totals.trips), "", 6},
               {"recordings replayed", static_cast<double>(totals.recordings), "", 6},
               {"recovered after a kill", static_cast<double>(totals.recovered), "", 6},
               {"abort to silence, worst", 1e3 * totals.slowest_abort_s, "ms"},
               {"most memory", totals.most_bytes / 1e6, "MB"}});
    table.print(argc, argv);
    const auto pairs = totals.coverage.pairs();
    print_coverage(argc, argv, pairs, totals.coverage.fourfold());
    int status = totals.broken.empty() ? 0 : 1;
    for (const auto& [broken, why] : totals.broken) fmt::print("seed {}: {}\n", broken, why);
    if (!totals.broken.empty() && !campaign.plans.empty())
        fmt::print("shortest plans: {}/seed_N.plan\n", campaign.plans.string());
    for (const auto& p : pairs)
        if (totals.seeds >= 1000 && !p.rare.empty())
            fmt::print("met less than ten times ({}): {}\n", p.what, fmt::join(p.rare, ", "));
    for (const auto& p : pairs)
        if (!p.impossible.empty()) {
            fmt::print("met, although impossible: {}\n", fmt::join(p.impossible, ", "));
            status = 1;
        }
    return status;
}

}  // namespace

int main(int argc, char** argv) {
    spdlog::set_level(spdlog::level::off);
    const auto folder = bench::own_folder(argc, argv, "orders");
    const auto number = [&](const char* name, int otherwise) {
        return bench::whole_option(argc, argv, name, otherwise, 0);
    };
    const std::filesystem::path plans = bench::option(argc, argv, "--plans", "");
    int status = 0;
    if (const int seed = number("--seed", 0); seed > 0)
        status = show_seed(static_cast<std::uint64_t>(seed), folder, plans);
    else
        status = show_campaign(argc, argv,
                               {.first = static_cast<std::uint64_t>(number("--first", 1)),
                                .seeds = static_cast<std::uint64_t>(number("--seeds", 50)),
                                .jobs = std::max(1, number("--jobs", 2)),
                                .done = bench::option(argc, argv, "--done", ""),
                                .plans = plans,
                                .folder = folder});
    std::filesystem::remove_all(folder);
    return status;
}
