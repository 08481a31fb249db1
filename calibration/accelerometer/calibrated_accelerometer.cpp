#include "calibration/accelerometer/calibrated_accelerometer.hpp"

#include <spdlog/fmt/fmt.h>

#include <utility>

namespace shaker::calibration {

namespace {

class CalibratedAccelerometer final : public Accelerometer {
public:
    CalibratedAccelerometer(std::unique_ptr<Accelerometer> device, AccelerometerInfo info)
        : device_{std::move(device)}, info_{std::move(info)} {}
    [[nodiscard]] AccelerometerInfo info() const override { return info_; }
    [[nodiscard]] DeviceCounts counts() const noexcept override { return device_->counts(); }
    bool read(AccelBlock& block, std::chrono::milliseconds wait) override {
        return device_->read(block, wait);
    }
    std::size_t read_early(std::span<std::array<std::int32_t, 3>> counts) noexcept override {
        return device_->read_early(counts);
    }
    [[nodiscard]] bool ended() const noexcept override { return device_->ended(); }
    void stop() noexcept override { device_->stop(); }

private:
    std::unique_ptr<Accelerometer> device_;
    AccelerometerInfo info_;
};

}  // namespace

std::unique_ptr<Accelerometer> with_calibration(std::unique_ptr<Accelerometer> device,
                                                const CalibrationFile& by, std::vector<std::string>& notes) {
    AccelerometerInfo info = calibrated(device->info(), by);
    const SensorCalibration& c = by.content;
    notes.push_back(
        fmt::format("{}: calibration of {} ({}), errors of the gain along x, y, z {:.2g}, {:.2g}, {:.2g} %",
                    info.name, c.date, by.file.string(), 100 * c.fit.gain_error({1, 0, 0}),
                    100 * c.fit.gain_error({0, 1, 0}), 100 * c.fit.gain_error({0, 0, 1})));
    if (c.sensor != info.name) notes.back() += fmt::format("; it was made of \"{}\"", c.sensor);
    return std::make_unique<CalibratedAccelerometer>(std::move(device), std::move(info));
}

}  // namespace shaker::calibration
