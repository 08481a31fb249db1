// Ten minutes of the whole program on the mock bench with random faults, while other processes use all
// processors. Program and mock bench must count equal losses. SHAKER_LONG_S: another duration, s.
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <functional>
#include <nlohmann/json.hpp>
#include <random>
#include <thread>

#include "tests/support/run/bench_run.hpp"

namespace shaker::test {
namespace {

/// One busy process per processor.
class Load {
public:
    Load() {
        const pid_t parent = ::getpid();
        for (unsigned i = 0; i < std::thread::hardware_concurrency(); ++i) {
            const pid_t pid = ::fork();
            if (pid == 0) {
                while (::getppid() == parent) {
                }
                std::_Exit(0);
            }
            pids_.push_back(pid);
        }
    }
    ~Load() {
        for (const pid_t pid : pids_) {
            ::kill(pid, SIGKILL);
            ::waitpid(pid, nullptr, 0);
        }
    }
    Load(const Load&) = delete;
    Load& operator=(const Load&) = delete;

private:
    std::vector<pid_t> pids_;
};

double length_s() {
    const char* text = std::getenv("SHAKER_LONG_S");
    return text != nullptr ? std::atof(text) : 600;
}

std::uint64_t never_came(const mock::GigeCounts& c) { return c.damaged + c.dropped + c.overflow; }

/// Causes a random fault of the sensors.
void cause_one(mock::MockBench& b, const std::function<int(int)>& pick) {
    b.camera("side").lose(0);
    switch (pick(6)) {
        case 1:
            return b.accelerometer().drop(static_cast<std::uint64_t>(pick(300)));
        case 2:
            return b.accelerometer().silence(0.1 * pick(5));
        case 3:
            return b.camera("top").drop(static_cast<std::uint64_t>(pick(20)));
        case 4:
            return b.camera("side").drop(static_cast<std::uint64_t>(pick(20)));
        case 5:
            return b.camera("top").stall(0.02 * pick(10));
        default:
            return b.camera("side").lose(0.01);
    }
}

TEST(LoadTest, LossesUnderLoadAgreeOnBothSides) {
    const Load load;
    BenchRun run{37.5, "[walker]\nstart_mm = 0\n"};
    const double length = length_s();
    // A single harmonic causes no drift, so the walker stays in view.
    run.start("--gamma 1.5g --rho 1 --periods " + std::to_string(std::lround(20 * length)));
    std::mt19937 random{7};
    const auto pick = [&](int most) { return 1 + static_cast<int>(random() % static_cast<unsigned>(most)); };
    mock::MockBench& b = run.bench;
    // The drive restarts after an underrun. The underrun is early, so that the measurement is complete.
    ASSERT_TRUE(run.played(2)) << end_of(run.finish().err);
    b.dac().cause_underrun();
    int faults = 1;
    for (double t = 4; t < length && run.played(t); t += 0.5 * pick(10), ++faults) cause_one(b, pick);
    b.camera("side").lose(0);
    const Outcome o = run.program().wait(2 * length + 60);
    ASSERT_EQ(o.status, 0) << end_of(o.err);
    const auto r = nlohmann::json::parse(o.out);

    const auto dac = device(r, "shaker_mock"), accelerometer = device(r, "adxl355");
    const mock::ConverterCounts d = b.dac().counts();
    const mock::IiodCounts a = b.accelerometer().counts();
    std::printf("%d faults in %.0f s under load; processor time of the program %.1f s\n", faults, length,
                o.cpu_s);
    std::printf("%-24s %12s %12s\n", "lost", "by shakerd", "by the mock");
    const auto row = [](const char* what, const nlohmann::json& ours, std::uint64_t theirs) {
        std::printf("%-24s %12llu %12llu\n", what, static_cast<unsigned long long>(ours.get<std::uint64_t>()),
                    static_cast<unsigned long long>(theirs));
        EXPECT_EQ(ours, theirs) << what;
    };
    row("DAC, underruns", dac.at("incidents"), d.underruns);
    row("accelerometer, samples", accelerometer.at("lost"), a.dropped + a.overflowed);
    row("camera top, frames", device(r, "\"top\"").at("lost"),
        never_came(b.camera("top").counts()) + b.pulses_left_out());
    row("camera side, frames", device(r, "\"side\"").at("lost"),
        never_came(b.camera("side").counts()) + b.pulses_left_out());
    const double v_true = b.drift(1, r.at("from_s"), r.at("to_s"), r.at("frequency_hz")),
                 v_D = r.at("v_D_mps");
    std::printf("v_D %.5f mm/s, true %.5f mm/s\n", 1e3 * v_D, 1e3 * v_true);
    EXPECT_NEAR(v_D, v_true, 1e-6);
}

}  // namespace
}  // namespace shaker::test
