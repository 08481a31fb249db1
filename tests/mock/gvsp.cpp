#include "tests/mock/gvsp.hpp"

#include <algorithm>
#include <cstring>
#include <string>

#include "drivers/errors.hpp"

namespace shaker::mock {
namespace {

constexpr std::size_t ip_udp_bytes = 28;
constexpr std::size_t header_bytes = 8;
constexpr unsigned format_leader = 1, format_trailer = 2, format_payload = 3;
constexpr std::uint64_t payload_image = 0x0001, payload_image_with_chunks = 0x4001;

enum class Layout { bytes, words, gige_pairs, bit_stream };
struct Format {
    std::uint32_t code;
    unsigned bits;
    Layout layout;
};
constexpr Format formats[] = {
    {0x01080001, 8, Layout::bytes},       {0x01100003, 10, Layout::words},
    {0x010c0004, 10, Layout::gige_pairs}, {0x010a0046, 10, Layout::bit_stream},
    {0x01100005, 12, Layout::words},      {0x010c0006, 12, Layout::gige_pairs},
    {0x010c0047, 12, Layout::bit_stream}, {0x01100007, 16, Layout::words},
};

std::byte low_byte(unsigned value) { return static_cast<std::byte>(value & 0xff); }

std::vector<unsigned> codes(const Frame& frame, const std::array<int, 4>& region, unsigned bits) {
    const ImageView view = frame.view();
    const unsigned largest = (1u << bits) - 1;
    std::vector<unsigned> result;
    for (int y = region[1]; y < region[1] + region[3]; ++y) {
        const std::byte* row = view.row(y);
        for (int x = region[0]; x < region[0] + region[2]; ++x) {
            if (view.bytes_per_pixel == 1) {
                result.push_back(std::to_integer<unsigned>(row[x]) << (bits - 8));
            } else {
                std::uint16_t code = 0;
                std::memcpy(&code, row + std::ptrdiff_t{2} * x, sizeof code);
                result.push_back(std::min<unsigned>(code, largest));
            }
        }
    }
    return result;
}

/// Two pixels in three bytes: upper bits of one, lower bits of both, upper bits of the other.
void put_pairs(const std::vector<unsigned>& pixels, unsigned bits, std::vector<std::byte>& out) {
    const unsigned low = bits - 8, mask = (1u << low) - 1;
    for (std::size_t i = 0; i < pixels.size(); i += 2) {
        const bool pair = i + 1 < pixels.size();
        const unsigned second = pair ? pixels[i + 1] : 0;
        out.push_back(low_byte(pixels[i] >> low));
        out.push_back(low_byte((pixels[i] & mask) | (second & mask) << 4));
        if (pair) out.push_back(low_byte(second >> low));
    }
}

/// Pixels one after another without gaps, least significant bit first.
void put_stream(const std::vector<unsigned>& pixels, unsigned bits, std::vector<std::byte>& out) {
    unsigned held = 0, have = 0;
    for (const unsigned pixel : pixels) {
        held |= pixel << have;
        for (have += bits; have >= 8; have -= 8, held >>= 8) out.push_back(low_byte(held));
    }
    if (have > 0) out.push_back(low_byte(held));
}

}  // namespace

GvspBlock::GvspBlock(std::uint16_t id, const GvspLeader& leader, std::span<const std::byte> payload,
                     std::size_t packet_bytes)
    : id_{id},
      leader_{leader},
      payload_{payload},
      piece_{std::max<std::size_t>(packet_bytes, ip_udp_bytes + header_bytes + 1) - ip_udp_bytes -
             header_bytes} {
    out_.reserve(header_bytes + std::max<std::size_t>(piece_, 64));
}

std::size_t GvspBlock::packets() const noexcept { return 2 + (payload_.size() + piece_ - 1) / piece_; }

void GvspBlock::put(std::uint64_t value, int bytes) {
    for (int shift = 8 * (bytes - 1); shift >= 0; shift -= 8)
        out_.push_back(static_cast<std::byte>(value >> shift));
}

void GvspBlock::begin(unsigned format, std::size_t index) {
    out_.clear();
    put(0, 2);  // status: success
    put(id_, 2);
    put(format, 1);
    put(index, 3);
}

std::span<const std::byte> GvspBlock::packet(std::size_t index) {
    const std::uint64_t payload_type = leader_.chunks ? payload_image_with_chunks : payload_image;
    if (index == 0) {
        begin(format_leader, index);
        put(0, 2);
        put(payload_type, 2);
        put(static_cast<std::uint64_t>(leader_.stamp), 8);
        put(leader_.pixel_format, 4);
        for (const int value : {leader_.width, leader_.height, leader_.x, leader_.y})
            put(static_cast<std::uint64_t>(value), 4);
        put(0, 4);  // no padding of rows or of the picture
    } else if (index + 1 == packets()) {
        begin(format_trailer, index);
        put(payload_type, 4);
        put(static_cast<std::uint64_t>(leader_.height), 4);
    } else {
        begin(format_payload, index);
        const std::size_t from = (index - 1) * piece_;
        const auto piece = payload_.subspan(from, std::min(piece_, payload_.size() - from));
        out_.insert(out_.end(), piece.begin(), piece.end());
    }
    return out_;
}

void append_pixels(const Frame& frame, const std::array<int, 4>& region, std::uint32_t format,
                   std::vector<std::byte>& out) {
    const auto* const found = std::ranges::find(formats, format, &Format::code);
    if (found == std::end(formats))
        throw InputError{"mock camera: pixel format " + std::to_string(format) + " is not supported"};
    if (found->layout == Layout::bytes && frame.bytes_per_pixel == 1) {  // unchanged
        for (int y = region[1]; y < region[1] + region[3]; ++y) {
            const std::byte* row = frame.view().row(y) + region[0];
            out.insert(out.end(), row, row + region[2]);
        }
        return;
    }
    const std::vector<unsigned> pixels = codes(frame, region, found->bits);
    switch (found->layout) {
        case Layout::bytes:
            for (const unsigned pixel : pixels) out.push_back(low_byte(pixel));
            break;
        case Layout::words:
            for (const unsigned pixel : pixels) {
                out.push_back(low_byte(pixel));
                out.push_back(low_byte(pixel >> 8));
            }
            break;
        case Layout::gige_pairs:
            put_pairs(pixels, found->bits, out);
            break;
        case Layout::bit_stream:
            put_stream(pixels, found->bits, out);
            break;
    }
}

}  // namespace shaker::mock
