#pragma once
// One sample of an IIO buffer: where its channels lie and what their bits mean. Real-time.
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace shaker {

/// A channel's format as the kernel tells it: "be:s20/32>>12" is 20 bits, signed, big endian, 12 bits from
/// the lower end of 32.
struct IioFormat {
    unsigned bits = 16;
    unsigned storage_bits = 16;  // 8, 16, 32 or 64
    unsigned shift = 0;
    bool is_signed = true;
    bool big_endian = false;
    bool operator==(const IioFormat&) const = default;
};

/// A channel of the scan: its format and its place in the order.
struct IioChannel {
    IioFormat format;
    long index = 0;
};

struct IioField {
    IioFormat format;
    std::size_t offset = 0;  // bytes from the sample's begin
    bool operator==(const IioField&) const = default;
};

struct IioScan {
    std::array<IioField, 3> axes;
    std::optional<IioField> stamp;
    std::size_t size = 0;  // bytes of a sample, padding included
    bool operator==(const IioScan&) const = default;
};

/// The kernel's layout: channels in order of index, each at a multiple of its own size, the sample padded to
/// a multiple of the largest. Channels of one index share their place.
IioScan lay_out_scan(const std::array<IioChannel, 3>& axes, const std::optional<IioChannel>& stamp) noexcept;

/// Whether the format makes sense and every value of it fits 32 bits with a sign.
bool fits_counts(const IioFormat& format) noexcept;
/// Least and greatest value of the format.
std::array<std::int64_t, 2> limits_of(const IioFormat& format) noexcept;

/// The value at `field` of the sample that begins at `sample`, as iio_channel_convert() gives it.
std::int64_t unpack(std::span<const std::byte> sample, const IioField& field) noexcept;

}  // namespace shaker
