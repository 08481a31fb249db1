// Damaged recordings, each replayed in a confined child: outcome, and whether the parent is unchanged.
//   --count N (5000)   --seed S (1)   --folder FOLDER (a temporary one)   --keep FOLDER: for mutants
//   whose reader died, timed out or gave no clear message
#include "tests/support/recording/mutants.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>
#include <string>

#include "tests/bench/table.hpp"

namespace {

using namespace shaker;
using test::Fate;

std::string option(int argc, char** argv, const char* name, const std::string& otherwise) {
    for (int i = 1; i + 1 < argc; ++i)
        if (std::strcmp(argv[i], name) == 0) return argv[i + 1];
    return otherwise;
}

struct Tally {
    std::map<Fate, int> fates;
    int all = 0, harmed = 0;
    double slowest_s = 0;

    void add(const test::Trial& t) {
        ++fates[t.fate];
        ++all;
        harmed += t.parent_harm.empty() ? 0 : 1;
        slowest_s = std::max(slowest_s, t.processor_s);
    }
    [[nodiscard]] bench::Row row(const std::string& recording, const std::string& checksums) const {
        bench::Row r{{"recording", recording}, {"checksums", checksums}};
        r.push_back({"mutants", static_cast<double>(all), "", 6});
        for (const Fate f : {Fate::refused, Fate::identical, Fate::not_identical, Fate::unclear, Fate::died,
                             Fate::timed_out}) {
            const auto found = fates.find(f);
            r.push_back({name(f), found == fates.end() ? 0.0 : found->second, "", 6});
        }
        r.push_back({"parent harmed", static_cast<double>(harmed), "", 6});
        r.push_back({"slowest", slowest_s, "s"});
        return r;
    }
};

void tell(std::uint64_t seed, const test::Trial& t) {
    if (t.parent_harm.empty() && t.fate != Fate::died && t.fate != Fate::timed_out && t.fate != Fate::unclear)
        return;
    std::fprintf(stderr, "seed %llu, %s, %s%s: %s %s%s\n", static_cast<unsigned long long>(seed),
                 t.file.c_str(), t.mutant.what.c_str(), t.mutant.sealed ? "sealed" : "not sealed",
                 name(t.fate), t.parent_harm.c_str(), t.said.c_str());
}

}  // namespace

int main(int argc, char** argv) {
    const auto number = [&](const char* name, const char* otherwise) {
        return std::strtoull(option(argc, argv, name, otherwise).c_str(), nullptr, 10);
    };
    const std::uint64_t count = number("--count", "5000"), first = 1'000'000 * number("--seed", "1");
    const std::filesystem::path folder =
        option(argc, argv, "--folder", (std::filesystem::temp_directory_path() / "shakerd-mutants").string());
    const std::filesystem::path keep = option(argc, argv, "--keep", "");
    if (!keep.empty()) std::filesystem::create_directories(keep);
    test::MutantTrials tracks{folder / "tracks", false}, pictures{folder / "pictures", true};
    std::array<Tally, 2> of_tracks, of_pictures;  // with wrong checksums, with corrected checksums
    for (std::uint64_t seed = first; seed < first + count; ++seed) {
        // Replaying pictures takes a hundred times longer than tracks: one in forty.
        const bool with_pictures = seed % 40 == 39;
        const test::Trial t = (with_pictures ? pictures : tracks).attempt(seed, keep);
        (with_pictures ? of_pictures : of_tracks)[t.mutant.sealed ? 1 : 0].add(t);
        tell(seed, t);
    }
    bench::Table table;
    int defects = 0;
    for (const auto& [recording, tallies] : {std::pair{"tracks", &of_tracks}, {"pictures", &of_pictures}})
        for (const bool sealed : {false, true}) {
            const Tally& tally = (*tallies)[sealed ? 1 : 0];
            table.add(tally.row(recording, sealed ? "right" : "as they were"));
            const auto unclear = tally.fates.find(Fate::unclear);
            defects += tally.harmed + (unclear == tally.fates.end() ? 0 : unclear->second);
        }
    table.print(argc, argv);
    return defects == 0 ? 0 : 1;
}
