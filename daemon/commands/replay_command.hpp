#pragma once
// shakerd replay: computes the results of a recording again.
#include <filesystem>
#include <string>
#include <vector>

namespace shaker::commands {

struct ReplayOptions {
    enum class From { best, raw, tracks };
    std::filesystem::path file;
    From from = From::best;  // best: from the pictures if all were kept, otherwise from the stored tracks
    std::vector<std::string> set{};  // "key=value": reduce with these settings instead of the recorded ones
    bool json = false;
};
/// Computes a recording's results again from its raw streams and prints them. True when they are identical to
/// the bit, or when `set` changed settings.
bool replay(const ReplayOptions& options);

}  // namespace shaker::commands
