#pragma once
// Runs with a full, failing or stalling disk, and the remains of their recordings.
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace shaker::test {

struct DiskFault {
    std::string name;
    std::string fault;       // in the format of tests/preload/disk_faults.cpp; empty: no fault
    std::int64_t room = -1;  // bytes free on the disk; -1: unlimited
    bool refused = false;    // the run must be refused
    bool finished = false;   // the run must end normally, without gaps in its series
    bool mute = false;       // the journal cannot be written either
    double least_s = 2;      // least master time at the end of a recording that ends early
};

/// The disk full before the start and in mid run, errors of each kind of file, stalls of 5 and 10 s.
const std::vector<DiskFault>& disk_faults();

struct AfterFault {
    int status = -1;
    std::string words;                                    // of the program
    bool came_down_softly = false;                        // the program reports a soft stop
    bool journal_says_why = false;                        // the reason is in the recovered recording
    double until_s = 0;                                   // master time at the end of the recording
    std::uint64_t missing = 0;                            // missing blocks, samples and frames without a mark
    std::uint64_t produced = 0, stored = 0, dropped = 0;  // pictures of all cameras
    std::vector<std::string> wrong;                       // violated requirements; empty: success
};

/// One run with this fault in an empty folder; for those that end early, recovered.
AfterFault run_with(const DiskFault& fault, const std::filesystem::path& folder);

}  // namespace shaker::test
