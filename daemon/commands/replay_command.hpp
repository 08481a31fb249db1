#pragma once
// shakerd replay: the results of a recording, computed again.
#include <filesystem>
#include <string>
#include <vector>

namespace shaker::commands {

struct ReplayOptions {
    enum class From { best, raw, tracks };
    std::filesystem::path file;
    From from = From::best;  // best: from the pictures where all were kept, else from the stored tracks
    bool real_time = false;  // at the speed of the recording
    std::vector<std::string> set{};  // "key=value": reduce with these settings instead of the recorded ones
    bool json = false;
};
/// Recomputes a recording's results from its raw streams and prints them. True when they are identical to the
/// bit, or when `set` changed settings.
bool replay(const ReplayOptions& options);

}  // namespace shaker::commands
