#include "tests/orders/watched_devices.hpp"

#include <cmath>
#include <utility>

#include "tests/orders/plan.hpp"

namespace shaker::orders {

namespace {

class WatchedDac final : public Dac {
public:
    WatchedDac(std::unique_ptr<Dac> dac, Watch& watch) : dac_{std::move(dac)}, watch_{watch} {}
    [[nodiscard]] DacInfo info() const override { return dac_->info(); }
    [[nodiscard]] DeviceCounts counts() const noexcept override { return dac_->counts(); }
    PlayTime write(std::span<const double> volts, std::span<const double> trigger) override {
        watch_.heap.end(watch_.laws);
        const PlayTime played = dac_->write(volts, trigger);
        watch_.laws.played(volts, played.lost);
        if (watch_.troubled(static_cast<std::size_t>(Trouble::slow_output))) watch_.meanwhile();
        watch_.heap.begin("output");
        return played;
    }
    std::int64_t take_back(std::int64_t most) noexcept override {
        watch_.heap.end(watch_.laws);
        const std::int64_t taken = dac_->take_back(most);
        watch_.laws.took_back(taken);
        watch_.heap.begin("output");
        return taken;
    }
    void enable(bool on) noexcept override {
        watch_.laws.enabled(on);
        dac_->enable(on);
    }
    void stop() noexcept override { dac_->stop(); }

private:
    std::unique_ptr<Dac> dac_;
    Watch& watch_;
};

class WatchedAccelerometer final : public Accelerometer {
public:
    WatchedAccelerometer(std::unique_ptr<Accelerometer> sensor, Watch& watch)
        : sensor_{std::move(sensor)}, watch_{watch}, info_{sensor_->info()} {}
    [[nodiscard]] AccelerometerInfo info() const override { return info_; }
    [[nodiscard]] DeviceCounts counts() const noexcept override { return sensor_->counts(); }
    bool read(AccelBlock& block, std::chrono::milliseconds wait) override {
        watch_.heap.end(watch_.laws);
        if (watch_.troubled(static_cast<std::size_t>(Trouble::slow_sensor))) return false;
        const bool came = sensor_->read(block, wait);
        if (!came) return false;
        watch_.laws.sampled(std::span{block.counts}.first(static_cast<std::size_t>(block.size)));
        watch_.heap.begin("accelerometer");
        return true;
    }
    std::size_t read_early(std::span<std::array<std::int32_t, 3>> counts) noexcept override {
        watch_.heap.end(watch_.laws);
        const std::size_t n = sensor_->read_early(counts);
        watch_.laws.sampled(counts.first(n));
        watch_.heap.begin("accelerometer");
        return n;
    }
    [[nodiscard]] bool ended() const noexcept override { return sensor_->ended(); }
    void stop() noexcept override { sensor_->stop(); }

private:
    std::unique_ptr<Accelerometer> sensor_;
    Watch& watch_;
    AccelerometerInfo info_;
};

class WatchedCamera final : public Camera {
public:
    WatchedCamera(std::unique_ptr<Camera> camera, Watch& watch) : camera_{std::move(camera)}, watch_{watch} {}
    [[nodiscard]] const View& view() const override { return camera_->view(); }
    [[nodiscard]] DeviceCounts counts() const noexcept override { return camera_->counts(); }
    FramePtr read(std::chrono::milliseconds wait) override {
        watch_.heap.forget();
        if (watch_.troubled(static_cast<std::size_t>(Trouble::slow_cameras))) return nullptr;
        FramePtr frame = camera_->read(wait);
        if (frame != nullptr) watch_.laws.pictured();
        return frame;
    }
    [[nodiscard]] bool ended() const noexcept override { return camera_->ended(); }
    void stop() noexcept override { camera_->stop(); }

private:
    std::unique_ptr<Camera> camera_;
    Watch& watch_;
};

}  // namespace

void watch_devices(Rig& rig, Watch& watch) {
    rig.dac = std::make_unique<WatchedDac>(std::move(rig.dac), watch);
    rig.accelerometer = std::make_unique<WatchedAccelerometer>(std::move(rig.accelerometer), watch);
    for (std::unique_ptr<Camera>& camera : rig.cameras)
        camera = std::make_unique<WatchedCamera>(std::move(camera), watch);
}

}  // namespace shaker::orders
