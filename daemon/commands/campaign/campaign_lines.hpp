#pragma once
// What an operator reads while a campaign is measured, and at its end.
#include <filesystem>
#include <string>
#include <vector>

#include "daemon/campaign/lead/campaign.hpp"
#include "daemon/campaign/points_table.hpp"

namespace shaker::commands {

/// One line for each point that ends, each pause and each problem, at once, also into a pipe. On a terminal
/// there is a last line that is written again and again: point, what the bench does, time left, last v_D.
class CampaignLines {
public:
    /// bench_s: predicted bench time of each point.
    CampaignLines(const campaign::Engine& engine, const std::vector<campaign::Point>& points,
                  std::vector<double> bench_s);
    ~CampaignLines();
    CampaignLines(const CampaignLines&) = delete;
    CampaignLines& operator=(const CampaignLines&) = delete;

    void event(const campaign::Event& event, double now_s);
    /// An answer to the operator.
    void say(const std::string& sentence);
    /// Writes the last line again if it is old. spent_s: bench time of the points so far, without that at
    /// rest.
    void status(double spent_s);
    /// Predicted time of the points that are left, corrected by the time that the ended points have taken; s.
    [[nodiscard]] double left_s(double spent_s) const;

private:
    void print(const std::string& line);

    const campaign::Engine& engine_;
    const std::vector<campaign::Point>& points_;
    std::vector<double> bench_s_;
    std::vector<bool> ended_ = std::vector<bool>(bench_s_.size(), false);
    bool terminal_;
    double written_s_ = -1;  // monotonic time of the last line
    std::string last_;       // v_D of the newest point
};

/// Share of the points, bench time by its use, accuracy of the returns, v_D against the simulated truth.
std::string campaign_summary(const campaign::PointsTable& table, const campaign::BenchTime& time,
                             const std::vector<campaign::Returned>& returns, double wall_s);

}  // namespace shaker::commands
