// Recordings in progress that "recover", also of a copy, a second recorder or a file of the name meet at
// random moments
//   --count N (200)   --seed N (1)   --jobs N (2): runs at a time   --folder PATH (the temporary one)
#include "tests/support/recording/intrusions.hpp"

#include <array>
#include <cstdio>

#include "tests/bench/option.hpp"
#include "tests/bench/table.hpp"

int main(int argc, char** argv) {
    using namespace shaker;
    const int count = bench::whole_option(argc, argv, "--count", 200, 1);
    const auto seed = static_cast<std::uint64_t>(bench::whole_option(argc, argv, "--seed", 1, 0));
    const int jobs = bench::whole_option(argc, argv, "--jobs", 2, 1);
    const auto folder = bench::own_folder(argc, argv, "shakerd-intrusions");
    struct Sum {
        double runs = 0, produced = 0, dropped = 0, lost = 0, replaced = 0, wrong = 0;
    };
    std::array<Sum, test::intruders> sums;
    for (const test::Intrusion& one : test::intrusions(count, seed, jobs, folder)) {
        Sum& sum = sums.at(static_cast<std::size_t>(one.intruder));
        ++sum.runs;
        sum.produced += static_cast<double>(one.produced);
        sum.dropped += static_cast<double>(one.dropped);
        sum.lost += static_cast<double>(one.lost);
        sum.replaced += one.replaced ? 1 : 0;
        sum.wrong += one.wrong.empty() ? 0 : 1;
        if (!one.wrong.empty())
            std::fprintf(stderr, "%s at %.3f s: %s\n", name(one.intruder), one.at_s, one.wrong[0].c_str());
    }
    bench::Table table;
    for (std::size_t i = 0; i < sums.size(); ++i)
        table.add({{"intruder", name(static_cast<test::Intruder>(i))},
                   {"recordings", sums[i].runs},
                   {"pictures produced", sums[i].produced, "", 8},
                   {"dropped by a full queue", sums[i].dropped, "", 8},
                   {"pictures lost", sums[i].lost},
                   {"files replaced", sums[i].replaced},
                   {"runs with an error", sums[i].wrong}});
    table.print(argc, argv);
    std::error_code ignored;
    std::filesystem::remove(folder, ignored);  // failed runs are kept
}
