#pragma once
// A DAC behind ALSA. What libasound is asked for and in which order; alsa_pcm.hpp has the calls themselves.
#include <memory>

#include "drivers/devices.hpp"
#include "drivers/hardware/alsa_pcm.hpp"
#include "drivers/hardware/alsa_settings.hpp"

namespace shaker {

/// Plays the drive on the first channel and what the settings say on the second.
///
/// **The end is a ramp.** Where the device can take frames back, a ramp from the drive's last value to zero
/// always lies behind it, and each write replaces it. However the process ends or hangs, the output is at
/// zero within the buffer's length, without a step. On other devices silence follows the last sample.
///
/// Trouble that passes (underrun, suspend, a device that stands still for two buffer lengths) is counted and
/// told by PlayTime::lost: the stream begins again with silence. After three beginnings without a block
/// played in between the device is closed and opened again; three more, or any error that does not pass, are
/// a DeviceError.
class AlsaDac final : public Dac {
public:
    /// Opens the device; throws DeviceError when it cannot be opened or does not grant what was asked.
    explicit AlsaDac(const AlsaSettings& settings);
    AlsaDac(const AlsaDac&) = delete;
    AlsaDac& operator=(const AlsaDac&) = delete;
    /// Lets the ramp play (at most a buffer's length), then closes.
    ~AlsaDac() override;

    [[nodiscard]] DacInfo info() const override;
    [[nodiscard]] DeviceCounts counts() const noexcept override;
    /// Real-time, as far as libasound is, unless the device is opened again. Waits at most two buffer
    /// lengths.
    PlayTime write(std::span<const double> volts, std::span<const double> trigger) override;
    /// What was written is still played, then the ramp; write() returns at once from now on.
    void stop() noexcept override;

    [[nodiscard]] const AlsaGranted& granted() const noexcept;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace shaker
