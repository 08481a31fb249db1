#pragma once
// Kills a run and recovers the remains of its recording.
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace shaker::test {

/// A simulated run in real time with whole pictures.
struct KilledRun {
    std::filesystem::path scene;  // empty: two cameras of 1000 pictures a second
    int periods = 120;            // about 4 s more than they take
    double longest_s = 8;         // master time of the last kill
};

struct Kill {
    double at_s = 0;           // master time, from the first line of the journal on
    double series_lost_s = 0;  // lost time before the kill, of the series with the largest loss
    double pictures_lost = 0;  // pictures exposed before the kill and not stored; camera with most losses
    bool recovered = false;    // by the report of "shakerd recover"
    bool whole = false;        // a second recovery finds the file intact and does not change it
    bool replayed = false;     // "shakerd replay" computes the recorded results
    bool reduced = false;      // there were results
    std::vector<std::string> wrong;  // errors in the content
};

/// One run in this empty folder, killed at_s after its start.
Kill kill_run(const KilledRun& run, double at_s, const std::filesystem::path& folder);

/// `count` runs killed at random times from 0.3 s on, `jobs` at a time, in folders below this one. A failed
/// one keeps its folder.
std::vector<Kill> kill_runs(const KilledRun& run, int count, std::uint64_t seed, int jobs,
                            const std::filesystem::path& folder);

/// True if nothing was wrong.
bool went_well(const Kill& kill);

}  // namespace shaker::test
