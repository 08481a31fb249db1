#pragma once
// One connection to an accelerometer behind libiio, from its settings to the bytes of its buffer. When it
// breaks it is thrown away and another is made.
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "drivers/hardware/iio_sample.hpp"
#include "drivers/hardware/iio_settings.hpp"

namespace shaker {

/// What the device said of itself.
struct IioFacts {
    std::string name;  // of the device, and where it is
    double rate_hz = 0;
    std::array<double, 3> mps2_per_count{};
    std::array<double, 3> offset_counts{};
    IioScan scan;
    IioStamps stamps = IioStamps::none;  // what was asked, or the less that could be had
    int buffer_samples = 0;
    std::vector<std::string> notes{};  // what could not be had, for the operator
    /// Samples mean the same.
    [[nodiscard]] bool same_scale(const IioFacts& other) const noexcept {
        return rate_hz == other.rate_hz && mps2_per_count == other.mps2_per_count &&
               offset_counts == other.offset_counts && scan == other.scan;
    }
};

class IioStream {
public:
    /// Connects, finds the device, sets its rate, trigger and clock, and enables its channels. Throws
    /// DeviceError naming the device, what was asked and libiio's words.
    explicit IioStream(const IioSettings& settings);
    ~IioStream();
    IioStream(const IioStream&) = delete;
    IioStream& operator=(const IioStream&) = delete;

    [[nodiscard]] const IioFacts& facts() const noexcept;

    /// Starts the buffer, or starts it anew. Throws DeviceError. The reader's thread.
    void start();
    /// Waits for a whole buffer, at most for the timeout. 0 and the samples, valid until the next call; or
    /// -errno, after which only destruction makes sense: -EBADF after cancel(), -EPIPE when the other side is
    /// gone or silent, -ETIMEDOUT when the sensor gives nothing. The reader's thread. libiio itself takes and
    /// returns 9 bytes of heap for each buffer that comes over a network or USB, none for a local one.
    int refill(std::span<const std::byte>& samples) noexcept;
    /// Ends refill() and makes all later ones fail. Any thread.
    void cancel() noexcept;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace shaker
