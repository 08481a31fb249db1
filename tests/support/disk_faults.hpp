#pragma once
// Runs whose disk is full, fails or stalls, and what is left of their recordings.
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace shaker::test {

struct DiskFault {
    std::string name;
    std::string fault;       // as tests/preload/disk_faults.cpp takes it; empty: none
    std::int64_t room = -1;  // bytes that the disk has; -1: as it is
    bool refused = false;    // there must be no run
    bool finished = false;   // the run must end well, without a hole in its series
    bool mute = false;       // the journal cannot be written either
    double least_s = 2;      // master time to which the recording must go at least, of one that ends early
};

/// The disk full before the start and in mid run, errors of each kind of file, stalls of 5 and 10 s.
const std::vector<DiskFault>& disk_faults();

struct AfterFault {
    int status = -1;
    std::string words;                                    // of the program
    bool came_down_softly = false;                        // the drive, as the program says
    bool journal_says_why = false;                        // the reason is in the recovered recording
    double until_s = 0;                                   // master time to which the recording goes
    std::uint64_t missing = 0;                            // blocks, samples and frames that no mark tells of
    std::uint64_t produced = 0, stored = 0, dropped = 0;  // pictures of all cameras
    std::vector<std::string> wrong;                       // against what must be; empty: all is well
};

/// One run with this fault in an empty folder; for those that end early, recovered.
AfterFault run_with(const DiskFault& fault, const std::filesystem::path& folder);

}  // namespace shaker::test
