#include "calibration/camera/camera_file.hpp"

#include <gtest/gtest.h>

#include "drivers/errors.hpp"

namespace shaker::calibration {
namespace {

CameraCalibration made() {
    CameraCalibration c{
        .date = "2026-11-26T20:00:00+00:00", .camera = "top", .size_px{1280, 512}, .how = "board"};
    c.mm_per_px = 0.2013;
    c.scale_error = 1.25e-4;
    c.distance_mm = 601.5;
    c.along = {0.8, -0.6};
    c.tilt_deg = {1.5, -0.25};
    c.lens = {{640.5, 255.25}, 2988, -0.12, 0.03, 1e-4, -2e-4};
    c.rms_px = 0.04;
    c.pictures = 12;
    c.corners = 800;
    c.findings = {"the tilt about y is large"};
    return c;
}

View told() {
    View view;
    view.camera = "top";
    view.mm_per_px = 0.2;
    view.distance_mm = 600;
    return view;
}

std::string refusal(const std::string& text, const View& view) {
    try {
        static_cast<void>(calibrated(view, parse_camera_calibration(text, "cal.toml"), text, "cal.toml"));
    } catch (const InputError& e) {
        return e.what();
    }
    return "accepted";
}

TEST(CameraFileTest, ReadsBackExactlyIntoTheView) {
    const CameraCalibration c = made();
    const std::string text = calibration_text(c);
    EXPECT_NE(text.find("# the tilt about y is large\n"), std::string::npos);
    const View view = calibrated(told(), parse_camera_calibration(text, "cal.toml"), text, "cal.toml");
    EXPECT_EQ(view.mm_per_px, c.mm_per_px);
    EXPECT_EQ(view.scale_error, c.scale_error);
    EXPECT_EQ(view.distance_mm, c.distance_mm);
    EXPECT_EQ(view.along, c.along);
    EXPECT_EQ(view.tilt_deg, c.tilt_deg);
    EXPECT_EQ(view.lens, c.lens);
    EXPECT_EQ(view.calibration, text);
}

TEST(CameraFileTest, KeepsTheToldDistanceWhereNoneWasDetermined) {
    CameraCalibration c = made();
    c.distance_mm = 0;
    const std::string text = calibration_text(c);
    EXPECT_EQ(calibrated(told(), parse_camera_calibration(text, "f"), text, "f").distance_mm, 600);
}

TEST(CameraFileTest, RefusesAFileThatWasChanged) {
    std::string text = calibration_text(made());
    text.replace(text.find("0.2013"), 6, "0.2113");
    EXPECT_EQ(refusal(text, told()),
              "cal.toml: was changed after it was written (its checksum does not match); restore it or "
              "calibrate again with \"shakerd calibrate camera\"");
}

TEST(CameraFileTest, RefusesAnotherCameraAndAnotherScale) {
    const std::string text = calibration_text(made());
    View side = told();
    side.camera = "side";
    EXPECT_EQ(refusal(text, side), "cal.toml: was made of camera \"top\"; camera \"side\" names it");
    View binned = told();
    binned.mm_per_px = 0.4;
    EXPECT_NE(refusal(text, binned).find("mm_per_px is 0.2013, but 0.4 in the settings of camera \"top\""),
              std::string::npos);
}

}  // namespace
}  // namespace shaker::calibration
