#include "drivers/recorded/pictures/picture_check.hpp"

#include <algorithm>

#include "drivers/errors.hpp"
#include "drivers/recorded/h5/image.hpp"
#include "drivers/recorded/pictures/segment.hpp"

namespace shaker::pictures {

namespace {

/// Selects `count` rows of a data set from `first` on.
h5::Handle rows(const std::vector<hsize_t>& shape, hsize_t first, hsize_t count) {
    h5::Handle space{H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr), "rows"};
    std::vector<hsize_t> start(shape.size(), 0), extent = shape;
    start[0] = first;
    extent[0] = count;
    h5::check(H5Sselect_hyperslab(space.get(), H5S_SELECT_SET, start.data(), nullptr, extent.data(), nullptr),
              "rows");
    return space;
}

/// shape: of the whole data set; its first axis covers the places of all segments.
h5::Handle joined(hid_t parent, const std::string& name, hid_t type, std::vector<hsize_t> shape,
                  const FoundSegments& segments) {
    const h5::Handle create{H5Pcreate(H5P_DATASET_CREATE), name};
    h5::check(H5Pset_obj_track_times(create.get(), false), name);
    const hsize_t last = shape[0];
    for (const FoundSegment& s : segments.good) {
        const hsize_t before = s.info.first - 1;
        if (before >= last) break;
        const hsize_t count = std::min<hsize_t>(s.info.places, last - before);
        if (count == 0) continue;
        std::vector<hsize_t> source = shape;
        source[0] = s.info.places;
        h5::check(H5Pset_virtual(create.get(), rows(shape, before, count).get(), s.file.filename().c_str(),
                                 ("/" + name).c_str(), rows(source, 0, count).get()),
                  name);
    }
    const h5::Handle space{H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr), name};
    return {H5Dcreate2(parent, name.c_str(), type, space.get(), H5P_DEFAULT, create.get(), H5P_DEFAULT),
            name};
}

/// Writes <folder>/<camera>.h5: /frames and /index as virtual data sets over the segments (relative names),
/// up to picture number `last`. Pictures without a file, and their records, read as zeros. DeviceError when
/// it cannot be written; an existing file is then kept.
void link_pictures(const std::filesystem::path& folder, const FoundSegments& segments, std::uint64_t last) {
    const PictureSegmentInfo& first = segments.good.front().info;
    const h5::Image file;
    h5::set_attribute(h5::open_group(file.id(), "/").get(), "camera", first.camera);
    const h5::Handle frames = joined(
        file.id(), "frames", pixel_type(first.shape),
        {last, static_cast<hsize_t>(first.shape.height), static_cast<hsize_t>(first.shape.width)}, segments);
    h5::set_attribute(frames.get(), "units", std::string{"count"});
    joined(file.id(), "index", record_type().get(), {last}, segments);
    h5::replace_file(link_file(folder, first.camera), file.head(file.size()));
}

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

std::vector<std::string> end_frames(const std::filesystem::path& folder, const std::string& camera,
                                    std::uint64_t last) {
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
    return found.damaged;
}

PictureCheck finish_frames(const std::filesystem::path& folder, const std::string& camera) {
    PictureCheck check = verify_frames(folder, camera);
    end_frames(folder, camera, check.last);
    return check;
}

}  // namespace shaker::pictures
