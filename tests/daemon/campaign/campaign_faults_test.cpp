// A fault in the middle of a campaign: the operator reads why it pauses, and after clear and resume it goes
// on to its end. It never clears a trip by itself.
#include <gtest/gtest.h>
#include <spdlog/fmt/fmt.h>

#include <fstream>

#include "daemon/campaign/lead/campaign.hpp"
#include "daemon/campaign/plan.hpp"
#include "daemon/run/runner.hpp"
#include "tests/support/program.hpp"

namespace shaker::campaign {
namespace {

constexpr const char* plan = R"([point]
periods = 10
[[series]]
gamma = ["0.7g", "1g"]
phi = ["0deg"]
order = "mirror"
)";
constexpr double longest_s = 120, looks_s = 10;  // virtual

struct Case {
    const char* name;
    const char* faults;    // tables of the scene
    const char* at_pause;  // in the reason of a pause; empty: it goes on without a person
    double abort_at_s = INFINITY;
};

class CampaignFaultTest : public testing::TestWithParam<Case> {
protected:
    CampaignFaultTest() {
        std::ofstream{folder_ / "scene.toml"} << "[walker]\nstart_mm = 0\n" << GetParam().faults;
        settings_.run.rig = "sim:";
        settings_.run.scene = folder_ / "scene.toml";
        settings_.run.standard = simulated::paper_scene(simulated::Detail::positions);
        settings_.run.pictures = recorded::KeptPictures::off;
        settings_.on_call = true;
        settings_.recordings = folder_;
    }

    /// Plays the campaign; a person looks at each pause, then clears and resumes.
    void play(Campaign& campaign, Engine& engine, on_call::OnCall& on_call, run::Runner& runner) {
        bool aborted = false;
        runner.lead(
            [&](const acquisition::Streams& streams, acquisition::Channels& channels) {
                const bool any = on_call.take(streams, channels);
                while (const auto measured = on_call.measured()) campaign.take(*measured);
                campaign.order(channels);
                on_call.follow(settings_.run, channels);
                while (const auto run = on_call.finished()) campaign.take(*run);
                campaign.follow();
                now_s_ = runner.sequence().now_s();
                if (now_s_ > GetParam().abort_at_s && !std::exchange(aborted, true)) ++channels.aborts;
                if (!engine.paused()) paused_s_ = now_s_;
                if (now_s_ < paused_s_ + looks_s || !campaign.waits_for_a_person()) return any;
                if (on_call.may_clear()) {
                    on_call.clear(runner.sequence().stops().size(), channels.aborts, channels);
                } else {
                    engine.obey(Word::resume);
                }
                return any;
            },
            [&] { return campaign.done() || now_s_ > longest_s; });
    }

    std::filesystem::path folder_ = test::fresh_folder();
    run::RunnerSettings settings_;
    double now_s_ = 0, paused_s_ = 0;
};

TEST_P(CampaignFaultTest, PausesSaysWhyAndGoesOn) {
    const std::vector<Point> points = schedule(parse_plan(plan, "plan"));
    run::Runner runner{settings_};
    Engine engine{points, {}};
    std::vector<std::string> pauses;
    std::vector<PointEnded> ended;
    const auto listen = [&](const Event& event, double) {
        if (const auto* change = std::get_if<CampaignChange>(&event);
            change != nullptr && change->what == CampaignChange::What::paused)
            pauses.push_back(change->reason);
        if (const auto* end = std::get_if<PointEnded>(&event)) ended.push_back(*end);
    };
    on_call::OnCall on_call{runner, false};
    Campaign campaign{runner, on_call, engine, {.run = settings_.run, .folder = folder_}, listen};
    play(campaign, engine, on_call, runner);
    EXPECT_TRUE(engine.done()) << "at " << now_s_ << " s";
    ASSERT_EQ(ended.size(), points.size());
    for (const PointEnded& end : ended) EXPECT_EQ(end.outcome, Outcome::measured) << end.reason;
    const std::string said = fmt::format("{}", fmt::join(pauses, "\n"));
    EXPECT_NE(said.find(GetParam().at_pause), std::string::npos) << said;
    EXPECT_EQ(pauses.empty(), *GetParam().at_pause == '\0') << said;
}

constexpr const char* tripped = "clear the trip, then resume";
INSTANTIATE_TEST_SUITE_P(
    Faults, CampaignFaultTest,
    testing::Values(
        Case{"both_cameras_silent", "[[fault]]\nwhat = \"camera_stall\"\nat_s = 6\nfor_s = 1.5\n", tripped},
        Case{"one_camera_gone", "[[fault]]\nwhat = \"camera_gone\"\nat_s = 6\ncamera = \"top\"\n", ""},
        Case{"sensor_open", "[[fault]]\nwhat = \"open\"\nat_s = 6\nfor_s = 0.5\n", tripped},
        Case{"sensor_silent", "[[fault]]\nwhat = \"silent\"\nat_s = 6\nfor_s = 0.5\n", tripped},
        Case{"amplifier_off", "[[fault]]\nwhat = \"amplifier_off\"\nat_s = 6\nfor_s = 1\n", tripped},
        Case{"underrun", "[[fault]]\nwhat = \"underrun\"\nat_s = 6\nvalue = 480\n", ""},
        Case{"walker_hidden", "[[fault]]\nwhat = \"walker_hidden\"\nat_s = 6\nfor_s = 1\n", tripped},
        Case{"abort", "", tripped, 6}),
    [](const auto& one) { return one.param.name; });

}  // namespace
}  // namespace shaker::campaign
