#include "calibration/camera/camera_file.hpp"

#include <spdlog/fmt/fmt.h>

#include <cmath>
#include <utility>

#include "calibration/sealed_file.hpp"
#include "drivers/errors.hpp"
#include "drivers/settings_table.hpp"

namespace shaker::calibration {

namespace {

constexpr double same_camera = 0.1;  // relative difference of the scales

class CalibratedCamera final : public Camera {
public:
    CalibratedCamera(std::unique_ptr<Camera> device, View view)
        : device_{std::move(device)}, view_{std::move(view)} {}
    [[nodiscard]] const View& view() const override { return view_; }
    [[nodiscard]] DeviceCounts counts() const noexcept override { return device_->counts(); }
    FramePtr read(std::chrono::milliseconds wait) override { return device_->read(wait); }
    [[nodiscard]] bool ended() const noexcept override { return device_->ended(); }
    void stop() noexcept override { device_->stop(); }

private:
    std::unique_ptr<Camera> device_;
    View view_;
};

std::array<double, 2> pair(SettingsTable& table, std::string_view key) {
    const std::vector<double> x = table.numbers(key, 2);
    return {x[0], x[1]};
}

}  // namespace

std::string calibration_text(const CameraCalibration& c) {
    std::string text = "# Scale and lens of a camera in the reference plane. Written by shakerd.\n";
    for (const std::string& finding : c.findings) text += "# " + finding + "\n";
    text += fmt::format("date = {}\ncamera = {}\nhow = {}\n", toml_string(c.date), toml_string(c.camera),
                        toml_string(c.how));
    text += fmt::format("width_px = {}\nheight_px = {}\n", c.size_px[0], c.size_px[1]);
    const auto number = [&](const char* key, double x) {
        text += fmt::format("{} = {}\n", key, toml_number(x));
    };
    number("mm_per_px", c.mm_per_px);
    number("scale_error", c.scale_error);
    number("distance_mm", c.distance_mm);
    text += "along = " + toml_list(c.along, 2) + "tilt_deg = " + toml_list(c.tilt_deg, 2);
    text += "centre_px = " + toml_list(c.lens.centre_px, 2);
    number("focal_px", c.lens.focal_px);
    number("k1", c.lens.k1);
    number("k2", c.lens.k2);
    number("p1", c.lens.p1);
    number("p2", c.lens.p2);
    number("rms_px", c.rms_px);
    return sealed(text + fmt::format("pictures = {}\ncorners = {}\n", c.pictures, c.corners));
}

CameraCalibration parse_camera_calibration(const std::string& text, const std::string& file) {
    require_seal(text, file, "camera");
    constexpr int most = 1000000000;
    constexpr Range any{-1e9, 1e9}, positive{0, 1e9};
    SettingsTable table = SettingsTable::from_text(text, file);
    CameraCalibration c{
        .date = table.text("date"), .camera = table.text("camera"), .size_px{}, .how = table.text("how")};
    c.size_px = {table.integer("width_px", 1, most, 0), table.integer("height_px", 1, most, 0)};
    c.mm_per_px = table.number("mm_per_px", {1e-6, 1e4});
    c.scale_error = table.number("scale_error", {0, 1});
    c.distance_mm = table.number("distance_mm", positive);
    c.along = pair(table, "along");
    c.tilt_deg = pair(table, "tilt_deg");
    c.lens = {.centre_px = pair(table, "centre_px"),
              .focal_px = table.number("focal_px", positive),
              .k1 = table.number("k1", any),
              .k2 = table.number("k2", any),
              .p1 = table.number("p1", any),
              .p2 = table.number("p2", any)};
    c.rms_px = table.number("rms_px", positive);
    c.pictures = table.integer("pictures", 1, most, 0);
    c.corners = table.integer("corners", 1, most, 0);
    table.text("sha256");
    table.finish();
    return c;
}

View calibrated(View view, const CameraCalibration& by, const std::string& text, const std::string& file) {
    if (by.camera != view.camera)
        throw InputError{fmt::format("{}: was made of camera \"{}\"; camera \"{}\" names it", file, by.camera,
                                     view.camera)};
    if (!(std::abs(by.mm_per_px / view.mm_per_px - 1) <= same_camera))
        throw InputError{fmt::format(
            "{}: mm_per_px is {:.6g}, but {:.6g} in the settings of camera \"{}\"; they may differ by 10 %: "
            "correct the "
            "settings, or calibrate again if lens, distance or binning were changed",
            file, by.mm_per_px, view.mm_per_px, view.camera)};
    view.mm_per_px = by.mm_per_px;
    view.scale_error = by.scale_error;
    view.along = by.along;
    view.tilt_deg = by.tilt_deg;
    view.lens = by.lens;
    if (by.distance_mm > 0) view.distance_mm = by.distance_mm;
    view.calibration = text;
    return view;
}

std::unique_ptr<Camera> with_calibration(std::unique_ptr<Camera> device, const std::filesystem::path& file,
                                         std::vector<std::string>& notes) {
    const std::string text = sealed_text(file);
    const CameraCalibration by = parse_camera_calibration(text, file.string());
    View view = calibrated(device->view(), by, text, file.string());
    notes.push_back(fmt::format("camera \"{}\": calibration of {} ({}), error of the scale {:.2g} %",
                                view.camera, by.date, file.string(), 100 * by.scale_error));
    return std::make_unique<CalibratedCamera>(std::move(device), std::move(view));
}

}  // namespace shaker::calibration
