// Hours of normal operation in virtual time: runs on sound benches with random set-points. No trip is
// allowed.
//   --hours H (1)   --from SEED (1)   --run SECONDS per run (600)
#include "tests/support/safety/endurance.hpp"

#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "tests/bench/table.hpp"
#include "tests/support/cost.hpp"

namespace {

double option(int argc, char** argv, const char* name, double otherwise) {
    for (int i = 1; i + 1 < argc; ++i)
        if (std::strcmp(argv[i], name) == 0) return std::atof(argv[i + 1]);
    return otherwise;
}

}  // namespace

int main(int argc, char** argv) {
    using namespace shaker;
    const double wanted_s = 3600 * option(argc, argv, "--hours", 1), run_s = option(argc, argv, "--run", 600);
    auto seed = static_cast<std::uint64_t>(option(argc, argv, "--from", 1));
    test::Endurance all;
    const double before_ns = bench::cpu_ns();
    while (all.simulated_s < wanted_s) {
        const test::Endurance one = test::endure(seed++, run_s);
        for (const std::string& trip : one.trips) std::fprintf(stderr, "%s\n", trip.c_str());
        all += one;
    }
    bench::Table table;
    table.add({{"simulated", all.simulated_s / 3600, "h", 4},
               {"runs", static_cast<double>(all.runs), "", 6},
               {"set-points", static_cast<double>(all.set_points), "", 6},
               {"at its target", all.locked_s / 3600, "h", 4},
               {"trips", static_cast<double>(all.trips.size())},
               {"processor time", 1e-9 * (bench::cpu_ns() - before_ns), "s", 4}});
    table.print(argc, argv);
    return all.trips.empty() ? 0 : 1;
}
