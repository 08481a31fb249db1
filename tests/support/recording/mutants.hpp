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
    bool sealed = false;  // checksums were made right again
};
/// The same for the same seed. Of ten, eight are hit where the file is described, half have right checksums.
Mutant mutant_of(const std::string& bytes, const Structure& structure, std::uint64_t seed);

enum class Fate {
    identical,      // replayed, all numbers equal to the bit
    not_identical,  // replayed, and the difference was reported
    refused,        // as the user's input, with a message
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
    std::string parent_harm;  // what is not as before in this process or on disk; empty: all is
};

/// A small recording of its own, in a folder that is there as long as this is.
class MutantTrials {
public:
    /// Records a run of 3 periods on the simulated bench, with or without its pictures. Throws when what was
    /// recorded does not replay identically.
    MutantTrials(const std::filesystem::path& folder, bool pictures);
    ~MutantTrials();
    MutantTrials(const MutantTrials&) = delete;
    MutantTrials& operator=(const MutantTrials&) = delete;
    /// One of the recording's files is replaced by its mutant, the recording replayed, the file put back.
    /// `keep`: the mutant is kept there when its reader died, timed out or was unclear; empty: it is not.
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
