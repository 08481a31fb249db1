#pragma once
// Campaign: leads a runner on call through a plan.
#include <filesystem>
#include <functional>
#include <string>

#include "daemon/campaign/engine.hpp"
#include "daemon/on_call/on_call.hpp"

namespace shaker::campaign {

struct CampaignSettings {
    run::RunOptions run;           // rig, pictures, identification of every drive
    std::filesystem::path folder;  // of the recordings
    int recordings = 0;            // that are in the folder already
    double edge_margin_mm = 2;     // inside the limit at the edge; a pass ends here
    bool beside = false;           // measurements are reduced in a separate thread
};

/// Thread safety: one thread. Runner and engine must outlive this object.
class Campaign {
public:
    using Listener = std::function<void(const Event&, double now_s)>;
    Campaign(run::Runner& runner, Engine& engine, const CampaignSettings& settings, Listener listener);

    /// Processes new data and gives the bench the engine's next order. False when no data arrived.
    bool step(const acquisition::Streams& streams, acquisition::Channels& channels);
    /// The engine has ended, the drive is silent and all recordings are complete.
    [[nodiscard]] bool done() const { return engine_.done() && on_call_.at_rest(); }
    /// Obeys a word of the operator: pause, resume, skip, stop, abort or clear. InputError for another word,
    /// and for one that has no meaning now.
    void obey(const std::string& word, acquisition::Channels& channels);
    [[nodiscard]] on_call::OnCall& on_call() noexcept { return on_call_; }

private:
    [[nodiscard]] Seen seen(const acquisition::Channels& channels) const;
    void carry_out(const Action& action, acquisition::Channels& channels);

    run::Runner& runner_;
    Engine& engine_;
    CampaignSettings settings_;
    Listener listener_;
    on_call::OnCall on_call_;
    double recording_from_s_ = 0;  // master time of the newest start
};

}  // namespace shaker::campaign
