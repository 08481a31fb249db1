#pragma once
// CampaignHost: the campaign that a bench on call measures by the order of a client.
#include <cmath>
#include <functional>
#include <future>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "daemon/campaign/lead/session.hpp"
#include "daemon/service/bench_state.hpp"
#include "drivers/beside.hpp"

namespace shaker::service {

/// Between begin() and the end of the campaign the orders of the engine take the place of those of clients.
/// Thread safety: one thread.
class CampaignHost {
public:
    using Log = std::function<void(const std::string& text)>;
    /// beside: the table of points is written in a separate thread. plans: folder of the plans with a name.
    /// Runner and bench must outlive this object.
    CampaignHost(run::Runner& runner, on_call::OnCall& on_call, bool beside, std::filesystem::path plans,
                 Log log)
        : runner_{runner},
          on_call_{on_call},
          beside_{beside},
          plans_{std::move(plans)},
          log_{std::move(log)},
          checker_{"plan check", beside},
          desk_{"campaign", beside} {}

    /// Reads a plan and makes its folder beside the recordings, NAME-<time>, in a thread of its own. text: of
    /// the plan; empty: that of the plan with this name. InputError while another campaign is under way.
    /// view_m: length of the view, for the predicted time; NaN: not known.
    void prepare(const std::string& name, const std::string& text, const run::RunOptions& run, double view_m);
    /// Begins the campaign that was prepared; false while it is being prepared. may: throws when it may not
    /// begin now. InputError for a plan that cannot be read or is beyond the limits, and after cancel();
    /// DeviceError when the disk fails.
    bool begin(const std::function<void()>& may);
    /// Begins a campaign at once, before the first step.
    void begin(campaign::PreparedSession prepared);
    [[nodiscard]] bool prepares() const noexcept { return preparing_.valid(); }
    void cancel() noexcept { cancelled_ = true; }
    /// What the check of a plan needs from the cameras and the disk.
    struct View {
        double view_m = 0;         // length along the shaker's axis
        double place_m = 0;        // of the walker, from the middle of the view
        double bytes_per_s = NAN;  // of a recording; NaN: as on the simulated bench
    };
    /// Checks a plan in a thread of its own; checked() then has the result. text: as in prepare(). InputError
    /// while another one is being checked.
    void check(const std::string& name, const std::string& text, const View& view);
    /// The plan of check() is read; false while it is not. InputError for a plan that cannot be read or is
    /// beyond the limits.
    bool read();
    [[nodiscard]] const std::optional<PlanCheckState>& checked() const noexcept { return checked_; }
    /// Names of the plans, as far as is known: the folder is read again at rest, every 5 s.
    const std::vector<std::string>& plans(double now_s);
    /// InputError when there is no campaign, or the word has no meaning now.
    void obey(campaign::Word word);
    /// A campaign is measured: it has the bench.
    [[nodiscard]] bool active() const noexcept { return session_ != nullptr; }
    /// InputError while active(). what: "the set-point cannot be changed".
    void require_none(std::string_view what) const;
    /// The newest drive of the active campaign.
    [[nodiscard]] const Drive& drive() const { return session_->campaign().drive(); }

    // As those of campaign::Campaign; without a campaign they do nothing.
    void take(const on_call::Measured& measured);
    void order(acquisition::Channels& channels);
    void take(const run::FinishedRun& run);
    /// Ends the campaign when it is done. leaving: the program ends; the campaign can be continued later.
    void follow(bool leaving);

    /// State of the campaign under way, or of the last one; before the first, of one that the daemon before
    /// left unfinished in the folder of the recordings.
    [[nodiscard]] std::optional<CampaignState> state();
    /// Nothing is left to be written.
    [[nodiscard]] bool at_rest() const noexcept {
        return !session_ && !finishing_.valid() && !preparing_.valid();
    }

private:
    void end(bool leaving);
    void take_check();
    void log_end();

    run::Runner& runner_;
    on_call::OnCall& on_call_;
    bool beside_, leaving_ = false;
    std::filesystem::path plans_;
    struct Listed {
        std::vector<std::string> plans;
        std::optional<campaign::InterruptedCampaign> interrupted;  // at the start of the daemon
    };
    void take(Listed&& listed);
    std::vector<std::string> known_;
    double known_s_ = -INFINITY;  // master time at which they were read
    Log log_;
    std::shared_ptr<campaign::Session> session_;
    std::string preparing_name_;
    bool cancelled_ = false;
    std::future<campaign::PreparedSession> preparing_;
    std::future<Listed> listing_;
    std::future<std::vector<std::string>> finishing_;  // sentences for the log
    std::optional<PlanCheckState> checked_, checked_before_;
    std::future<void> reading_;  // of the plan that is checked
    std::future<PlanCheckState> checking_;
    CampaignState state_;
    Beside checker_, desk_;  // the last members: their work ends first
};

}  // namespace shaker::service
