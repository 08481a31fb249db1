// Disks that are full, fail or stall during a live run: how the run ends, which part of its recording is
// whole
//   --fault WORDS (all)   --folder PATH (the temporary one)
#include "tests/support/recording/disk_faults.hpp"

#include <cstdio>
#include <string>

#include "tests/bench/option.hpp"
#include "tests/bench/table.hpp"

namespace {

using namespace shaker;

bench::Row row(const test::DiskFault& fault, const test::AfterFault& after) {
    bench::Row r{{"fault", fault.name}, {"exit status", std::to_string(after.status)}};
    if (!fault.refused) {
        r.push_back({"drive", fault.finished           ? "went on"
                              : after.came_down_softly ? "came down softly"
                                                       : "?"});
        r.push_back({"reason recorded", fault.finished ? "-" : after.journal_says_why ? "yes" : "no"});
        r.push_back({"recording whole up to", after.until_s, "s", 4});
        r.push_back({"series missing in it", static_cast<double>(after.missing)});
        r.push_back({"pictures produced", static_cast<double>(after.produced), "", 6});
        r.push_back({"stored", static_cast<double>(after.stored), "", 6});
        r.push_back({"dropped", static_cast<double>(after.dropped), "", 6});
    }
    r.push_back({"verdict", after.wrong.empty() ? "good" : after.wrong.front()});
    return r;
}

}  // namespace

int main(int argc, char** argv) {
    const std::string only = bench::option(argc, argv, "--fault", "");
    const auto folder = bench::own_folder(argc, argv, "shakerd-disk-faults");
    bench::Table table;
    for (const test::DiskFault& fault : test::disk_faults()) {
        if (fault.name.find(only) == std::string::npos) continue;
        std::filesystem::create_directories(folder);
        const test::AfterFault after = test::run_with(fault, folder);
        if (!after.words.empty()) std::fprintf(stderr, "%s: %s", fault.name.c_str(), after.words.c_str());
        table.add(row(fault, after));
        std::filesystem::remove_all(folder);
    }
    table.print(argc, argv);
}
