#pragma once
// IioStream: one connection to an accelerometer behind libiio, from its settings to the bytes of its buffer.
// A broken connection is destroyed and replaced.
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "drivers/hardware/iio/sample.hpp"
#include "drivers/hardware/iio/settings.hpp"

namespace shaker::iio {

/// Properties reported by the device.
struct IioFacts {
    std::string name;  // of the device, and its address
    double rate_hz = 0;
    std::array<double, 3> mps2_per_count{};  // 0 for an axis that is not read
    std::array<double, 3> offset_counts{};
    IioScan scan;
    IioStamps stamps = IioStamps::none;  // as requested, or a lower level that was available
    int buffer_samples = 0;
    std::vector<std::string> notes{};  // unavailable settings, for the operator
    /// True if samples have the same meaning.
    [[nodiscard]] bool same_scale(const IioFacts& other) const noexcept {
        return rate_hz == other.rate_hz && mps2_per_count == other.mps2_per_count &&
               offset_counts == other.offset_counts && scan == other.scan;
    }
};

class IioStream {
public:
    /// Connects, finds the device, sets its rate, trigger and clock, and enables its channels. Throws
    /// DeviceError that names the device, the request and libiio's text.
    explicit IioStream(const IioSettings& settings);
    ~IioStream();
    IioStream(const IioStream&) = delete;
    IioStream& operator=(const IioStream&) = delete;

    [[nodiscard]] const IioFacts& facts() const noexcept;

    /// Starts or restarts the buffer. Throws DeviceError, also if another device answers now. Reader's
    /// thread.
    void start();
    /// Waits for a full buffer, at most for the time-out. Returns 0 and the samples, valid until the next
    /// call; or -errno, after which the object must be destroyed: -EBADF after cancel(), -EPIPE when the
    /// connection is closed or silent, -ETIMEDOUT when the sensor delivers nothing. Reader's thread. libiio
    /// allocates and frees 9 bytes for each buffer from a network or USB, none for a local one.
    int refill(std::span<const std::byte>& samples) noexcept;
    /// Ends refill() and makes all later calls fail. Any thread.
    void cancel() noexcept;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace shaker::iio
