#pragma once
// Damaged copies of a file, each read in a separate process.
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "drivers/recorded/h5/h5.hpp"
#include "tests/support/recording/recording_folder.hpp"

namespace shaker::test {

/// Outcome of all copies.
struct Mutants {
    int refused = 0;      ///< with an InputError
    int wrong = 0;        ///< another exception, or an identifier left open
    int died = 0;         ///< killed by a signal or by a sanitiser
    double peak_MB = 0;   ///< memory of the largest process
    std::string example;  ///< of the last that was wrong or died: its number and its changed bytes
};

/// Memory of a reader: mostly the program itself and what a sanitiser keeps.
inline constexpr double most_MB = 800;

enum ReadEnd : int { read_accepted = 20, read_refused, read_wrong };

/// Reads and ends this process.
[[noreturn]] inline void read_and_exit(const std::function<void()>& read) {
    int end = read_wrong;
    try {
        end = refusal(read) == "accepted" ? read_accepted : read_refused;
        if (H5Fget_obj_count(hid_t{H5F_OBJ_ALL}, H5F_OBJ_ALL) != 0) end = read_wrong;
    } catch (...) {
        end = read_wrong;
    }
    std::_Exit(end);
}

struct MutantFile {
    std::filesystem::path file;  // path of each mutant
    std::string bytes;           // undamaged content
    /// Half of the changes are in the first of so many bytes, half where there is no zero.
    std::size_t anywhere;
    std::function<void()> read;
};

inline Mutants read_mutants(const MutantFile& of, int mutants, std::uint64_t seed) {
    // Streams are padded with zeros to whole chunks, so other bytes are mostly structure.
    std::vector<std::size_t> used;
    for (std::size_t i = 0; i < of.bytes.size(); ++i)
        if (of.bytes[i] != 0) used.push_back(i);
    std::mt19937_64 random{seed};
    Mutants all;
    for (int i = 0; i < mutants; ++i) {
        std::string mutant = of.bytes;
        std::string where = "mutant " + std::to_string(i) + ", bytes";
        for (std::uint64_t flips = 1 + random() % 3; flips > 0; --flips) {
            const std::size_t at = random() % 2 == 0 ? used[random() % used.size()] : random() % of.anywhere;
            mutant[at] = static_cast<char>(mutant[at] ^ static_cast<char>(1 + random() % 255));
            where += " " + std::to_string(at);
        }
        std::ofstream{of.file, std::ios::binary} << mutant;
        const pid_t child = fork();
        if (child == 0) read_and_exit(of.read);
        int status = 0;
        rusage usage{};
        wait4(child, &status, 0, &usage);
        all.peak_MB = std::max(all.peak_MB, static_cast<double>(usage.ru_maxrss) / 1024);
        const int end = WIFEXITED(status) ? WEXITSTATUS(status) : 0;
        all.refused += end == read_refused ? 1 : 0;
        all.wrong += end == read_wrong ? 1 : 0;
        all.died += end < read_accepted ? 1 : 0;
        if (end == read_wrong || end < read_accepted) all.example = where;
    }
    return all;
}

}  // namespace shaker::test
