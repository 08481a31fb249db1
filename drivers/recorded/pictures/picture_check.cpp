#include "drivers/recorded/pictures/picture_check.hpp"

#include <algorithm>

#include "drivers/errors.hpp"
#include "drivers/recorded/pictures/picture_link.hpp"
#include "drivers/recorded/pictures/segment.hpp"

namespace shaker::pictures {

namespace {

PictureFault fault_at(const OpenedSegment& segment, std::uint64_t place, std::span<std::byte> pixels) {
    const PictureRecord& record = segment.records()[place];
    const std::uint64_t number = segment.found().info.first + place;
    const PictureFault fault = fault_of(record, number);
    if (fault != PictureFault::none) return fault;
    try {
        segment.read(place, pixels);
    } catch (const DeviceError&) {
        return PictureFault::bad_pixels;  // one bad spot of the disk; the pictures around it may be intact
    }
    return fault_of(record, number, pixels);
}

void check_segment(const FoundSegment& found, PictureCheck& check, std::vector<std::byte>& pixels) {
    const OpenedSegment segment{found};
    pixels.resize(found.info.shape.bytes());
    for (std::uint64_t place = 0; place < found.info.places; ++place) {
        const std::uint64_t number = found.info.first + place;
        const PictureFault fault = fault_at(segment, place, pixels);
        if (fault == PictureFault::none) {
            check.whole.push_back(number);
            check.last = number;
        } else {
            check.bad.push_back({number, found.file, fault});
        }
    }
    segment.forget();
}

/// Replaces a segment by an exact copy of its first `places` pictures.
void cut(const FoundSegment& found, std::uint64_t places) {
    PictureSegmentInfo info = found.info;
    info.places = places;
    const std::filesystem::path name = h5::unfinished(found.file);
    PictureSegment shorter{name, info};
    try {
        const OpenedSegment segment{found};
        const std::size_t bytes = info.shape.bytes();
        std::vector<std::byte> block(PictureSegment::large_block * bytes);
        for (std::uint64_t from = 0; from < places; from += PictureSegment::large_block) {
            const std::uint64_t count = std::min(PictureSegment::large_block, places - from);
            segment.read(from, std::span{block}.first(count * bytes));
            for (std::uint64_t i = 0; i < count; ++i)
                shorter.add(segment.records()[from + i], std::span{block}.subspan(i * bytes, bytes), true);
        }
        shorter.sync();
        shorter.replace(found.file);
    } catch (...) {
        std::error_code ignored;
        std::filesystem::remove(name, ignored);
        throw;
    }
}

// A segment is shortened by a copy, which takes time. One that is three quarters full is not copied.
bool stays(const FoundSegment& segment, std::uint64_t places) {
    return 4 * places >= 3 * segment.info.places && OpenedSegment{segment}.used() <= places;
}

void remove_file(const std::filesystem::path& file) {
    std::error_code error;
    std::filesystem::remove(file, error);
    if (error) throw DeviceError{file.string() + ": cannot be removed: " + error.message()};
}

}  // namespace

PictureCheck verify_frames(const std::filesystem::path& folder, const std::string& camera) {
    FoundSegments found = find_segments(folder, camera);
    PictureCheck check;
    std::vector<std::byte> pixels;
    for (const FoundSegment& segment : found.good) check_segment(segment, check, pixels);
    check.damaged = std::move(found.damaged);
    // Places after the last picture were never used.
    std::erase_if(check.bad, [&](const BadPicture& b) {
        return b.fault == PictureFault::no_record && b.number > check.last;
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
        } else if (places < s.info.places && stays(s, places)) {
            h5::release(s.file, s.plan.frames_at + places * s.info.shape.bytes());
        } else if (places < s.info.places) {
            cut(s, places);
            s.info.places = places;
        }
    }
    std::erase_if(found.good, ends_before);
    h5::sync_folder(folder);
    if (!found.good.empty()) link_pictures(folder, found, last);
}

PictureCheck finish_frames(const std::filesystem::path& folder, const std::string& camera) {
    PictureCheck check = verify_frames(folder, camera);
    end_frames(folder, camera, check.last);
    return check;
}

}  // namespace shaker::pictures
