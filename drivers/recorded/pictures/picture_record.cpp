#include "drivers/recorded/pictures/picture_record.hpp"

#include <bit>
#include <chrono>
#include <cmath>
#include <cstddef>

#include "drivers/recorded/h5/crc32c.hpp"

namespace shaker::pictures {

static_assert(std::endian::native == std::endian::little, "records are written without conversion");

namespace {

std::uint32_t seal_of(const PictureRecord& record) noexcept {
    return h5::crc32c(std::as_bytes(std::span{&record, 1}).first(offsetof(PictureRecord, record_crc32c)));
}

bool is_empty(const PictureRecord& record) noexcept {
    for (const std::byte b : std::as_bytes(std::span{&record, 1}))
        if (b != std::byte{}) return false;
    return true;
}

}  // namespace

PictureRecord record_of(const Frame& frame, std::uint64_t number) noexcept {
    PictureRecord r{.number = number,
                    .tick = frame.tick.n,
                    .arrived = frame.arrived.time_since_epoch().count(),
                    .stamp = frame.stamp ? frame.stamp->n : no_stamp,
                    .mid_exposure = frame.mid_exposure ? seconds(*frame.mid_exposure)
                                                       : std::numeric_limits<double>::quiet_NaN(),
                    .quality = static_cast<std::uint8_t>(frame.quality),
                    .pixels_crc32c = h5::crc32c(frame.pixels)};
    r.record_crc32c = seal_of(r);
    return r;
}

const char* words_for(PictureFault fault) noexcept {
    constexpr std::array words{"is intact", "has no record", "has a damaged record", "has damaged pixels"};
    return words.at(static_cast<std::size_t>(fault));
}

PictureFault fault_of(const PictureRecord& record, std::uint64_t number) noexcept {
    if (is_empty(record)) return PictureFault::no_record;
    return record.number == number && record.record_crc32c == seal_of(record) ? PictureFault::none
                                                                              : PictureFault::bad_record;
}

PictureFault fault_of(const PictureRecord& record, std::uint64_t number,
                      std::span<const std::byte> pixels) noexcept {
    const PictureFault fault = fault_of(record, number);
    if (fault != PictureFault::none) return fault;
    return record.pixels_crc32c == h5::crc32c(pixels) ? PictureFault::none : PictureFault::bad_pixels;
}

Frame frame_of(const PictureRecord& record, const PictureShape& shape) {
    Frame frame;
    frame.tick = {record.tick};
    frame.arrived = HostTime{std::chrono::nanoseconds{record.arrived}};
    frame.quality = static_cast<Quality>(record.quality);
    frame.width = shape.width;
    frame.height = shape.height;
    frame.bytes_per_pixel = shape.bytes_per_pixel;
    if (record.stamp != no_stamp) frame.stamp = CameraStamp{record.stamp};
    if (!std::isnan(record.mid_exposure)) frame.mid_exposure = master_time(record.mid_exposure);
    return frame;
}

}  // namespace shaker::pictures
