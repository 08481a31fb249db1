#pragma once
// Arguments of a bench.
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string>

namespace shaker::bench {

/// What follows `name` among the arguments of the program.
inline std::string option(int argc, char** argv, const char* name, const std::string& otherwise) {
    for (int i = 1; i + 1 < argc; ++i)
        if (std::strcmp(argv[i], name) == 0) return argv[i + 1];
    return otherwise;
}

/// Likewise a whole number, `least` at the least.
inline int whole_option(int argc, char** argv, const char* name, int otherwise, int least) {
    const int told = std::atoi(option(argc, argv, name, std::to_string(otherwise)).c_str());
    return told < least ? least : told;
}

/// A folder of this process's own below the one that "--folder" names, or else the temporary one.
inline std::filesystem::path own_folder(int argc, char** argv, const std::string& name) {
    const std::string above = option(argc, argv, "--folder", std::filesystem::temp_directory_path().string());
    std::string own = (std::filesystem::path{above} / (name + "-XXXXXX")).string();
    return ::mkdtemp(own.data()) == nullptr ? std::filesystem::path{above} / name
                                            : std::filesystem::path{own};
}

}  // namespace shaker::bench
