// A recording after a power cut at any moment of a run, in three models of the content of the disk
//   --count N (500): images in all   --seed N (1)   --jobs N (2): images at a time
//   --folder PATH (the temporary one)
#include "tests/support/recording/power_cuts.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cstdio>
#include <string>

#include "tests/bench/option.hpp"
#include "tests/bench/table.hpp"
#include "tests/support/in_parallel.hpp"

namespace {

using namespace shaker;
using test::PowerCut;
using test::Surviving;

struct Cuts {
    std::vector<PowerCut> all;
    std::uint64_t seed;
};

Cuts cuts(const test::PowerCuts& run, Surviving surviving, int count, std::uint64_t seed, int jobs,
          const std::filesystem::path& folder) {
    Cuts cuts{std::vector<PowerCut>(static_cast<std::size_t>(count)), seed};
    test::in_parallel(count, jobs, [&](int i) {
        const auto k = static_cast<std::size_t>(i);
        const std::filesystem::path image = folder / fmt::format("image-{}", i);
        std::filesystem::create_directories(image);
        cuts.all[k] = run.cut(surviving, seed + k, image);
        std::filesystem::remove_all(image);
    });
    return cuts;
}

bench::Row row(const test::PowerCuts& run, Surviving surviving, const Cuts& cuts) {
    std::size_t recovered = 0, synced = 0, before = 0, none_before = 0;
    double lost = 0, bad = 0, saved = 0;
    for (std::size_t k = 0; k < cuts.all.size(); ++k) {
        const PowerCut& c = cuts.all[k];
        ++(c.anything_synced ? synced : none_before);
        if (c.recovered) ++(c.anything_synced ? recovered : before);
        lost += static_cast<double>(c.synced_lost);
        bad += static_cast<double>(c.bad);
        saved += static_cast<double>(c.unsynced_saved);
        if (!c.words.empty() && c.anything_synced)
            std::fprintf(stderr, "%s, seed %s: %s\n", name(surviving), std::to_string(cuts.seed + k).c_str(),
                         c.words.c_str());
    }
    return {
        {"what survives", name(surviving)},
        {"recovered", fmt::format("{} of {}", recovered, synced)},
        {"cut before the first sync, recovered", fmt::format("{} of {}", before, none_before)},
        {"synced rows lost", lost},
        {"undetected bad rows", bad},
        {"unsynced rows saved an image", saved / static_cast<double>(std::max<std::size_t>(1, recovered))},
        {"calls", static_cast<double>(run.calls()), "", 6},
        {"syncs of the series", static_cast<double>(run.syncs())}};
}

}  // namespace

int main(int argc, char** argv) {
    const int count = bench::whole_option(argc, argv, "--count", 500, 3);
    const auto seed = static_cast<std::uint64_t>(bench::whole_option(argc, argv, "--seed", 1, 0));
    const int jobs = bench::whole_option(argc, argv, "--jobs", 2, 1);
    const auto folder = bench::own_folder(argc, argv, "shakerd-power-cuts");
    bench::Table table;
    {
        const test::PowerCuts run{folder};
        int left = count;
        int models = 3;
        for (const Surviving s : {Surviving::all, Surviving::half, Surviving::synced}) {
            const int some = left / models--;
            left -= some;
            table.add(row(run, s, cuts(run, s, some, seed, jobs, folder)));
        }
    }
    std::filesystem::remove_all(folder);
    table.print(argc, argv);
}
