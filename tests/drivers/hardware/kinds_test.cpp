// A kind of device that exists only in this test, in a separate table of kinds.
#include <gtest/gtest.h>

#include "drivers/errors.hpp"
#include "drivers/hardware/hardware_rig.hpp"

namespace shaker::hardware {
namespace {

class DrawnCamera final : public Camera {
public:
    DrawnCamera(View view, double level) : grey{level}, view_{std::move(view)} {}
    [[nodiscard]] const View& view() const override { return view_; }
    FramePtr read(std::chrono::milliseconds /*wait*/) override { return nullptr; }
    [[nodiscard]] bool ended() const noexcept override { return true; }
    void stop() noexcept override {}

    const double grey;

private:
    View view_;
};

class StillAccelerometer final : public Accelerometer {
public:
    [[nodiscard]] AccelerometerInfo info() const override { return {.name = "still"}; }
    bool read(AccelBlock& /*block*/, std::chrono::milliseconds /*wait*/) override { return false; }
    [[nodiscard]] bool ended() const noexcept override { return true; }
    void stop() noexcept override {}
};

class SilentDac final : public Dac {
public:
    [[nodiscard]] DacInfo info() const override {
        return {.name = "silent", .queue_frames = 2400, .ramp_frames = 960};
    }
    PlayTime write(std::span<const double> /*volts*/, std::span<const double> /*trigger*/) override {
        return {};
    }
    void stop() noexcept override {}
};

class StillInput final : public gpio::InputLine {
public:
    [[nodiscard]] std::optional<Levels> watch(std::chrono::milliseconds /*wait*/) noexcept override {
        return Levels{};
    }
};

int opened = 0;
std::vector<std::string> lines_opened;

std::unique_ptr<gpio::InputLine> open_still_input(const gpio::LineName& at, gpio::Pull /*pull*/) {
    lines_opened.push_back(at.text());
    return std::make_unique<StillInput>();
}

OpenCamera read_drawn(SettingsTable& table, View& view) {
    view.dac_triggered = table.flag("triggered", false);
    return [grey = table.number("grey", {0, 255})](View sees, Notes& notes) {
        ++opened;
        notes.push_back("drawn");
        return std::make_unique<DrawnCamera>(std::move(sees), grey);
    };
}

OpenAccelerometer read_still(SettingsTable& /*table*/) {
    return [](Notes& /*notes*/) { return std::make_unique<StillAccelerometer>(); };
}

OpenDac read_silent(SettingsTable& /*table*/) {
    return [](Notes& notes) {
        notes.push_back("plays nothing");
        return std::make_unique<SilentDac>();
    };
}

std::vector<ListedDevice> list_drawn(const Search& search) {
    const std::string where = search.contains("--paper") ? search.at("--paper").front() : "desk";
    return {{"  driver = \"drawn\" at " + where + "\n", R"({"id":"drawn"})"}};
}

std::vector<ListedDevice> list_none(const Search& /*search*/) { return {}; }

constexpr std::array drawn_search{SearchOption{.name = "--paper", .value = "PLACE", .help = "Search here"}};
constexpr std::array cameras{CameraKind{.name = "drawn",
                                        .heading = "[[camera]] drawn",
                                        .key = "drawn_cameras",
                                        .read = read_drawn,
                                        .list = list_drawn,
                                        .search = drawn_search},
                             video::video_kind};
constexpr std::array accelerometers{AccelerometerKind{.name = "still",
                                                      .heading = "[accelerometer]",
                                                      .key = "accelerometers",
                                                      .read = read_still,
                                                      .list = list_none}};
constexpr std::array dacs{
    DacKind{.name = "silent",
            .heading = "[dac]",
            .key = "dacs",
            .read = read_silent,
            .list = list_none,
            .search = {},
            .advice = {.silent = "is it meant to be silent?", .rate_off = "who counts?"}}};
constexpr Kinds tables{
    .dacs = dacs, .accelerometers = accelerometers, .cameras = cameras, .open_line = open_still_input};

std::string rig_file(const std::string& camera, const std::string& dac = {}) {
    return "[dac]\n" + dac +
           "[accelerometer]\ndriver = \"still\"\n[[camera]]\nname = \"top\"\nmm_per_px = 0.1\n" + camera +
           "[[camera.target]]\nname = \"walker\"\nkind = \"disc\"\ndiameter_mm = 4\nroi_px = [0, 0, 20, "
           "20]\n";
}

std::string contact(const std::string& line) {
    return "[abort]\nchip = \"gpiochip0\"\nline = \"" + line + "\"\n";
}

std::string refusal(const std::string& text) {
    try {
        SettingsTable root = SettingsTable::from_text(text, "rig.toml");
        open_hardware_rig(root, tables);
    } catch (const InputError& e) {
        return e.what();
    }
    return "accepted";
}

void expect_in(const std::string& text, const std::vector<std::string>& parts) {
    for (const std::string& part : parts)
        EXPECT_NE(text.find(part), std::string::npos) << part << " is not in: " << text;
}

TEST(KindsTest, ARowIsEnoughToReadAndOpenADevice) {
    SettingsTable root = SettingsTable::from_text(
        rig_file("driver = \"drawn\"\ngrey = 7\ntriggered = true\ntrigger_delay_s = 0.25\n"), "rig.toml");
    const HardwareRig bench = open_hardware_rig(root, tables);
    ASSERT_EQ(bench.rig.cameras.size(), 1U);
    const auto* camera = dynamic_cast<const DrawnCamera*>(bench.rig.cameras[0].get());
    ASSERT_NE(camera, nullptr);
    EXPECT_EQ(camera->grey, 7);
    EXPECT_EQ(camera->view().camera, "top");
    EXPECT_TRUE(camera->view().dac_triggered);
    EXPECT_EQ(camera->view().trigger_delay_s, 0.25);
    EXPECT_EQ(bench.rig.accelerometer->info().name, "still");
    EXPECT_EQ(bench.rig.dac->info().name, "silent");
    EXPECT_EQ(bench.granted, (Notes{"camera \"top\": drawn", "plays nothing"}));
    EXPECT_EQ(bench.rig.advice.dac, dacs[0].advice);
    EXPECT_EQ(bench.rig.advice.accelerometer, DeviceAdvice{});
    EXPECT_EQ(bench.rig.advice.cameras, (std::vector{DeviceAdvice{}}));
}

TEST(KindsTest, AnUnknownKindIsNamedWithTheAllowedOnes) {
    expect_in(refusal(rig_file("driver = \"pinhole\"\n")),
              {"rig.toml", "driver", "\"pinhole\"", "\"drawn\", \"video\""});
    expect_in(refusal(rig_file("")), {"rig.toml", "driver", "missing", "\"drawn\", \"video\""});
    expect_in(refusal(rig_file("driver = \"drawn\"\ngrey = 7\n", "driver = \"loud\"\n")),
              {"rig.toml", "dac.driver", "\"loud\"", "\"silent\""});
}

TEST(KindsTest, ReadsWholeFileBeforeOpeningDevices) {
    opened = 0;
    expect_in(refusal(rig_file("driver = \"drawn\"\ngrey = 7\ncolour = 3\n")), {"colour"});
    expect_in(refusal(rig_file("driver = \"drawn\"\ngrey = 256\n")), {"grey", "256", "0 to 255"});
    EXPECT_EQ(opened, 0);
}

TEST(KindsTest, AbortInputIsOpenedAfterTheDac) {
    lines_opened.clear();
    SettingsTable root =
        SettingsTable::from_text(rig_file("driver = \"drawn\"\ngrey = 7\n") + contact("27"), "rig.toml");
    const HardwareRig bench = open_hardware_rig(root, tables);
    EXPECT_NE(bench.rig.abort_input, nullptr);
    EXPECT_EQ(lines_opened, (Notes{"line 27 of gpiochip0"}));
    ASSERT_EQ(bench.granted.size(), 3U);
    expect_in(bench.granted[2], {"abort input: line 27 of gpiochip0, closed is low"});
    expect_in(refusal(rig_file("driver = \"drawn\"\ngrey = 7\n") + "[enable]\nline = \"17\"\n"),
              {"rig.toml", "enable"});
}

TEST(KindsTest, ARowIsEnoughToListDevices) {
    constexpr Kinds drawn_only{
        .dacs = dacs, .accelerometers = accelerometers, .cameras = {cameras.data(), 1}};
    const std::vector<ListedKind> listed = list_devices({{"--paper", {"wall"}}}, drawn_only);
    ASSERT_EQ(listed.size(), 3U);
    EXPECT_TRUE(listed[0].devices.empty());
    EXPECT_EQ(listed[2].heading, "[[camera]] drawn");
    EXPECT_EQ(listed[2].key, "drawn_cameras");
    EXPECT_EQ(listed[2].devices.at(0).text, "  driver = \"drawn\" at wall\n");
}

TEST(KindsTest, NamesAndKeysOfTheTablesAreUnique) {
    EXPECT_EQ(find_kind(std::span<const CameraKind>{camera_kinds}, "genicam")->key, "genicam_cameras");
    EXPECT_EQ(find_kind(std::span<const CameraKind>{camera_kinds}, "video")->key, "video_cameras");
    EXPECT_EQ(find_kind(std::span<const CameraKind>{camera_kinds}, "drawn"), nullptr);
    std::vector<std::string_view> keys;
    for (const CameraKind& kind : camera_kinds) keys.push_back(kind.key);
    for (const AccelerometerKind& kind : accelerometer_kinds) keys.push_back(kind.key);
    for (const DacKind& kind : dac_kinds) keys.push_back(kind.key);
    std::ranges::sort(keys);
    EXPECT_EQ(std::ranges::adjacent_find(keys), keys.end());
}

}  // namespace
}  // namespace shaker::hardware
