// The results of a daemon are those of its recordings: they are read back after a restart, and never while
// the drive is on.
#include "daemon/catalogue/catalogue.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "daemon/catalogue/quiet_program.hpp"
#include "daemon/catalogue/row_text.hpp"
#include "drivers/errors.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/run/bench_on_call.hpp"

namespace shaker::catalogue {
namespace {

using run::RunState;
using test::in;
using test::until;

void wait_for(const std::function<bool()>& what) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds{60};
    while (!what() && std::chrono::steady_clock::now() < end)
        std::this_thread::sleep_for(std::chrono::milliseconds{20});
    EXPECT_TRUE(what());
}

class CatalogueTest : public test::OnCallBench {
protected:
    [[nodiscard]] CatalogueSettings settings() {
        return {.folder = folder, .program = test::build_dir() + "/shakerd", .may_read = [this] {
                    return may_read.load();
                }};
    }
    std::atomic<bool> may_read{true};
};

TEST_F(CatalogueTest, RowsOfARecordingAreThoseOfItsRun) {
    options.drive.phi = 1.75;
    std::vector<NumberedRow> live;
    play(test::slow, {{in(RunState::idle), give(service::Record{.on = true, .name = "a", .pictures = {}})},
                      {in(RunState::idle), give(service::Begin{{.periods = 10, .measurements = 2}})},
                      until(test::measured(2)),
                      {in(RunState::idle), [&](service::BenchPort& p) { live = p.results().since(0); }}});
    ASSERT_EQ(live.size(), 2U);
    EXPECT_EQ(live[0].row.recording, "a.nxs");
    EXPECT_EQ(live[0].row.ended, "complete");

    std::ofstream{folder / "b.nxs"} << "no recording";
    std::filesystem::create_symlink(folder / "a.nxs", folder / "link.nxs");
    ResultsTable table;
    {
        const Catalogue catalogue{settings(), table};
        wait_for([&] { return catalogue.complete(); });
    }
    const std::vector<NumberedRow> read = table.since(0);
    ASSERT_EQ(read.size(), 2U) << "neither the file without a recording nor the link";
    for (std::size_t i = 0; i < 2; ++i) {
        const ResultRow &now = live[i].row, &back = read[i].row;
        EXPECT_EQ(back.time.substr(0, 17), now.time.substr(0, 17));
        EXPECT_EQ(json_of(back)["asked"], json_of(now)["asked"]);
        EXPECT_EQ(back.periods, 10);
        EXPECT_NEAR(back.v_D.value, now.v_D.value, now.v_D.sigma);
        EXPECT_EQ(back.steady, now.steady);
        EXPECT_EQ(back.ended, "complete");
        EXPECT_EQ(back.recording, "a.nxs");
    }
}

std::string text_at(const Descriptor& file) {
    std::string text(100, '\0');
    const ssize_t n = ::read(file, text.data(), text.size());
    return text.substr(0, n > 0 ? static_cast<std::size_t>(n) : 0);
}

TEST_F(CatalogueTest, CampaignsAreListedAndTheirReportsOpened) {
    for (const char* name : {"scan-1", "scan-2", "other"})
        std::filesystem::create_directories(folder / name / "report");
    for (const char* file :
         {"scan-1/plan.toml", "scan-1/campaign.nxs", "scan-1/a.nxs", "scan-2/plan.toml", "other/a.nxs"})
        std::ofstream{folder / file} << "12345";
    std::ofstream{folder / "scan-1/report/report.html"} << "the figures";
    std::filesystem::create_symlink(folder / "scan-1/report/report.html",
                                    folder / "scan-2/report/report.html");
    std::filesystem::create_directory_symlink(folder / "scan-1", folder / "linked");
    ResultsTable table;
    Catalogue catalogue{settings(), table};
    wait_for([&] { return catalogue.complete(); });
    std::vector<ListedCampaign> all = catalogue.campaigns();
    ASSERT_EQ(all.size(), 2U) << "neither the folder without a plan nor the link";
    std::ranges::sort(all, {}, &ListedCampaign::name);
    EXPECT_EQ(all[0].name, "scan-1");
    EXPECT_EQ(all[0].recordings, 1U);
    EXPECT_EQ(all[0].bytes, 5U);
    EXPECT_TRUE(all[0].complete);
    EXPECT_EQ(all[0].report.verdict, "made");
    EXPECT_FALSE(all[1].complete);
    EXPECT_EQ(text_at(catalogue.open({"scan-1", true})), "the figures");
    for (const char* name : {"scan-2", "linked", "other", "..", "scan-1/..", ""})
        EXPECT_THROW(static_cast<void>(catalogue.open({name, true})), InputError) << name;
    EXPECT_THROW(catalogue.request({"other", true}), InputError);
    catalogue.request({"scan-2", true});
    wait_for([&] {
        const auto now = catalogue.campaigns();
        return std::ranges::any_of(now, [](const ListedCampaign& c) { return c.report.verdict == "failed"; });
    });
    all = catalogue.campaigns();
    const auto failed = std::ranges::find(all, "scan-2", &ListedCampaign::name);
    ASSERT_NE(failed, all.end());
    EXPECT_NE(failed->report.text.find("campaign.nxs"), std::string::npos) << failed->report.text;
}

TEST_F(CatalogueTest, NothingIsReadWhileTheDriveIsOn) {
    std::ofstream{folder / "b.nxs"} << "no recording";
    may_read = false;
    ResultsTable table;
    const Catalogue catalogue{settings(), table};
    std::this_thread::sleep_for(std::chrono::milliseconds{700});
    EXPECT_FALSE(catalogue.complete());
    may_read = true;
    wait_for([&] { return catalogue.complete(); });
}

TEST(QuietProgramTest, RunsAtIdlePriorityWithBoundedOutput) {
    const auto always = [] { return true; };
    const std::chrono::seconds longest{20};
    const auto quiet = run_quietly(
        {{"/bin/sh", "-c", "cut -d' ' -f41 /proc/self/stat; echo no >&2; exit 3"}, 100, longest}, always);
    ASSERT_TRUE(quiet);
    EXPECT_EQ(quiet->out, "5\n") << "SCHED_IDLE";
    EXPECT_EQ(quiet->err, "no\n");
    EXPECT_EQ(quiet->status, 3);
    const auto much = run_quietly({{"/bin/sh", "-c", "head -c 300000 /dev/zero"}, 1000, longest}, always);
    ASSERT_TRUE(much);
    EXPECT_EQ(much->out.size(), 1000U);
}

TEST(QuietProgramTest, IsKilledWhenItMayNotGoOnOrTakesTooLong) {
    const auto began = std::chrono::steady_clock::now();
    int turns = 0;
    EXPECT_FALSE(run_quietly({{"/bin/sh", "-c", "sleep 100 & sleep 100"}, 10, std::chrono::seconds{100}},
                             [&] { return ++turns < 3; }));
    const auto late =
        run_quietly({{"/bin/sh", "-c", "sleep 100"}, 10, std::chrono::seconds{0}}, [] { return true; });
    ASSERT_TRUE(late);
    EXPECT_TRUE(late->late);
    EXPECT_EQ(late->status, 128 + 9);
    EXPECT_LT(std::chrono::steady_clock::now() - began, std::chrono::seconds{20});
}

}  // namespace
}  // namespace shaker::catalogue
