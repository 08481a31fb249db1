#pragma once
// AlsaDac: a DAC behind ALSA. Order and timing of the libasound calls; pcm.hpp has the calls themselves.
#include <memory>

#include "drivers/devices.hpp"
#include "drivers/hardware/alsa/pcm.hpp"
#include "drivers/hardware/alsa/settings.hpp"

namespace shaker::alsa {

/// Plays the drive, the trigger pulses and the enable tone on the channels of the settings.
///
/// **Ends with a ramp.** If the device can take frames back, a ramp from the drive's last value to zero is
/// always queued behind it, and each write replaces it. Whenever the process ends or hangs, the output
/// reaches zero within the length of the buffer, without a step. On other devices silence follows the last
/// sample.
///
/// **Takes back.** Such a device also takes back queued samples of the drive, all but two periods. The ramp
/// is written behind the last sample that stays in the same step, so that it is always there. When the device
/// then refuses to take back the silence behind that ramp, this silence counts as lost: the next write()
/// reports it.
///
/// Temporary errors (underrun, suspend, a device that does not advance for two buffer lengths) are counted
/// and reported by PlayTime::lost; the stream restarts with silence. After three restarts without a block
/// played, the device is closed and opened again; after three more, or on a permanent error, write() throws
/// DeviceError.
class AlsaDac final : public Dac {
public:
    /// Opens the device. Throws DeviceError if it cannot be opened or does not grant the requested settings.
    explicit AlsaDac(const AlsaSettings& settings);
    AlsaDac(const AlsaDac&) = delete;
    AlsaDac& operator=(const AlsaDac&) = delete;
    /// Plays the ramp (at most one buffer length), then closes.
    ~AlsaDac() override;

    [[nodiscard]] DacInfo info() const override;
    [[nodiscard]] DeviceCounts counts() const noexcept override;
    /// Real-time as far as libasound is, unless the device is opened again. Waits at most two buffer lengths.
    PlayTime write(std::span<const double> volts, std::span<const double> trigger) override;
    /// Real-time as far as libasound is.
    [[nodiscard]] std::int64_t take_back(std::int64_t most) noexcept override;
    /// Real-time.
    void enable(bool on) noexcept override;
    /// Plays the queued samples, then the ramp. From now on write() returns at once.
    void stop() noexcept override;

    [[nodiscard]] const AlsaGranted& granted() const noexcept;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace shaker::alsa
