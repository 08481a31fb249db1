#pragma once
// One sample of an IIO buffer: offsets and formats of its channels. Real-time.
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace shaker::iio {

/// Format of a channel in the kernel's notation: "be:s20/32>>12" is 20 bits, signed, big endian, 12 bits
/// above the lower end of 32.
struct IioFormat {
    unsigned bits = 16;
    unsigned storage_bits = 16;  // 8, 16, 32 or 64
    unsigned shift = 0;
    bool is_signed = true;
    bool big_endian = false;
    bool operator==(const IioFormat&) const = default;
};

/// A channel of the scan: format and index.
struct IioChannel {
    IioFormat format;
    long index = 0;
};

struct IioField {
    IioFormat format;
    std::size_t offset = 0;  // bytes from the start of the sample
    bool operator==(const IioField&) const = default;
};

struct IioScan {
    std::array<IioField, 3> axes;  // those in use first
    std::size_t used = 3;
    std::optional<IioField> stamp;
    std::size_t size = 0;  // bytes of a sample, padding included
    bool operator==(const IioScan&) const = default;
};

/// The kernel's layout: channels in order of index, each aligned to its own size; the sample is padded to a
/// multiple of the largest. Channels with the same index share their place. One to three axes.
IioScan lay_out_scan(std::span<const IioChannel> axes, const std::optional<IioChannel>& stamp) noexcept;

/// True if the format is valid and every value fits a signed 32-bit integer.
bool fits_counts(const IioFormat& format) noexcept;
/// Smallest and largest value of the format.
std::array<std::int64_t, 2> limits_of(const IioFormat& format) noexcept;

/// The value of `field` in a sample, as from iio_channel_convert().
std::int64_t unpack(std::span<const std::byte> sample, const IioField& field) noexcept;

}  // namespace shaker::iio
