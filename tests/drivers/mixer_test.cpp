// Comparison of the controls of a sound card.
#include "drivers/mixer/mixer.hpp"

#include <gtest/gtest.h>

#include "drivers/hardware/alsa/mixer.hpp"

namespace shaker {
namespace {

using Changes = std::vector<std::string>;

TEST(MixerChangesTest, OnlyWhatCanBeSetIsCompared) {
    const std::string then = "iface=MIXER,name='A = B' = 1,2\n- iface=MIXER,name='Meter' = 7\nS = 0\n";
    EXPECT_EQ(mixer_changes(then, then), Changes{});
    EXPECT_EQ(mixer_changes(then, "iface=MIXER,name='A = B' = 1,2\n- iface=MIXER,name='Meter' = 9\nS = 0\n"),
              Changes{});
    EXPECT_EQ(mixer_changes(then, "iface=MIXER,name='A = B' = 1,3\nS = 0\n"),
              Changes{"iface=MIXER,name='A = B' is 1,3 instead of 1,2"});
    EXPECT_EQ(mixer_changes(then, "iface=MIXER,name='A = B' = 1,2\n"), Changes{"S is missing"});
}

TEST(MixerChangesTest, AControlThatBecomesInactiveOrActiveKeepsItsValue) {
    EXPECT_EQ(mixer_changes("A = 1\n- B = 2\n", "- A = 1\nB = 2\n"), Changes{});
    EXPECT_EQ(mixer_changes("A = 1\n- B = 2\n", "A = 1\nB = 3\n"), Changes{"B is new: 3"});
    EXPECT_EQ(mixer_changes("A = 1\n", "- A = 2\n"), Changes{"A is missing"});
}

TEST(ControlDeviceTest, IsThatOfTheCard) {
    using alsa::control_of;
    EXPECT_EQ(control_of("hw:CARD=M4,DEV=0"), "hw:CARD=M4");
    EXPECT_EQ(control_of("hw:DEV=0,CARD=M4"), "hw:CARD=M4");
    EXPECT_EQ(control_of("hw:1,0"), "hw:1");
    EXPECT_EQ(control_of("hw:M4"), "hw:M4");
    EXPECT_EQ(control_of("hw:DEV=0"), "");
    EXPECT_EQ(control_of("shaker_mock"), "");
    EXPECT_EQ(control_of("default"), "");
}

}  // namespace
}  // namespace shaker
