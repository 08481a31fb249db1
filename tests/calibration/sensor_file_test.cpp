#include "calibration/accelerometer/sensor_file.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "drivers/errors.hpp"
#include "tests/support/calibration/tumbled_sensor.hpp"

namespace shaker::calibration {
namespace {

using test::TumbledSensor;

struct SensorFileTest : testing::Test {
    SensorFileTest() {
        written.fit =
            fit_tumble(sensor.attitudes(standard_attitudes), sensor.nominal(), {sensor.gravity, 3e-4});
    }
    [[nodiscard]] AccelerometerInfo device(double scale = 1) const {
        AccelerometerInfo info{.name = device_name, .range_mps2 = 78.5};
        for (double& x : info.mps2_per_count) x = scale * sensor.mps2_per_count;
        return info;
    }
    [[nodiscard]] std::string refusal(const std::string& text, double scale = 1) const {
        try {
            static_cast<void>(
                calibrated(device(scale), {"cal.toml", text, parse_calibration(text, "cal.toml")}));
        } catch (const InputError& e) {
            return e.what();
        }
        return "accepted";
    }
    TumbledSensor sensor{};
    std::string device_name = "ADXL \"355\"";
    SensorCalibration written{.date = "2026-11-26T20:00:00+00:00",
                              .sensor = "ADXL \"355\"",
                              .nominal_mps2_per_count = sensor.nominal()};
};

TEST_F(SensorFileTest, ReadsBackExactly) {
    const SensorCalibration read = parse_calibration(calibration_text(written), "cal.toml");
    EXPECT_EQ(read.date, written.date);
    EXPECT_EQ(read.sensor, "ADXL  355 ");
    EXPECT_EQ(read.nominal_mps2_per_count, written.nominal_mps2_per_count);
    EXPECT_EQ(read.fit.gain, written.fit.gain);
    EXPECT_EQ(read.fit.offset_counts, written.fit.offset_counts);
    EXPECT_EQ(read.fit.covariance, written.fit.covariance);
    EXPECT_EQ(read.fit.gravity.value, written.fit.gravity.value);
    EXPECT_EQ(read.fit.gravity.sigma, 3e-4);
    EXPECT_EQ(read.fit.chi2, written.fit.chi2);
    EXPECT_EQ(read.fit.attitudes, 18);
    EXPECT_EQ(calibration_text(read), calibration_text(parse_calibration(calibration_text(read), "x")));
}

TEST_F(SensorFileTest, RefusesAFileOfAnotherSensor) {
    device_name = "ADXL \"355\" at usb:1.7.5";
    EXPECT_EQ(refusal(calibration_text(written)), "accepted") << "another socket";
    device_name = "adxl357";
    EXPECT_EQ(refusal(calibration_text(written)),
              "cal.toml: was made of \"ADXL  355 \"; the rig's accelerometer is \"adxl357\": calibrate it");
}

TEST_F(SensorFileTest, RefusesAFileThatWasChanged) {
    std::string text = calibration_text(written);
    const std::size_t digit = text.find("attitudes = 18") + 13;
    text[digit] = '9';
    EXPECT_EQ(
        refusal(text),
        "cal.toml: was changed after it was written (its checksum does not match); restore it or calibrate "
        "again with \"shakerd calibrate accelerometer\"");
    EXPECT_EQ(refusal("gain = 1\n"), "cal.toml: is not a calibration file: its last line is not a sha256");
    EXPECT_TRUE(refusal(calibration_text(written) + "x = 1\n").starts_with("cal.toml: was changed"));
}

TEST_F(SensorFileTest, RefusesASensorWithAnotherRange) {
    EXPECT_EQ(refusal(calibration_text(written)), "accepted");
    const std::string why = refusal(calibration_text(written), 2);
    EXPECT_TRUE(why.starts_with("cal.toml: was made when the x axis of ADXL  355  reported")) << why;
    written.nominal_mps2_per_count = {};
    EXPECT_EQ(refusal(calibration_text(written), 2), "accepted");
}

TEST_F(SensorFileTest, IsNotForASensorReadWithFewerAxes) {
    const std::string text = calibration_text(written);
    for (const auto& [axes, gravity] : {std::pair{1, true}, {3, false}}) {
        AccelerometerInfo info = device();
        info.axes = axes;
        info.gravity = gravity;
        std::string words;
        try {
            static_cast<void>(calibrated(info, {"cal.toml", text, parse_calibration(text, "cal.toml")}));
        } catch (const InputError& e) {
            words = e.what();
        }
        EXPECT_NE(
            words.find(gravity ? "is read with 1 of them: remove" : "3 of them, without gravity: remove"),
            std::string::npos)
            << words;
    }
}

TEST_F(SensorFileTest, CalibratedReadingIsTheSpecificForce) {
    const std::string text = calibration_text(written);
    const AccelerometerInfo info =
        calibrated(device(), {"cal.toml", text, parse_calibration(text, "cal.toml")});
    EXPECT_EQ(info.calibration, text);
    sensor.noise = 0;
    for (const char* name : {"+x", "-y+z", "-x-y-z"}) {
        const Vector force = sensor.held(name), a = info.acceleration(sensor.counts(force));
        // The gains' own rotation is a choice: lengths and angles to one another hold.
        EXPECT_NEAR(std::hypot(a[0], a[1], a[2]), sensor.gravity, 1.5e-3) << name;
        for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(a[k], force[k], 0.07) << name;
    }
    // The range ends where the counts do, whatever the axis.
    EXPECT_GT(info.range_mps2, 0.96 * 78.5);
    EXPECT_LT(info.range_mps2, 0.99 * 78.5);
}

}  // namespace
}  // namespace shaker::calibration
