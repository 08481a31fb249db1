// The whole daemon with random orders and faults on virtual time: laws broken, coverage, speed
//   --seeds N (50)   --first S (1): the first seed   --seconds T: as many seeds as fit instead
//   --jobs N (2): seeds at a time   --done FILE: keeps the outcomes of seeds that broke no law, and leaves
//   these seeds out
//   --seed S: one seed; prints its plan, and the shortest plan if it breaks a law
//   --folder PATH (the temporary one)
#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cstdio>

#include "tests/bench/option.hpp"
#include "tests/bench/table.hpp"
#include "tests/orders/campaign.hpp"
#include "tests/orders/simulation.hpp"

namespace {

using namespace shaker;

int show_seed(std::uint64_t seed, const std::filesystem::path& folder) {
    const orders::Plan plan = orders::plan_of(seed);
    const orders::Outcome outcome = orders::simulate(plan, folder / "run");
    std::fputs(text(plan).c_str(), stdout);
    fmt::print("{:.3f} s played, {} aborts, {} trips, {} recordings, volts {:016x}\n", outcome.virtual_s,
               outcome.aborts, outcome.trips, outcome.recordings, outcome.fingerprint);
    std::fflush(stdout);
    for (const orders::Violation& v : outcome.violations)
        fmt::print("BROKEN {}: at {:.4f} s {}\n", v.law, v.at_s, v.words);
    if (outcome.violations.empty()) return 0;
    const orders::Plan least = shortest(plan, folder / "shorter");
    fmt::print("shortest plan:\n{}its events:\n{}\n", text(least),
               fmt::join(simulate(least, folder / "shortest").log, "\n"));
    return 1;
}

}  // namespace

int main(int argc, char** argv) {
    spdlog::set_level(spdlog::level::off);
    const auto folder = bench::own_folder(argc, argv, "orders");
    const auto number = [&](const char* name, int otherwise) {
        return bench::whole_option(argc, argv, name, otherwise, 0);
    };
    int status = 0;
    if (const int seed = number("--seed", 0); seed > 0) {
        status = show_seed(static_cast<std::uint64_t>(seed), folder);
    } else {
        const orders::Campaign campaign{.first = static_cast<std::uint64_t>(number("--first", 1)),
                                        .seeds = static_cast<std::uint64_t>(number("--seeds", 50)),
                                        .most_s = static_cast<double>(number("--seconds", 0)),
                                        .jobs = std::max(1, number("--jobs", 2)),
                                        .done = bench::option(argc, argv, "--done", ""),
                                        .folder = folder};
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
        bench::Table met;
        for (const auto& p : totals.coverage.pairs())
            met.add({{"pair", p.what},
                     {"all", static_cast<double>(p.all)},
                     {"met", static_cast<double>(p.met)},
                     {"met ten times", static_cast<double>(p.ten_times)}});
        met.add({{"pair", std::string{"state, order, fault, fault"}},
                 {"met", static_cast<double>(totals.coverage.fourfold()), "", 6}});
        met.print(argc, argv);
        for (const auto& [broken, why] : totals.broken) fmt::print("seed {}: {}\n", broken, why);
        for (const auto& p : totals.coverage.pairs())
            if (totals.seeds >= 1000 && !p.rare.empty())
                fmt::print("met less than ten times ({}): {}\n", p.what, fmt::join(p.rare, ", "));
        for (const auto& p : totals.coverage.pairs())
            if (!p.impossible.empty()) {
                fmt::print("met, although impossible: {}\n", fmt::join(p.impossible, ", "));
                status = 1;
            }
        if (!totals.broken.empty()) status = 1;
    }
    std::filesystem::remove_all(folder);
    return status;
}
