#pragma once
// A simulated DAC that accepts samples only at their real rate, so that virtual time keeps to real time.
#include <algorithm>
#include <memory>
#include <utility>

#include "daemon/acquisition/executors.hpp"
#include "drivers/devices.hpp"
#include "drivers/time.hpp"

namespace shaker::acquisition {

class PacedDac final : public Dac {
public:
    explicit PacedDac(std::unique_ptr<Dac> inner)
        : inner_{std::move(inner)}, rate_hz_{inner_->info().rate_hz} {}
    [[nodiscard]] DacInfo info() const override { return inner_->info(); }
    [[nodiscard]] DeviceCounts counts() const noexcept override { return inner_->counts(); }
    PlayTime write(std::span<const double> volts, std::span<const double> trigger) override {
        pacer_.wait_until(duration_s(written_, rate_hz_));
        const std::int64_t again = std::min(owed_, std::ssize(volts));
        owed_ -= again;
        written_ += std::ssize(volts) - again;
        return inner_->write(volts, trigger);
    }
    std::int64_t take_back(std::int64_t most) noexcept override {
        const std::int64_t taken = inner_->take_back(most);
        owed_ += taken;
        return taken;
    }
    void enable(bool on) noexcept override { inner_->enable(on); }
    void stop() noexcept override { inner_->stop(); }

private:
    std::unique_ptr<Dac> inner_;
    double rate_hz_;
    std::int64_t written_ = 0;  // samples
    std::int64_t owed_ = 0;     // samples that were taken back and not written again yet
    Pacer pacer_;
};

}  // namespace shaker::acquisition
