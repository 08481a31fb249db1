#pragma once
// The GigE Vision stream protocol, version 1 (block ids of 16 bits), as sent by a camera: pixels and packets.
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "drivers/data.hpp"

namespace shaker::mock {

/// Content of the first packet of a picture.
struct GvspLeader {
    std::int64_t stamp = 0;          // ticks of the camera's clock
    std::uint32_t pixel_format = 0;  // PFNC code
    int x = 0;                       // region of the sensor, pixels
    int y = 0;
    int width = 0;
    int height = 0;
    bool chunks = false;  // the payload ends with chunks
};

/// One picture divided into packets: leader, payload, trailer.
class GvspBlock {
public:
    /// packet_bytes: packet size including IP and UDP headers, as in the packet size register. `payload` must
    /// stay valid while packets are read. id: 1 to 65535.
    GvspBlock(std::uint16_t id, const GvspLeader& leader, std::span<const std::byte> payload,
              std::size_t packet_bytes);
    [[nodiscard]] std::size_t packets() const noexcept;
    /// UDP content of packet `index`, valid until the next call.
    std::span<const std::byte> packet(std::size_t index);

private:
    void begin(unsigned format, std::size_t index);
    void put(std::uint64_t value, int bytes);

    std::uint16_t id_;
    GvspLeader leader_;
    std::span<const std::byte> payload_;
    std::size_t piece_;  // bytes of payload per packet
    std::vector<std::byte> out_;
};

/// Appends a region (x, y, width, height; inside the picture) in a grey PFNC format: Mono8, 10, 12 or 16,
/// plain (little-endian), GigE Vision's "Packed" or PFNC's "p". Throws InputError for other formats.
void append_pixels(const Frame& frame, const std::array<int, 4>& region, std::uint32_t format,
                   std::vector<std::byte>& out);

}  // namespace shaker::mock
