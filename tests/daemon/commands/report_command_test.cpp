// shakerd report: the page of a measured campaign or recording, made by a process that reaches no network and
// no other file.
#include <gtest/gtest.h>
#include <spdlog/fmt/fmt.h>

#include <fstream>

#include "daemon/sandbox/outside_program.hpp"
#include "tests/support/missing_calls.hpp"
#include "tests/support/program.hpp"

namespace shaker::commands {
namespace {

constexpr const char* plan = R"(title = "<script>alert(1)</script>"
[point]
periods = 10
[[series]]
name = "2b"
gamma = ["0.5g", "0.7g", "1g"]
phi = ["0deg", "90deg"]
order = "mirror"
)";

std::string content(const std::filesystem::path& file) {
    std::ifstream in{file};
    return {std::istreambuf_iterator<char>{in}, {}};
}

TEST(ReportCommandTest, DrawsMeasuredCampaign) {
    const std::filesystem::path folder = test::fresh_folder();
    std::ofstream{folder / "plan.toml"} << plan;
    ASSERT_EQ(test::shakerd("campaign plan.toml -o points", folder).status, 0);
    const test::Outcome report = test::shakerd("report points", folder);
    ASSERT_EQ(report.status, 0) << report.out << report.err;
    EXPECT_NE(report.out.find("mu_ac"), std::string::npos) << report.out;
    const std::string page = content(folder / "points/report/report.html");
    EXPECT_EQ(page.find("<script>alert"), std::string::npos);
    EXPECT_NE(page.find("&lt;script&gt;alert(1)"), std::string::npos);
    EXPECT_NE(page.find("mu_k"), std::string::npos) << "the fits of shakerd mu";
    for (const char* file : {"fig2b.svg", "fig2b.pdf", "fig2b.png", "fig4.svg"})
        EXPECT_TRUE(std::filesystem::exists(folder / "points/report" / file)) << file;
}

TEST(ReportCommandTest, DrawsSingleRecording) {
    const std::filesystem::path folder = test::fresh_folder();
    std::ofstream{folder / "plan.toml"} << plan;
    ASSERT_EQ(test::shakerd("campaign plan.toml -o points", folder).status, 0);
    const test::Outcome report = test::shakerd("report points/r001.nxs", folder);
    ASSERT_EQ(report.status, 0) << report.out << report.err;
    EXPECT_EQ(report.err, "") << "no fits are expected of a recording";
    const std::string page = content(folder / "points/r001.report/report.html");
    for (const char* part : {"r001 #4", "true v_D", "settings"})
        EXPECT_NE(page.find(part), std::string::npos) << part;
    EXPECT_TRUE(std::filesystem::exists(folder / "points/r001.report/period_v.pdf"));
    EXPECT_EQ(test::shakerd("report points points/r001.nxs -o both", folder).status, 2);
}

TEST(ReportCommandTest, ReplacesLinksAndRefusesLinkedFolder) {
    const std::filesystem::path folder = test::fresh_folder(), out = folder / "points/report";
    std::ofstream{folder / "plan.toml"} << plan;
    std::ofstream{folder / "mine"} << "untouched";
    ASSERT_EQ(test::shakerd("campaign plan.toml -o points", folder).status, 0);
    std::filesystem::create_directories(out);
    for (const char* name : {"fits.json", "fig2b.svg", "report.html"})
        std::filesystem::create_symlink(folder / "mine", out / name);
    EXPECT_EQ(test::shakerd("report points", folder).status, 0);
    for (const char* name : {"fits.json", "fig2b.svg", "report.html"})
        EXPECT_TRUE(std::filesystem::is_regular_file(std::filesystem::symlink_status(out / name))) << name;
    EXPECT_EQ(content(folder / "mine"), "untouched");
    std::filesystem::remove_all(out);
    std::filesystem::create_directory(folder / "elsewhere");
    std::filesystem::create_directory_symlink(folder / "elsewhere", out);
    const test::Outcome refused = test::shakerd("report points", folder);
    EXPECT_EQ(refused.status, 2);
    EXPECT_NE(refused.err.find("is a link"), std::string::npos) << refused.err;
    EXPECT_TRUE(std::filesystem::is_empty(folder / "elsewhere"));
}

TEST(ReportCommandTest, RefusesWhatIsNoCampaign) {
    const std::filesystem::path folder = test::fresh_folder();
    const test::Outcome missing = test::shakerd("report nothing", folder);
    EXPECT_EQ(missing.status, 2);
    EXPECT_NE(missing.err.find("nothing: no such file or folder"), std::string::npos) << missing.err;
    std::filesystem::create_directory(folder / "empty");
    EXPECT_EQ(test::shakerd("report empty -o out", folder).status, 2);
    EXPECT_FALSE(std::filesystem::exists(folder / "out"));
}

/// Exit status of a line of Python in a process with these files; the last one is its temporary folder.
int python(const std::string& line, const sandbox::FileRights& files) {
    const std::string own = files.writes.back().string();
    return sandbox::run_outside({.words = {"/usr/bin/python3", "-I", "-c", line},
                                 .files = files,
                                 .settings = {"PATH=/usr/bin", "HOME=" + own, "TMPDIR=" + own}});
}

TEST(ReportCommandTest, OutsideProgramReachesOnlyItsFiles) {
    if (!test::has_landlock()) GTEST_SKIP() << "this kernel has no Landlock";
    const std::filesystem::path folder = test::fresh_folder();
    std::filesystem::create_directory(folder / "out");
    std::ofstream{folder / "secret"} << "x";
    std::ofstream{folder / "mine"} << "x";
    const sandbox::FileRights files{.reads = {folder / "mine"}, .writes = {folder / "out"}};
    const std::string at = folder.string();
    EXPECT_EQ(python("open('" + at + "/mine').read(); open('" + at + "/out/new', 'w').write('x')", files), 0);
    EXPECT_EQ(python("open('" + at + "/secret').read()", files), 1);
    EXPECT_EQ(python("open('" + at + "/mine', 'w')", files), 1);
    EXPECT_EQ(python("import socket; socket.socket()", files), 1);
    EXPECT_EQ(python("import h5py, numpy, matplotlib", files), 0);
}

}  // namespace
}  // namespace shaker::commands
