// The commissioning on the mock bench, with the operator's answers on standard input.
#include <gtest/gtest.h>

#include <csignal>
#include <fstream>
#include <iterator>

#include "drivers/commissioned/record.hpp"
#include "tests/support/in_real_time.hpp"
#include "tests/support/nightly.hpp"
#include "tests/support/program.hpp"
#include "tests/support/remote/tcp_client.hpp"
#include "tests/support/run/bench_run.hpp"

namespace shaker::commissioning {
namespace {

struct CommissionTest : testing::Test {
    test::BenchRun bench;
    std::filesystem::path rig = bench.bench.rig_file();
    std::filesystem::path record = commissioned::record_of(rig);

    void SetUp() override {
        if (!test::in_real_time) GTEST_SKIP() << "not in real time under a sanitiser";
        std::filesystem::remove(record);
    }
    /// Most waits count periods of the drive.
    test::Outcome commission(const std::string& answers) {
        const std::string frequency = test::nightly() ? "20Hz" : "60Hz";
        test::Program program{"shakerd",
                              "check --commission --frequency " + frequency + " --rig '" + rig.string() + "'",
                              bench.folder, answers};
        return program.wait(170);
    }
    [[nodiscard]] std::string recorded() const {
        std::ifstream in{record};
        return {std::istreambuf_iterator<char>{in}, {}};
    }
};

TEST_F(CommissionTest, LeadsThroughTheDayAndLeavesARecord) {
    bench.rig("second_channel", "\"trigger\"\nenable_channel = 3");
    const test::Outcome o = commission("y\ny\ny\ny\ny\ny\n");
    ASSERT_EQ(o.status, 0) << o.out << o.err;
    for (const char* item :
         {"rig_sha256", "date", "polarity by hand", "enable output, at rest", "enable output, with the drive",
          "gain by a known step", "on purpose, acceleration", "on purpose, velocity",
          "on purpose, displacement", "on purpose, drive", "\"ramp\"", "abort by SCPI over TCP",
          "abort by SCPI on the Unix socket", "abort by HTTP", "emergency stop"})
        EXPECT_NE(recorded().find(item), std::string::npos) << item << "\n" << recorded();
    std::ifstream in{rig};
    const std::string text{std::istreambuf_iterator<char>{in}, {}};
    EXPECT_EQ(commissioned::missing_record(rig, text), "");
    EXPECT_NE(commissioned::missing_record(rig, text + "# changed"), "");
}

TEST_F(CommissionTest, DeniedTestLeavesNoRecord) {
    const test::Outcome o = commission("n\n");
    EXPECT_EQ(o.status, 3) << o.out << o.err;
    EXPECT_NE(o.out.find("polarity by hand: not confirmed"), std::string::npos) << o.out;
    EXPECT_FALSE(std::filesystem::exists(record));
}

// The first drive takes several seconds.
TEST_F(CommissionTest, InterruptInMidDriveEndsSoftly) {
    test::Program program{"shakerd", "check --commission --rig '" + rig.string() + "'", bench.folder, "y\n"};
    const auto driven = [&] {
        std::ifstream in{program.printed()};
        const std::string text{std::istreambuf_iterator<char>{in}, {}};
        return text.find("polarity by hand: confirmed") != std::string::npos;
    };
    for (int i = 0; i < 1000 && !driven() && !program.ended(); ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds{20});
    ASSERT_TRUE(driven());
    std::this_thread::sleep_for(std::chrono::seconds{2});
    const auto underruns = bench.bench.dac().counts().underruns;
    ::kill(program.pid(), SIGINT);
    const test::Outcome o = program.wait(30);
    EXPECT_EQ(o.status, 128 + SIGINT) << o.out << o.err;
    EXPECT_NE(o.err.find("interrupted by SIGINT"), std::string::npos) << o.err;
    EXPECT_EQ(bench.bench.dac().counts().underruns, underruns) << "it played its ramp";
    EXPECT_FALSE(std::filesystem::exists(record));
}

TEST_F(CommissionTest, ServiceWithoutRecordDrivesNothing) {
    const std::string socket = (bench.folder / "scpi").string();
    std::ofstream{bench.folder / "settings.toml"}
        << "[serve]\nhttp_port = 0\nscpi_port = 0\nscpi_socket = \"" + socket +
               "\"\nrecordings = \".\"\n[run]\nrig = \"" + rig.string() + "\"\nframes = \"off\"\n";
    test::Program program{"shakerd", "serve --settings settings.toml", bench.folder};
    const auto idle = [&] {
        for (int i = 0; i < 1000 && !program.ended(); ++i) {
            std::ifstream in{program.said()};
            const std::string said{std::istreambuf_iterator<char>{in}, {}};
            if (said.find("state: idle") != std::string::npos) return true;
            std::this_thread::sleep_for(std::chrono::milliseconds{20});
        }
        return false;
    };
    ASSERT_TRUE(idle());
    test::TcpClient client{std::filesystem::path{socket}};
    client.send("OUTP ON;*WAI");
    const std::string error = client.ask("SYST:ERR?");
    EXPECT_NE(error.find("has not been commissioned"), std::string::npos) << error;
    EXPECT_NE(error.find("check --commission --rig"), std::string::npos) << error;
    EXPECT_EQ(client.ask("OUTP?"), "0");
}

TEST(CommissionCommandTest, SimulatedBenchNeedsNone) {
    const test::Outcome o = test::shakerd("check --commission --rig sim:", test::fresh_folder());
    EXPECT_EQ(o.status, 2) << o.err;
}

}  // namespace
}  // namespace shaker::commissioning
