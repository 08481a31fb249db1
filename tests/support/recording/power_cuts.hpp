#pragma once
// Power cuts at random times of one live run. Possible contents of the disk are recovered and compared with
// the run.
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "tests/support/recording/disk_images.hpp"

namespace shaker::test {

/// Outcome of one image.
struct PowerCut {
    bool anything_synced = false;      // the recording was synchronised before the cut
    bool recovered = false;            // the recovered recording can be read to its end
    std::uint64_t synced_lost = 0;     // lost rows and pictures that were synchronised
    std::uint64_t bad = 0;             // rows and pictures reported as good that differ from the run
    std::uint64_t unsynced_saved = 0;  // saved rows that were not synchronised
    std::string words;                 // error; empty: success
};

class PowerCuts {
public:
    /// Makes one run of about 6 s in real time in an empty folder, which must stay, with all its calls
    /// logged. std::runtime_error when the run does not end well.
    explicit PowerCuts(std::filesystem::path folder);
    ~PowerCuts();

    /// The image of a random cut, recovered in an empty folder. Any thread.
    [[nodiscard]] PowerCut cut(Surviving surviving, std::uint64_t seed,
                               const std::filesystem::path& folder) const;
    /// Number of logged calls, and of synchronisations of the series.
    [[nodiscard]] std::size_t calls() const noexcept { return images_->size(); }
    [[nodiscard]] std::size_t syncs() const noexcept { return synced_.size(); }

private:
    using Rows = std::map<std::string, std::uint64_t>;  // a column's, and "pictures/<camera>"
    struct Reference;
    struct Synced {
        std::size_t cut;
        Rows rows;
    };
    void look_at_syncs();
    void compare(const std::filesystem::path& recording, const Rows& synced, PowerCut& result) const;

    std::filesystem::path folder_;
    std::unique_ptr<DiskImages> images_;
    std::unique_ptr<Reference> reference_;
    std::vector<Synced> synced_;
};

}  // namespace shaker::test
