#include "calibration/accelerometer/read_as.hpp"

#include <spdlog/fmt/fmt.h>

#include <utility>

#include "calibration/sealed_file.hpp"
#include "drivers/errors.hpp"

namespace shaker::calibration {

namespace {

class OtherwiseRead final : public Accelerometer {
public:
    OtherwiseRead(std::unique_ptr<Accelerometer> device, AccelerometerInfo info)
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

// Without the address, which changes with the socket.
std::string device_of(const std::string& name) { return toml_string(name.substr(0, name.rfind(" at "))); }

}  // namespace

std::unique_ptr<Accelerometer> read_as(std::unique_ptr<Accelerometer> device, AccelerometerInfo info) {
    return std::make_unique<OtherwiseRead>(std::move(device), std::move(info));
}

void require_sensor(const std::string& file, const std::string& made_of, const AccelerometerInfo& info) {
    if (device_of(made_of) == device_of(info.name)) return;
    throw InputError{fmt::format("{}: was made of \"{}\"; the rig's accelerometer is \"{}\": calibrate it",
                                 file, made_of, info.name)};
}

}  // namespace shaker::calibration
