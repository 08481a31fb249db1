#pragma once
// shakerd replay: computes the results of a recording again.
#include <filesystem>
#include <string>
#include <vector>

namespace shaker::commands {

struct ReplayOptions {
    enum class From { best, raw, tracks };
    std::filesystem::path file;
    /// best: from the pictures if all were kept and this version follows targets as the one that recorded the
    /// file, otherwise from the stored tracks.
    From from = From::best;
    std::vector<std::string> set{};  // "key=value": reduce with these settings instead of the recorded ones
    bool json = false;
};
/// Computes a recording's results again from its raw streams and prints them. True when they are identical to
/// the bit, when `set` changed settings, or when the file is of a version that computed otherwise.
bool replay(const ReplayOptions& options);

}  // namespace shaker::commands
