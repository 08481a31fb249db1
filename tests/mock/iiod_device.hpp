#pragma once
// IiodDevice: the mock accelerometer as seen by a client. Context as XML, attributes, bytes of a sample.
#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "tests/mock/iiod_protocol.hpp"

namespace shaker::mock {

/// A three-axis accelerometer with a buffer and a trigger.
struct IiodDescription {
    std::string name = "adxl355";
    std::string label{};   // empty: none
    std::string serial{};  // attribute serial_number; empty: none
    double rate_hz = 4000;
    std::vector<double> rates_hz{4000, 2000, 1000, 500, 250, 125};          // rates that a client may set
    std::array<double, 3> mps2_per_count{3.8245e-5, 3.8245e-5, 3.8245e-5};  // attribute scale
    std::array<double, 3> offset_counts{};                                  // attribute offset
    int bits = 20;          // 1 to 32, in the upper bits of 16 (up to 16) or 32, big endian
    bool monotonic = true;  // the clock of the stamps can be set to monotonic
    std::size_t fifo = 0;   // samples in the kernel's FIFO per buffer; 0: samples times buffers, as requested
};

/// One conversion.
struct IiodSample {
    std::array<std::int32_t, 3> counts{};
    std::int64_t stamp_ns = 0;
};

class IiodDevice {
public:
    static constexpr std::string_view id = "iio:device0";
    static constexpr std::string_view trigger_id = "trigger0";
    static constexpr std::uint32_t all_channels = 0xf;  // x, y, z, timestamp

    /// Throws InputError if `bits` is not 1 to 32.
    explicit IiodDevice(IiodDescription description);

    [[nodiscard]] std::string xml() const;
    /// 0, or -errno as the daemon answers: -19 no such device, -6 no such channel, -2 no such attribute.
    int read(const IiodCommand& command, std::string& value) const;
    /// As read(); also -22 value not allowed, -13 attribute is read-only.
    int write(const IiodCommand& command, std::string_view value);
    /// True if `who` is the id, name or label.
    [[nodiscard]] bool is_device(std::string_view who) const noexcept;
    [[nodiscard]] bool is_trigger(std::string_view who) const noexcept;
    [[nodiscard]] std::string trigger_name() const { return d_.name + "-dev0"; }

    [[nodiscard]] double rate_hz() const noexcept { return d_.rate_hz; }
    [[nodiscard]] std::size_t fifo() const noexcept { return d_.fifo; }
    /// Bytes of one sample with these channels.
    [[nodiscard]] std::size_t sample_size(std::uint32_t mask) const noexcept;
    /// Appends the sample in the kernel's layout. Unused bits of the storage are ones.
    void encode(const IiodSample& sample, std::uint32_t mask, std::vector<char>& out) const;

private:
    [[nodiscard]] int axis(const IiodCommand& command) const noexcept;
    [[nodiscard]] std::size_t storage_bytes() const noexcept { return d_.bits <= 16 ? 2 : 4; }

    IiodDescription d_;
    std::string clock_ = "realtime";
};

}  // namespace shaker::mock
