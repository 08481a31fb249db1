#pragma once
// Campaigns of shakerd on the simulated bench that SIGKILL ends, and their continuation.
#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "daemon/campaign/points_table.hpp"
#include "tests/support/recording/disk_images.hpp"

namespace shaker::test {

/// What a kill and the continuation have left.
struct Killed {
    bool killed = false;                  // it had not ended before
    bool killed_again = false;            // in the continuation
    int ended_before = 0;                 // points in the journal at the kill
    std::vector<std::string> findings{};  // whatever differs from the undisturbed campaign; empty: nothing
};

/// One plan, measured undisturbed and then with kills. Needs a folder of its own.
class KilledCampaigns {
public:
    /// How the undisturbed campaign is run. logged: with a list of its calls that change or synchronise a
    /// file, a folder or a name.
    enum class Whole { timed, logged };
    KilledCampaigns(std::filesystem::path plan, std::filesystem::path folder, Whole whole = Whole::timed);
    /// Kills it `after_s` of wall time, continues it to its end, and compares the points tables: points that
    /// had ended are the same to the bit, all others agree within their errors, no measurement counts twice.
    [[nodiscard]] Killed kill(double after_s, int number) const;
    /// The same for a kill after `call` of the listed calls. The continuation is killed after `again` of its
    /// own calls (0: not) and continued once more.
    [[nodiscard]] Killed kill_at(std::size_t call, std::size_t again) const;
    /// Recovers each recording that a kill after `call` calls leaves, without a person: what differs from
    /// success. Before its first sync a recording may have nothing to recover.
    [[nodiscard]] std::vector<std::string> recover_at(std::size_t call) const;
    /// Wall time of the undisturbed campaign, s.
    [[nodiscard]] double lasts_s() const noexcept { return lasts_s_; }
    /// Number of the listed calls.
    [[nodiscard]] std::size_t calls() const noexcept { return images_ ? images_->size() : 0; }

private:
    /// The folder after `call` calls; an older one is removed.
    [[nodiscard]] std::filesystem::path image(std::size_t call) const;
    void go_on(const std::string& name, std::size_t again, Killed& result) const;

    std::filesystem::path plan_, folder_;
    campaign::PointsTable whole_;
    std::unique_ptr<DiskImages> images_;
    double lasts_s_ = 0;
};

}  // namespace shaker::test
