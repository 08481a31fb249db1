#pragma once
// Arguments of a measurement program.
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string>

namespace shaker::bench {

/// The argument after `name`.
inline std::string option(int argc, char** argv, const char* name, const std::string& otherwise) {
    for (int i = 1; i + 1 < argc; ++i)
        if (std::strcmp(argv[i], name) == 0) return argv[i + 1];
    return otherwise;
}

/// The argument after `name` as a whole number, at least `least`.
inline int whole_option(int argc, char** argv, const char* name, int otherwise, int least) {
    const int told = std::atoi(option(argc, argv, name, std::to_string(otherwise)).c_str());
    return told < least ? least : told;
}

/// A new folder of this process below the argument of "--folder", or below the temporary folder.
inline std::filesystem::path own_folder(int argc, char** argv, const std::string& name) {
    const std::string above = option(argc, argv, "--folder", std::filesystem::temp_directory_path().string());
    std::string own = (std::filesystem::path{above} / (name + "-XXXXXX")).string();
    return ::mkdtemp(own.data()) == nullptr ? std::filesystem::path{above} / name
                                            : std::filesystem::path{own};
}

}  // namespace shaker::bench
