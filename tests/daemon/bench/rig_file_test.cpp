// Rig files written by operators: errors are reported with file, line, key and allowed values, before any
// device is opened.
#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/paths.hpp"
#include "tests/support/program.hpp"

namespace shaker::test {
namespace {

/// A TOML example of a document, from 1.
std::string example_of(const std::filesystem::path& document, int number) {
    std::ifstream in{document};
    std::string text;
    bool inside = false;
    for (std::string line; std::getline(in, line);) {
        if (inside && line == "```") break;
        if (inside) text += line + "\n";
        if (line == "```toml") inside = --number == 0;
    }
    return text;
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
    const auto at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

struct RigFileTest : testing::Test {
    std::filesystem::path folder = fresh_folder();
    std::string analog = example_of(test::source_dir() + "/drivers/hardware/WIRING.md", 1),
                wiring = example_of(test::source_dir() + "/drivers/hardware/WIRING.md", 2);

    ~RigFileTest() override { std::filesystem::remove_all(folder); }
    Outcome check(const std::string& text) {
        std::ofstream{folder / "rig.toml"} << text;
        return shakerd("check --rig rig.toml", folder);
    }
    void expect_refused(const std::string& text, const std::vector<std::string>& words) {
        const Outcome o = check(text);
        EXPECT_EQ(o.status, 2) << o.err;
        EXPECT_EQ(o.out, "");
        for (const std::string& word : words)
            EXPECT_NE(o.err.find(word), std::string::npos) << "\"" << word << "\" is not in: " << o.err;
    }
};

TEST_F(RigFileTest, ReadsTheWiringGuidesExampleUpToItsDevices) {
    const Outcome o = check(wiring);
    EXPECT_EQ(o.status, 3) << o.err;
    EXPECT_NE(o.err.find("Vendor-Model-Serial"), std::string::npos) << "no such camera here: " << o.err;
}

TEST_F(RigFileTest, ReadsTheBenchWithOneSoundCardUpToItsDevices) {
    const std::string bench = analog + wiring.substr(wiring.find("[shaker]"));
    const Outcome o = check(bench);
    EXPECT_EQ(o.status, 3) << o.err;
    EXPECT_NE(o.err.find("Vendor-Model-Serial"), std::string::npos) << "no such camera here: " << o.err;
    expect_refused(replaced(bench, "channels = [3]", "channels = [3, 3]"),
                   {"accelerometer.channels", "twice"});
    expect_refused(replaced(bench, "driver = \"alsa\"", "driver = \"comedi\""),
                   {"accelerometer.driver", "\"iio\", \"alsa\""});
    expect_refused(replaced(bench, "trigger_channel = 4", "trigger_channel = 3"), {"dac.trigger_channel"});
}

TEST_F(RigFileTest, GravityOfThePlaceIsASetting) {
    EXPECT_EQ(check("gravity_mps2 = 9.81\n" + wiring).status, 3) << "understood up to its devices";
    expect_refused("gravity_mps2 = 1.62\n" + wiring, {"rig.toml:1", "gravity_mps2", "1.62", "9.75"});
}

TEST_F(RigFileTest, CalibrationFileIsReadBeforeAnyDevice) {
    const std::string named =
        replaced(wiring, "[accelerometer]", "[accelerometer]\ncalibration = \"cal.toml\"");
    expect_refused(named, {"calibration file cal.toml: cannot be read: No such file"});
    std::ofstream{folder / "cal.toml"} << "attitudes = 19\nsha256 = \"0\"\n";
    expect_refused(named, {"cal.toml: was changed after it was written", "shakerd calibrate accelerometer"});
}

TEST_F(RigFileTest, NamesMissingTables) {
    expect_refused(replaced(wiring, "[dac]", "[shaker.dac]"), {"rig.toml", "dac"});
    expect_refused("", {"rig.toml", "dac", "missing"});
    expect_refused(replaced(wiring, "full_scale_V", "# "), {"rig.toml", "dac.full_scale_V", "missing"});
    expect_refused(replaced(wiring, "[shaker]", "[shaker.spare]"), {"rig.toml", "shaker"});
    expect_refused(replaced(replaced(wiring, "model =", "# "), "stroke_mm", "# "),
                   {"rig.toml", "shaker.stroke_mm", "rating", "model"});
    expect_refused("real_time = \"no\"\n" + wiring, {"rig.toml:1", "real_time", "required", "wanted"});
    expect_refused(replaced(wiring, "pcm = ", "# "), {"rig.toml", "dac.pcm", "missing"});
    expect_refused(replaced(wiring, "driver = ", "# "), {"rig.toml", "camera", "driver", "genicam"});
    expect_refused(replaced(wiring, "id = ", "# "), {"rig.toml", "camera", "id", "missing"});
}

TEST_F(RigFileTest, ShakerWithoutModelNeedsAllThatTheLimitsFollowFrom) {
    const std::string own = replaced(wiring, "model =", "# ");
    EXPECT_EQ(check(own).status, 3) << "understood up to its devices";
    expect_refused(replaced(replaced(own, "force_factor_npa", "# "), "\namplifier_gain", "\n# "),
                   {"rig.toml", "shaker.", "Missing keys: force_factor_npa, amplifier_gain\n", "model"});
    expect_refused(replaced(own, "\ndrive = ", "\n# "), {"Missing keys: drive\n"});
    for (const char* key : {"resistance_ohm", "moving_mass_kg", "base_mass_kg"})
        expect_refused(replaced(own, key, "# "), {std::string{"Missing keys: "} + key + "\n"});
    const std::string current = replaced(own, "drive = \"voltage\"", "drive = \"current\"");
    EXPECT_EQ(check(replaced(current, "resistance_ohm", "# ")).status, 3) << "its amplifier sends a current";
}

TEST_F(RigFileTest, NamesRefusedValueWithAllowedOnes) {
    expect_refused(replaced(wiring, "rate_hz = 48000", "rate_hz = 48"),
                   {"rig.toml:3", "dac.rate_hz", "48", "8000"});
    expect_refused(replaced(wiring, "\"S32\"", "\"S33\""), {"rig.toml:4", "dac.format", "S33", "S24_3"});
    expect_refused(replaced(wiring, "buffer_frames = 3360", "buffer_frames = 480"),
                   {"rig.toml:6", "dac.buffer_frames", "480", "ramp"});
    expect_refused(replaced(wiring, "uri = \"ip:", "uri = \"tcp:"),
                   {"accelerometer.uri", "tcp:192", "ip:host"});
    expect_refused(replaced(wiring, "trigger = \"dac\"", "trigger = \"sun\""),
                   {"camera", "trigger", "sun", "software"});
    expect_refused(replaced(wiring, "Mono8", "Mono9"), {"pixel_format", "Mono9", "Mono12Packed"});
    expect_refused(replaced(wiring, "second_level = 1 ", "second_levl = 1 "), {"dac.second_levl"});
    expect_refused(replaced(wiring, "moving_mass_kg = 0.057", "moving_mass_kg = -1"),
                   {"shaker.moving_mass_kg", "-1"});
}

TEST_F(RigFileTest, RefusesMissingFileAndMisplacedScene) {
    Outcome o = shakerd("run --rig none.toml", folder);
    EXPECT_EQ(o.status, 2);
    EXPECT_NE(o.err.find("\"none.toml\": no such file"), std::string::npos) << o.err;
    std::ofstream{folder / "rig.toml"} << wiring;
    o = shakerd("run --rig rig.toml --scene rig.toml", folder);
    EXPECT_EQ(o.status, 2);
    EXPECT_NE(o.err.find("only the simulated bench"), std::string::npos) << o.err;
}

TEST_F(RigFileTest, ListsDevicesOfAnyKind) {
    const Outcome text = shakerd("devices", folder), json = shakerd("devices --json", folder);
    EXPECT_EQ(text.status, 0) << text.err;
    EXPECT_EQ(json.status, 0) << json.err;
    for (const char* heading : {"[dac]", "[accelerometer]", "[[camera]] GenICam", "[[camera]] video"})
        EXPECT_NE(text.out.find(heading), std::string::npos) << text.out;
    for (const char* key : {"\"dacs\"", "\"accelerometers\"", "\"genicam_cameras\"", "\"video_cameras\""})
        EXPECT_NE(json.out.find(key), std::string::npos) << json.out;
}

}  // namespace
}  // namespace shaker::test
