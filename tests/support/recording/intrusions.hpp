#pragma once
// Other programs that reach for the files of a recording in progress.
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace shaker::test {

enum class Intruder {
    recover,           // "shakerd recover" of the file
    second_recorder,   // another "shakerd run" that records into the same file
    file_of_the_name,  // a file with the final name of the recording
    recover_copy       // "shakerd recover" of a copy, whose pictures are those of the recording
};
inline constexpr int intruders = 4;
const char* name(Intruder intruder) noexcept;

struct Intrusion {
    Intruder intruder{};
    double at_s = 0;                                      // after the first line of the journal
    std::uint64_t produced = 0, stored = 0, dropped = 0;  // pictures; dropped: the queue was full
    std::uint64_t lost = 0;                               // pictures that are counted as stored and missing
    bool replaced = false;                                // a file was written over
    std::vector<std::string> wrong;                       // violated requirements; empty: success
};

/// One live run with whole pictures and an intruder at_s after its start, in this empty folder.
Intrusion intrude(Intruder intruder, double at_s, const std::filesystem::path& folder);

/// `count` runs with the intruders in turn at random times, `jobs` at a time, in folders below this
/// one. A failed one keeps its folder.
std::vector<Intrusion> intrusions(int count, std::uint64_t seed, int jobs,
                                  const std::filesystem::path& folder);

}  // namespace shaker::test
