#include "drivers/replay/frame_record.hpp"

#include <bit>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <limits>

#include "drivers/replay/crc32c.hpp"
#include "drivers/replay/session_file.hpp"

namespace shaker {

static_assert(std::endian::native == std::endian::little, "records go to the disk as they are in memory");

namespace {

std::uint32_t seal_of(const FrameRecord& record) noexcept {
    return crc32c(std::as_bytes(std::span{&record, 1}).first(offsetof(FrameRecord, record_crc32c)));
}

bool is_empty(const FrameRecord& record) noexcept {
    for (const std::byte b : std::as_bytes(std::span{&record, 1}))
        if (b != std::byte{}) return false;
    return true;
}

}  // namespace

FrameRecord record_of(const Frame& frame, std::uint64_t number) noexcept {
    FrameRecord r{.number = number,
                  .tick = frame.tick.n,
                  .arrived = frame.arrived.time_since_epoch().count(),
                  .stamp = frame.stamp ? frame.stamp->n : no_stamp,
                  .mid_exposure = frame.mid_exposure ? seconds(*frame.mid_exposure)
                                                     : std::numeric_limits<double>::quiet_NaN(),
                  .quality = static_cast<std::uint8_t>(frame.quality),
                  .pixels_crc32c = crc32c(frame.pixels)};
    r.record_crc32c = seal_of(r);
    return r;
}

const char* words_for(FrameFault fault) noexcept {
    switch (fault) {
        case FrameFault::none:
            return "is whole";
        case FrameFault::no_record:
            return "has no record";
        case FrameFault::bad_record:
            return "has a record that is not as it was written";
        case FrameFault::bad_pixels:
            return "has pixels that are not as they were written";
    }
    return "";
}

FrameFault fault_of(const FrameRecord& record, std::uint64_t number) noexcept {
    if (is_empty(record)) return FrameFault::no_record;
    return record.number == number && record.record_crc32c == seal_of(record) ? FrameFault::none
                                                                              : FrameFault::bad_record;
}

FrameFault fault_of(const FrameRecord& record, std::uint64_t number,
                    std::span<const std::byte> pixels) noexcept {
    const FrameFault fault = fault_of(record, number);
    if (fault != FrameFault::none) return fault;
    return record.pixels_crc32c == crc32c(pixels) ? FrameFault::none : FrameFault::bad_pixels;
}

Frame frame_of(const FrameRecord& record, const FrameShape& shape) {
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

}  // namespace shaker
