// The commissioning on the mock bench, with the operator's answers on standard input.
#include <gtest/gtest.h>
#include <sys/inotify.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <fstream>
#include <functional>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>

#include "calibration/accelerometer/sensor_file.hpp"
#include "drivers/commissioned/record.hpp"
#include "tests/support/in_real_time.hpp"
#include "tests/support/nightly.hpp"
#include "tests/support/program.hpp"
#include "tests/support/remote/tcp_client.hpp"
#include "tests/support/run/bench_run.hpp"

namespace shaker::commissioning {
namespace {

std::string content(const std::filesystem::path& file) {
    std::ifstream in{file};
    return {std::istreambuf_iterator<char>{in}, {}};
}

bool contains(const std::filesystem::path& file, const std::string& words) {
    return content(file).find(words) != std::string::npos;
}

/// Until the file of a program's output has these words; false when the program ended before.
bool wait_for(test::Program& program, const std::filesystem::path& file, const std::string& words) {
    for (int i = 0; i < 1000 && !contains(file, words) && !program.ended(); ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds{20});
    return contains(file, words);
}

struct CommissionTest : testing::Test {
    test::BenchRun bench;
    std::filesystem::path rig = bench.bench.rig_file();
    std::filesystem::path record = commissioned::record_of(rig);

    void SetUp() override {
        if (!test::in_real_time) GTEST_SKIP() << "not in real time under a sanitiser";
        std::filesystem::remove(record);
    }
    /// That the rig file of the mock bench names, without calibrations.
    std::vector<commissioned::Named> files() {
        return {{"alsa_config", content(bench.folder / "asound.conf")}};
    }
    /// A calibration of the mock bench's accelerometer with `size` times its true gain, and what the rig file
    /// that names it would be opened with.
    std::vector<commissioned::Named> calibrated(double size) {
        constexpr double nominal = 2 * 78.5 / (1 << 20);
        calibration::SensorCalibration c{.date = "2026-11-28",
                                         .sensor = mock::IiodDescription{}.name,
                                         .nominal_mps2_per_count = {nominal, nominal, nominal}};
        for (std::size_t k = 0; k < 3; ++k) c.fit.gain[k][k] = size * nominal;
        c.fit.gravity = {9.8, 1e-3};
        c.fit.attitudes = 12;
        c.fit.condition = 1.5;
        c.fit.chi2 = 1;
        c.fit.degrees_of_freedom = 10;
        const std::string text = calibration_text(c);
        std::ofstream{bench.folder / "acc.toml"} << text;
        auto all = files();
        all.push_back({"calibration of accelerometer", text});
        return all;
    }
    void name_calibration() {
        std::string text = content(rig);
        std::ofstream{rig} << text.insert(text.find("[accelerometer]") + 15, "\ncalibration = \"acc.toml\"");
    }
    /// Most waits count periods of the drive. driven: called once after the first confirmed test.
    test::Outcome commission(const std::string& answers, const std::function<void()>& driven = {}) {
        const std::string frequency = test::nightly() ? "20Hz" : "60Hz";
        test::Program program{"shakerd",
                              "check --commission --frequency " + frequency + " --rig '" + rig.string() + "'",
                              bench.folder, answers};
        if (driven && wait_for(program, program.printed(), "polarity by hand: confirmed")) driven();
        return program.wait(170);
    }
    /// A service of this bench in state idle.
    std::unique_ptr<test::Program> service(const std::filesystem::path& socket) {
        std::ofstream{bench.folder / "settings.toml"}
            << "[serve]\nhttp_port = 0\nscpi_port = 0\nscpi_socket = \"" + socket.string() +
                   "\"\nrecordings = \".\"\n[run]\nrig = \"" + rig.string() + "\"\nframes = \"off\"\n";
        auto program =
            std::make_unique<test::Program>("shakerd", "serve --settings settings.toml", bench.folder);
        EXPECT_TRUE(wait_for(*program, program->said(), "state: idle")) << content(program->said());
        return program;
    }
};

TEST_F(CommissionTest, LeadsThroughTheDayAndLeavesARecord) {
    bench.rig("second_channel", "\"trigger\"\nenable_channel = 3");
    const std::string text = content(rig);
    const test::Outcome o = commission("y\ny\ny\ny\ny\ny\n", [&] {
        std::ofstream{rig, std::ios::app} << "# changed\n";
    });
    ASSERT_EQ(o.status, 0) << o.out << o.err;
    for (const char* item :
         {"rig_sha256", "date", "polarity by hand", "enable output, at rest", "enable output, with the drive",
          "gain by a known step", "on purpose, acceleration", "on purpose, velocity",
          "on purpose, displacement", "on purpose, drive", "\"ramp\"", "abort by SCPI over TCP",
          "abort by SCPI on the Unix socket", "abort by HTTP", "emergency stop"})
        EXPECT_NE(content(record).find(item), std::string::npos) << item << "\n" << content(record);
    EXPECT_EQ(commissioned::missing_record(rig, text, files()), "") << "the text that was tested";
    EXPECT_NE(commissioned::missing_record(rig, content(rig), files()), "") << "the text that came later";
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
    ASSERT_TRUE(wait_for(program, program.printed(), "polarity by hand: confirmed"));
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
    const std::filesystem::path socket = bench.folder / "scpi";
    const auto program = service(socket);
    test::TcpClient client{socket};
    client.send("OUTP ON;*WAI");
    const std::string error = client.ask("SYST:ERR?");
    EXPECT_NE(error.find("has not been commissioned"), std::string::npos) << error;
    EXPECT_NE(error.find("check --commission --rig"), std::string::npos) << error;
    EXPECT_EQ(client.ask("OUTP?"), "0");
}

TEST_F(CommissionTest, ReloadTakesOnlyACoveredRigFile) {
    const auto with = [&](const std::string& limits) {
        std::string text = content(rig);
        std::ofstream{rig} << text.insert(text.find("[limits]") + 8, "\n" + limits + "\n#");
    };
    commissioned::write_record(rig, {.rig_sha256 = commissioned::rig_hash(content(rig)), .files = files()});
    const std::filesystem::path socket = bench.folder / "scpi";
    const auto program = service(socket);
    test::TcpClient client{socket};
    const std::string before = client.ask("LIM:ACC:ABOR?");
    with("acceleration_abort_mps2 = 1e6");
    ::kill(program->pid(), SIGHUP);
    EXPECT_TRUE(wait_for(*program, program->said(), "settings not reloaded")) << content(program->said());
    EXPECT_TRUE(contains(program->said(), "has changed since the bench was commissioned"));
    EXPECT_EQ(client.ask("LIM:ACC:ABOR?"), before);
    bench.rig("resistance_ohm", "2.5");
    ::kill(program->pid(), SIGHUP);
    EXPECT_TRUE(wait_for(*program, program->said(), "settings reloaded: ")) << content(program->said());
    EXPECT_TRUE(contains(program->said(), "ignored until a restart of the daemon: shaker"));
    EXPECT_EQ(client.ask("LIM:ACC:ABOR?"), "1.00000000E+06");
}

// Seen by the kernel: files of the bench's folder that are opened, except the record and what is written.
TEST_F(CommissionTest, EachFileThatTheBenchOpensIsCovered) {
    const std::vector<commissioned::Named> named = calibrated(1);
    name_calibration();
    commissioned::write_record(rig, {.rig_sha256 = commissioned::rig_hash(content(rig)), .files = named});
    const int watch = ::inotify_init1(IN_NONBLOCK);
    ASSERT_GE(::inotify_add_watch(watch, bench.folder.c_str(), IN_OPEN), 0);
    bench.start("--no-identify --periods 4 --settle 4 --gamma 0.5g");
    EXPECT_EQ(bench.finish().status, 0);
    std::set<std::string> opened;
    alignas(inotify_event) std::array<char, 1 << 16> events{};
    for (ssize_t n; (n = ::read(watch, events.data(), events.size())) > 0;)
        for (ssize_t at = 0; at < n;) {
            const auto* e = reinterpret_cast<const inotify_event*>(events.data() + at);
            if (e->len > 0) opened.insert(e->name);
            at += static_cast<ssize_t>(sizeof(inotify_event)) + e->len;
        }
    ::close(watch);
    std::size_t covered = 0;
    for (const std::string& name : opened) {
        const std::filesystem::path file = bench.folder / name;
        if (file.extension() != ".toml" && file.extension() != ".conf") continue;
        const std::string was = content(file);
        if (name == "acc.toml")
            calibrated(1.01);
        else
            std::ofstream{file, std::ios::app} << "# changed\n";
        bench.start("--no-identify --periods 4 --settle 4 --gamma 0.5g");
        const test::Outcome o = bench.finish();
        EXPECT_EQ(o.status, 2) << name << o.err;
        EXPECT_NE(o.err.find("has changed since the bench was commissioned"), std::string::npos)
            << name << o.err;
        std::ofstream{file} << was;
        ++covered;
    }
    EXPECT_EQ(covered, 3U) << "rig.toml, acc.toml, asound.conf";
}

TEST_F(CommissionTest, RecalibratedSensorAsksForTheGainOnly) {
    name_calibration();
    commissioned::write_record(rig, {.rig_sha256 = commissioned::rig_hash(content(rig)),
                                     .files = calibrated(1),
                                     .items = {{"polarity by hand", "confirmed on the first day"}}});
    const auto now = calibrated(1.02);
    const test::Outcome o = commission("");
    ASSERT_EQ(o.status, 0) << o.out << o.err;
    EXPECT_NE(content(record).find("confirmed on the first day"), std::string::npos) << content(record);
    EXPECT_NE(content(record).find("gains moved by 2.00 % at most"), std::string::npos) << content(record);
    EXPECT_EQ(commissioned::missing_record(rig, content(rig), now), "");
    calibrated(0.96);  // by 6 %: the whole day, whose first question is not answered
    EXPECT_EQ(commission("").status, 3);
    std::ofstream{record} << "date = ";  // a record that cannot be read asks for the whole day, too
    EXPECT_EQ(commission("").status, 3);
}

TEST_F(CommissionTest, RunNeedsARecordOrHalfTheLimits) {
    bench.start("--periods 4");
    const test::Outcome refused = bench.finish();
    EXPECT_EQ(refused.status, 2) << refused.err;
    EXPECT_NE(refused.err.find("has not been commissioned"), std::string::npos) << refused.err;
    EXPECT_NE(refused.err.find("--uncommissioned"), std::string::npos) << refused.err;
    bench.start("--periods 4 --uncommissioned --gamma 4g");
    const test::Outcome strong = bench.finish();
    EXPECT_EQ(strong.status, 2) << strong.err;
    EXPECT_NE(strong.err.find("31.4"), std::string::npos) << "half of 62.8 m/s^2: " << strong.err;
    bench.start("--no-identify --periods 4 --settle 4 --uncommissioned --gamma 0.5g");
    const test::Outcome o = bench.finish();
    ASSERT_EQ(o.status, 0) << o.err;
    EXPECT_NE(o.err.find("all limits are halved"), std::string::npos) << o.err;
    EXPECT_TRUE(test::noted(nlohmann::json::parse(o.out), "all limits are halved")) << o.out;
    EXPECT_EQ(bench.bench.dac().counts().streams, 1U) << "the refused runs drove nothing";
}

TEST(CommissionCommandTest, SimulatedBenchNeedsNone) {
    const test::Outcome o = test::shakerd("check --commission --rig sim:", test::fresh_folder());
    EXPECT_EQ(o.status, 2) << o.err;
}

}  // namespace
}  // namespace shaker::commissioning
