// The service unit: what it allows is what the program requests.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <sstream>

#include "daemon/run/sequence.hpp"
#include "daemon/service/heartbeats.hpp"
#include "drivers/realtime.hpp"
#include "tests/support/paths.hpp"

namespace shaker {
namespace {

/// The values of each key, in the order of the file.
std::map<std::string, std::vector<std::string>> keys_of(std::istream& unit) {
    std::map<std::string, std::vector<std::string>> keys;
    for (std::string line; std::getline(unit, line);) {
        const auto equals = line.find('=');
        if (line.starts_with('#') || equals == std::string::npos) continue;
        keys[line.substr(0, equals)].push_back(line.substr(equals + 1));
    }
    return keys;
}

struct UnitTest : testing::Test {
    std::ifstream file{test::source_dir() + "/systemd/shakerd.service"};
    std::map<std::string, std::vector<std::string>> unit = keys_of(file);

    double number(const std::string& key) { return std::stod(unit.at(key).at(0)); }
    std::string text(const std::string& key) { return unit.at(key).at(0); }
};

TEST_F(UnitTest, KeeperOfTheRampOutlivesTheDaemon) {
    // "mixed" and "process" send SIGKILL to the rest of the group; the keeper blocks SIGTERM.
    EXPECT_EQ(text("KillMode"), "control-group");
    EXPECT_FALSE(unit.contains("SendSIGKILL"));
    EXPECT_EQ(text("OOMPolicy"), "continue");
}

TEST_F(UnitTest, StopTimeCoversSlowestSoftStop) {
    constexpr double longest_buffer_s = 2;
    EXPECT_GE(number("TimeoutStopSec"), run::longest_soft_stop_s + longest_buffer_s);
    EXPECT_GE(number("TimeoutStopSec"),
              std::chrono::duration<double>{service::SystemdNotify::stop_patience}.count());
}

TEST_F(UnitTest, MemoryAndPrioritiesAreAllowed) {
    EXPECT_EQ(text("LimitMEMLOCK"), "infinity") << "lock_memory() locks nothing below a limit";
    using namespace fifo_priority;
    EXPECT_GE(number("LimitRTPRIO"),
              std::max({output, abort_input, accelerometer, doors + 1, camera, recorder}));
    const std::vector<std::string>& filters = unit.at("SystemCallFilter");
    for (const char* call : {"sched_setscheduler", "mlockall"})
        EXPECT_NE(filters.back().find(call), std::string::npos) << call;
}

TEST_F(UnitTest, DiscoveryOfDevicesHasItsSockets) {
    for (const char* family : {"AF_UNIX", "AF_INET", "AF_INET6", "AF_NETLINK"})
        EXPECT_NE(text("RestrictAddressFamilies").find(family), std::string::npos) << family;
}

TEST_F(UnitTest, FailureIsReported) {
    EXPECT_EQ(text("OnFailure"), "shakerd-failed.service");
    std::ifstream failed{test::source_dir() + "/systemd/shakerd-failed.service"};
    EXPECT_FALSE(keys_of(failed)["ExecStart"].empty());
}

TEST_F(UnitTest, EveryKindOfDeviceIsAllowed) {
    const std::vector<std::string>& allowed = unit.at("DeviceAllow");
    for (const char* device : {"char-alsa rw", "char-iio rw", "char-video4linux rw", "char-usb_device rw"})
        EXPECT_EQ(std::ranges::count(allowed, device), 1) << device;
}

}  // namespace
}  // namespace shaker
