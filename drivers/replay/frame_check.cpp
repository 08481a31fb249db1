#include "drivers/replay/frame_check.hpp"

#include <algorithm>

#include "drivers/errors.hpp"
#include "drivers/replay/frame_segment.hpp"
#include "drivers/replay/picture_link.hpp"

namespace shaker {

namespace {

FrameFault fault_at(const OpenedSegment& segment, std::uint64_t place, std::span<std::byte> pixels) {
    const FrameRecord& record = segment.records()[place];
    const std::uint64_t number = segment.found().info.first + place;
    const FrameFault fault = fault_of(record, number);
    if (fault != FrameFault::none) return fault;
    try {
        segment.read(place, pixels);
    } catch (const DeviceError&) {
        return FrameFault::bad_pixels;  // a spot of the disk that fails; the pictures around it may be whole
    }
    return fault_of(record, number, pixels);
}

void check_segment(const FoundSegment& found, FrameCheck& check, std::vector<std::byte>& pixels) {
    const OpenedSegment segment{found};
    pixels.resize(found.info.shape.bytes());
    for (std::uint64_t place = 0; place < found.info.places; ++place) {
        const std::uint64_t number = found.info.first + place;
        const FrameFault fault = fault_at(segment, place, pixels);
        if (fault == FrameFault::none) {
            ++check.whole;
            check.last = number;
        } else {
            check.bad.push_back({number, found.file, fault});
        }
    }
    segment.forget();
}

/// A copy of the first `places`, to the byte, in place of a longer segment.
void cut(const FoundSegment& found, std::uint64_t places) {
    FrameSegmentInfo info = found.info;
    info.places = places;
    const std::filesystem::path name = unfinished(found.file);
    FrameSegment shorter{name, info};
    try {
        const OpenedSegment segment{found};
        std::vector<std::byte> pixels(info.shape.bytes());
        for (std::uint64_t place = 0; place < places; ++place) {
            segment.read(place, pixels);
            shorter.add(segment.records()[place], pixels);
        }
        shorter.sync();
        shorter.rename(found.file);
    } catch (...) {
        std::error_code ignored;
        std::filesystem::remove(name, ignored);
        throw;
    }
}

void remove_file(const std::filesystem::path& file) {
    std::error_code error;
    std::filesystem::remove(file, error);
    if (error) throw DeviceError{file.string() + ": cannot be removed: " + error.message()};
}

}  // namespace

FrameCheck verify_frames(const std::filesystem::path& folder, const std::string& camera) {
    FoundSegments found = find_segments(folder, camera);
    FrameCheck check;
    std::vector<std::byte> pixels;
    for (const FoundSegment& segment : found.good) check_segment(segment, check, pixels);
    check.damaged = std::move(found.damaged);
    // Places behind the last picture were never used.
    std::erase_if(check.bad, [&](const BadPicture& b) {
        return b.fault == FrameFault::no_record && b.number > check.last;
    });
    return check;
}

void end_frames(const std::filesystem::path& folder, const std::string& camera, std::uint64_t last) {
    FoundSegments found = find_segments(folder, camera);
    for (const auto& file : unfinished_files(folder, camera)) remove_file(file);
    const auto ends_before = [last](const FoundSegment& s) {
        return s.info.first > std::max<std::uint64_t>(last, 1);
    };
    for (FoundSegment& s : found.good) {
        const std::uint64_t places = last + 1 - std::min(s.info.first, last + 1);
        if (ends_before(s)) {
            remove_file(s.file);
        } else if (places < s.info.places) {
            cut(s, places);
            s.info.places = places;
        }
    }
    std::erase_if(found.good, ends_before);
    sync_folder(folder);
    if (!found.good.empty()) link_pictures(folder, found, last);
}

FrameCheck finish_frames(const std::filesystem::path& folder, const std::string& camera) {
    FrameCheck check = verify_frames(folder, camera);
    end_frames(folder, camera, check.last);
    return check;
}

}  // namespace shaker
