// A bench with one analog sensor that was wired or set wrongly: "shakerd check" names the cause.
#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/program.hpp"

namespace shaker::commands {
namespace {

using test::Outcome;

struct Mistake {
    const char* name;
    const char* sensor;  // keys of [accelerometer] of the scene
    const char* others;  // tables of the scene
    const char* said;    // words of the finding
};

// The sensor has one axis and no gravity.
const std::array mistakes{
    Mistake{"right", "", "", "the bench is fit to run"},
    Mistake{"lead_off", "", "[[fault]]\nat_s = 0\nwhat = 'open'\n",
            "does not show the motion that the cameras see"},
    Mistake{"conditioner_gain_of_ten_forgotten", "gain_x = 10\n", "",
            "a factor of 10 (or 1/10) is often the gain of a conditioner"},
    Mistake{"sensitivity_per_mps2_taken_as_per_g", "gain_x = 0.101972\n", "",
            "is often a sensitivity per m/s^2 that was entered per g"},
    Mistake{"full_scale_in_rms_volts", "gain_x = 0.707107\n", "", "is often a full_scale_V in rms volts"},
    Mistake{"drive_behind_the_volume_knob", "", "[[fault]]\nat_s = 0\nwhat = 'amplifier_gain'\nvalue = 0.1\n",
            "any volume knob"},
    Mistake{"sensor_points_backwards", "gain_x = -1\n", "",
            "the cameras disagree: correct the sign of the sensor's shaker_axis"},
    Mistake{"input_muted", "noise_mps2_rthz = 0\n", "[[fault]]\nat_s = 0\nwhat = 'open'\n",
            "an axis is constant, even without noise"},
    Mistake{"hum_of_a_ground_loop", "mains_mps2 = 1\n", "", "large: check for hum"},
    Mistake{"range_too_small", "range_mps2 = 1\n", "", "exceeds the limit of 0.8 m/s^2"},
    Mistake{"another_card_as_its_own_clock", "clock_ppm = 20000\n", "", "too far off for a crystal"},
    Mistake{"wires_of_the_shaker_swapped", "", "[[fault]]\nat_s = 0\nwhat = 'amplifier_gain'\nvalue = -1\n",
            "swap the wires of the shaker"},
    Mistake{"amplifier_off", "", "[[fault]]\nat_s = 0\nwhat = 'amplifier_gain'\nvalue = 1e-6\n",
            "base does not move"},
    Mistake{"amplifier_gain_of_five", "", "[[fault]]\nat_s = 0\nwhat = 'amplifier_gain'\nvalue = 5\n",
            "check the amplifier's gain, any volume knob, full_scale_V, the masses"},
    Mistake{"lens_of_another_scale", "", "[side]\ntrue_mm_per_px = 0.6\n", "check mm_per_px, offset_mm"}};

struct WrongWiringTest : testing::TestWithParam<Mistake> {};

TEST_P(WrongWiringTest, CheckNamesTheCause) {
    const Mistake& m = GetParam();
    const auto folder = test::fresh_folder();
    std::string others = m.others, top, side;
    const std::string of_side = "[side]\n";
    if (others.starts_with(of_side)) side = std::exchange(others, "").substr(of_side.size());
    std::ofstream{folder / "bench.toml"}
        << "[accelerometer]\naxes = 1\ngravity = 0\nyaw_deg = 0\nhigh_pass_hz = 0.05\n"
        << m.sensor << "[top]\npositions = 1\n[side]\npositions = 1\n"
        << side << others;
    const Outcome o = test::shakerd("check --scene bench.toml", folder);
    EXPECT_NE(o.out.find(m.said), std::string::npos) << o.out << o.err;
    EXPECT_EQ(std::string{m.name} == "right",
              o.out.find("look ") == std::string::npos && o.out.find("BAD ") == std::string::npos)
        << o.out;
}

INSTANTIATE_TEST_SUITE_P(All, WrongWiringTest, testing::ValuesIn(mistakes),
                         [](const auto& from) { return std::string{from.param.name}; });

}  // namespace
}  // namespace shaker::commands
