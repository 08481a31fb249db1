// The rate of the trigger pulses: that of the cameras, or what the rig file asks for.
#include <gtest/gtest.h>

#include "daemon/acquisition/run_loops.hpp"
#include "drivers/errors.hpp"

namespace shaker::acquisition {
namespace {

class SilentDac final : public Dac {
public:
    explicit SilentDac(double pulse_hz) : pulse_hz_{pulse_hz} {}
    [[nodiscard]] DacInfo info() const override { return {.name = "dac", .pulse_hz = pulse_hz_}; }
    PlayTime write(std::span<const double>, std::span<const double>) override { return {}; }
    void stop() noexcept override {}

private:
    double pulse_hz_;
};

class BlindCamera final : public Camera {
public:
    BlindCamera(double rate_hz, bool triggered) {
        view_.camera = "top";
        view_.frame_rate_hz = rate_hz;
        view_.dac_triggered = triggered;
    }
    [[nodiscard]] const View& view() const override { return view_; }
    FramePtr read(std::chrono::milliseconds) override { return nullptr; }
    [[nodiscard]] bool ended() const noexcept override { return false; }
    void stop() noexcept override {}

private:
    View view_;
};

Rig rig(double pulse_hz, double camera_hz, bool triggered) {
    Rig r;
    r.dac = std::make_unique<SilentDac>(pulse_hz);
    r.cameras.push_back(std::make_unique<BlindCamera>(camera_hz, triggered));
    return r;
}

TEST(TriggerRateTest, PulsesNeedNoCameraThatAsksForThem) {
    EXPECT_EQ(trigger_rate(rig(0, 200, false)), 0);
    EXPECT_EQ(trigger_rate(rig(1000, 200, false)), 1000);
    EXPECT_EQ(trigger_rate(rig(0, 200, true)), 200);
    EXPECT_EQ(trigger_rate(rig(200, 200, true)), 200);
    try {
        trigger_rate(rig(1000, 200, true));
        ADD_FAILURE() << "two rates were accepted";
    } catch (const InputError& e) {
        EXPECT_NE(std::string{e.what()}.find("pulse_hz = 1000"), std::string::npos) << e.what();
    }
}

}  // namespace
}  // namespace shaker::acquisition
