#pragma once
// Campaigns of shakerd on the simulated bench that SIGKILL ends, and their continuation.
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "daemon/campaign/points_table.hpp"

namespace shaker::test {

/// What a kill and the continuation have left.
struct Killed {
    bool killed = false;                  // it had not ended before
    int ended_before = 0;                 // points in the journal at the kill
    std::vector<std::string> findings{};  // whatever differs from the undisturbed campaign; empty: nothing
};

/// One plan, measured undisturbed and then with kills. Needs a folder of its own.
class KilledCampaigns {
public:
    KilledCampaigns(std::filesystem::path plan, std::filesystem::path folder);
    /// Kills it `after_s` of wall time, continues it to its end, and compares the points tables: points that
    /// had ended are the same to the bit, all others agree within their errors, no measurement counts twice.
    [[nodiscard]] Killed kill(double after_s, int number) const;
    /// Wall time of the undisturbed campaign, s.
    [[nodiscard]] double lasts_s() const noexcept { return lasts_s_; }

private:
    std::filesystem::path plan_, folder_;
    campaign::PointsTable whole_;
    double lasts_s_ = 0;
};

}  // namespace shaker::test
