#pragma once
// Session: one campaign on a bench on call, from its plan to its table of points.
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "daemon/campaign/campaign_folder.hpp"
#include "daemon/campaign/lead/campaign.hpp"
#include "daemon/campaign/lead/journal_writer.hpp"
#include "daemon/campaign/points_table.hpp"

namespace shaker::campaign {

struct SessionSettings {
    std::filesystem::path folder;  // of the campaign
    std::string plan;              // its text; read from the folder when the campaign is continued
    std::string plan_file;         // name of the plan in messages
    bool continues = false;
    run::RunOptions run;  // rig, pictures, identification of every drive
    bool beside = false;  // the journal is written in a thread of its own
    double view_m = NAN;  // length of the view, for the predicted bench time; NaN: wide
};

/// InputError for a set-point beyond the limits of the bench, with the line of the plan.
void require_possible(const Plan& plan, const std::vector<Point>& points, const bench::Bench& bench);

/// What a session needs of the disk.
struct PreparedSession {
    SessionSettings settings;
    std::string plan_text;
    Plan plan;
    std::vector<Point> points;
    CampaignFolder folder;
    Engine engine;
    int recordings = 0;           // that are in the folder already
    std::vector<double> bench_s;  // predicted bench time of each point
};
/// Reads the plan, and creates or opens the folder. longest_recording_s: of the bench. InputError for a plan
/// that cannot be read or is beyond the limits, and for a folder in use; DeviceError when the disk fails. Any
/// thread.
PreparedSession prepare(const SessionSettings& settings, const bench::Bench& bench,
                        double longest_recording_s);

/// Thread safety: one thread, but finish(): any thread, as the last call. Runner and bench on call must
/// outlive this object.
class Session {
public:
    Session(run::Runner& runner, on_call::OnCall& on_call, PreparedSession prepared,
            const Campaign::Listener& listener);
    Session(const Session&) = delete;
    Session& operator=(const Session&) = delete;

    /// As Campaign::order(). A journal that cannot be written pauses the campaign.
    void order(acquisition::Channels& channels);
    /// Completes the journal and writes the table of points.
    PointsTable finish(CampaignChange last);

    /// Sentences about the campaign: share of the points, bench time by its use, accuracy of the returns, v_D
    /// against the simulated truth.
    [[nodiscard]] std::vector<std::string> summary(const PointsTable& table) const;
    /// Bench time of the points that have not ended, s: as predicted, times the ratio of the time that the
    /// ended points have taken to their prediction.
    [[nodiscard]] double left_s() const;

    [[nodiscard]] Campaign& campaign() noexcept { return campaign_; }
    [[nodiscard]] Engine& engine() noexcept { return engine_; }
    [[nodiscard]] const Plan& plan() const noexcept { return plan_; }
    [[nodiscard]] const std::vector<Point>& points() const noexcept { return points_; }
    [[nodiscard]] const std::filesystem::path& folder() const noexcept { return folder_.path(); }

private:
    std::string plan_text_;
    Plan plan_;
    std::vector<Point> points_;
    CampaignFolder folder_;
    Engine engine_;
    JournalWriter journal_;
    std::vector<double> bench_s_;  // predicted, of each point
    double before_s_ = 0;          // of the points that had ended before this session
    std::vector<Returned> returns_;
    Campaign campaign_;
};

}  // namespace shaker::campaign
