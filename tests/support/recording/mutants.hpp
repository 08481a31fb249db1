#pragma once
// Damaged copies of a recording, each replayed in a confined child: outcome, and effect on the parent.
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/support/recording/hdf5_structure.hpp"

namespace shaker::test {

/// A damaged copy of a file.
struct Mutant {
    std::string bytes;
    std::string what;     // kind and place of the damage
    bool sealed = false;  // checksums were corrected
};
/// Equal mutants for equal seeds. Eight of ten have damage in the structure of the file, half have correct
/// checksums.
Mutant mutant_of(const std::string& bytes, const Structure& structure, std::uint64_t seed);

enum class Fate {
    identical,      // replayed, all numbers equal to the bit
    not_identical,  // replayed, and the difference was reported
    refused,        // as wrong input, with a message
    unclear,        // any other message or status: a defect
    died,           // by a signal or a sanitiser
    timed_out       // 10 s of processor time or 60 s in all
};
const char* name(Fate fate);

struct Trial {
    Fate fate = Fate::unclear;
    std::string file;         // relative to the recording's folder
    Mutant mutant;            // without its bytes
    std::string said;         // output of the child
    double processor_s = 0;   // of the child
    std::string parent_harm;  // changes in this process or on disk; empty: no change
};

/// A small recording in a temporary folder, removed with this object.
class MutantTrials {
public:
    /// Records a run of 3 periods on the simulated bench, with or without its pictures. Throws when the
    /// recording does not replay identically.
    MutantTrials(const std::filesystem::path& folder, bool pictures);
    ~MutantTrials();
    MutantTrials(const MutantTrials&) = delete;
    MutantTrials& operator=(const MutantTrials&) = delete;
    /// Replaces one of the recording's files by its mutant, replays the recording and restores the file.
    /// `keep`: folder for mutants whose reader died, timed out or was unclear; empty: they are not kept.
    Trial attempt(std::uint64_t seed, const std::filesystem::path& keep = {});

private:
    struct File {
        std::filesystem::path path;
        std::string bytes;
        Structure structure;
    };
    [[nodiscard]] Trial replayed() const;

    std::filesystem::path folder_;
    std::vector<File> files_;
};

}  // namespace shaker::test
