#include "drivers/mock/gvsp.hpp"

#include <algorithm>

namespace shaker::mock {
namespace {

constexpr std::size_t ip_udp_bytes = 28;
constexpr std::size_t header_bytes = 8;
constexpr unsigned format_leader = 1, format_trailer = 2, format_payload = 3;
constexpr std::uint64_t payload_image = 0x0001, payload_image_with_chunks = 0x4001;

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

}  // namespace shaker::mock
