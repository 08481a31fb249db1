#include "drivers/recorded/pictures/picture_reader.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>

#include "drivers/errors.hpp"

namespace shaker::pictures {

namespace {

[[noreturn]] void refuse(const std::string& why) { throw InputError{why}; }

/// A data set of the expected kind: in this file, uncompressed, contiguous.
struct Contiguous {
    std::vector<hsize_t> shape;
    h5::Handle type;
    std::uint64_t at = 0;
};
Contiguous contiguous(hid_t file, const std::string& name) {
    H5L_info_t link{};
    if (H5Lget_info(file, name.c_str(), &link, H5P_DEFAULT) < 0) refuse("has no /" + name);
    if (link.type != H5L_TYPE_HARD) refuse("/" + name + " is a link, which is not followed");
    Contiguous found;
    found.shape = h5::description_of(file, name).shape;  // refuses data in other files and compressed data
    const h5::Handle set{H5Dopen2(file, name.c_str(), H5P_DEFAULT), name};
    const h5::Handle create{H5Dget_create_plist(set.get()), name};
    if (H5Pget_layout(create.get()) != H5D_CONTIGUOUS) refuse("/" + name + " is not contiguous");
    found.type = {H5Dget_type(set.get()), name};
    const haddr_t at = H5Dget_offset(set.get());
    const bool empty = std::ranges::find(found.shape, hsize_t{0}) != found.shape.end();
    if (!empty && at == HADDR_UNDEF) refuse("/" + name + " is not allocated in the file");
    found.at = empty ? 0 : at;
    return found;
}

void expect_inside(std::uint64_t at, std::uint64_t bytes, std::uint64_t size, const std::string& name) {
    if (at > size || bytes > size - at) refuse("/" + name + " ends beyond the end of the file");
}

void expect_attribute(hid_t file, const std::string& name, std::uint64_t value) {
    const double given = h5::read_attribute(file, "/", name);
    if (given != static_cast<double>(value)) refuse(fmt::format("@{} is {}, not {}", name, given, value));
}

std::uint64_t first_number(hid_t file) {
    constexpr double most = 1e15;  // a double holds it exactly
    const double first = h5::read_attribute(file, "/", "first_number");
    if (!(first >= 1 && first <= most) || first != std::floor(first))
        refuse(fmt::format("@first_number is {}, not a whole number from 1", first));
    return static_cast<std::uint64_t>(first);
}

PictureShape shape_of(const Contiguous& frames) {
    const auto& s = frames.shape;
    constexpr auto most = static_cast<hsize_t>(PictureShape::most);
    if (s.size() != 3) refuse(fmt::format("/frames has {} axes, not 3", s.size()));
    if (s[1] < 1 || s[1] > most || s[2] < 1 || s[2] > most)
        refuse(fmt::format("/frames has pictures of {} x {} pixels, not 1 to {}", s[2], s[1], most));
    PictureShape shape{static_cast<int>(s[2]), static_cast<int>(s[1]), 1};
    if (H5Tequal(frames.type.get(), pixel_type(shape)) > 0) return shape;
    shape.bytes_per_pixel = 2;
    if (H5Tequal(frames.type.get(), pixel_type(shape)) <= 0)
        refuse("/frames does not have integers of 8 or 16 bits");
    return shape;
}

FoundSegment find(const std::filesystem::path& path, const std::string& camera) {
    const h5::Handle file = h5::open_file(path);
    const Contiguous frames = contiguous(file.get(), "frames"), index = contiguous(file.get(), "index");
    FoundSegment found{path, {camera, shape_of(frames), 1, frames.shape[0]}, {index.at, frames.at}};
    if (index.shape != std::vector<hsize_t>{found.info.places})
        refuse("/index does not have one record per picture");
    if (H5Tequal(index.type.get(), record_type().get()) <= 0) refuse("/index has an unknown type of record");
    const std::uint64_t size = std::filesystem::file_size(path);
    expect_inside(index.at, found.info.places * sizeof(PictureRecord), size, "index");
    expect_inside(frames.at, found.info.places * found.info.shape.bytes(), size, "frames");
    const std::string name = h5::read_attribute_text(file.get(), "/", "camera");
    if (name != camera) refuse(fmt::format("@camera is \"{}\", not \"{}\"", name, camera));
    expect_attribute(file.get(), "width", frames.shape[2]);
    expect_attribute(file.get(), "height", frames.shape[1]);
    expect_attribute(file.get(), "bytes_per_pixel",
                     static_cast<std::uint64_t>(found.info.shape.bytes_per_pixel));
    found.info.first = first_number(file.get());
    return found;
}

void add_gap(FoundSegments& all, std::uint64_t from, std::uint64_t to) {
    if (from < to)
        all.damaged.push_back(fmt::format("pictures {} to {} are in no readable file", from, to - 1));
}

}  // namespace

FoundSegment find_segment(const std::filesystem::path& file, const std::string& camera) {
    try {
        return find(file, camera);
    } catch (const std::exception& error) {
        const std::string what = error.what();
        throw InputError{what.starts_with(file.string()) ? what : file.string() + ": " + what};
    }
}

FoundSegments find_segments(const std::filesystem::path& folder, const std::string& camera) {
    FoundSegments all;
    for (const auto& file : segment_files(folder, camera)) {
        try {
            all.good.push_back(find_segment(file, camera));
        } catch (const InputError& error) {
            all.damaged.emplace_back(error.what());
        }
    }
    if (all.good.empty())
        throw InputError{
            all.damaged.empty()
                ? fmt::format("{}: no pictures of camera \"{}\"{}", folder.string(), camera,
                              std::filesystem::is_directory(folder)
                                  ? ""
                                  : ": there is no such folder; copy it beside the recording, or use "
                                    "the stored positions (replay --from tracks)")
                : all.damaged.front()};
    std::ranges::stable_sort(all.good, {}, [](const FoundSegment& s) { return s.info.first; });
    std::uint64_t next = 1;
    for (const FoundSegment& s : all.good) {
        if (s.info.first < next)
            throw InputError{fmt::format("{}: begins with picture {}, which is in another file too",
                                         s.file.string(), s.info.first)};
        if (s.info.shape != all.good.front().info.shape)
            throw InputError{fmt::format("{}: the size of its pictures differs from {}", s.file.string(),
                                         all.good.front().file.string())};
        add_gap(all, next, s.info.first);
        next = s.info.end();
    }
    return all;
}

OpenedSegment::OpenedSegment(const FoundSegment& segment)
    : found_{segment}, file_{h5::DiskFile::open(segment.file)}, records_(segment.info.places) {
    if (!records_.empty()) file_.read(found_.plan.index_at, std::as_writable_bytes(std::span{records_}));
}

std::uint64_t OpenedSegment::used() const noexcept {
    std::uint64_t places = records_.size();
    while (places > 0 &&
           fault_of(records_[places - 1], found_.info.first + places - 1) == PictureFault::no_record)
        --places;
    return places;
}

void OpenedSegment::read(std::uint64_t place, std::span<std::byte> pixels) const {
    file_.read(found_.plan.frames_at + place * found_.info.shape.bytes(), pixels);
}

PictureReader::PictureReader(const std::filesystem::path& folder, const std::string& camera)
    : found_{find_segments(folder, camera)} {
    for (auto s = found_.good.rbegin(); s != found_.good.rend() && count_ == 0; ++s) {
        opened_.emplace(*s);
        if (const std::uint64_t used = opened_->used(); used > 0) count_ = s->info.first + used - 1;
    }
}

const OpenedSegment& PictureReader::segment_with(std::uint64_t number) {
    const auto holds = [number](const FoundSegment& s) {
        return s.info.first <= number && number < s.info.end();
    };
    if (opened_ && holds(opened_->found())) return *opened_;
    const auto after =
        std::ranges::upper_bound(found_.good, number, {}, [](const FoundSegment& s) { return s.info.first; });
    if (after == found_.good.begin() || !holds(*std::prev(after)))
        throw InputError{fmt::format("{}: picture {} is in no readable file",
                                     found_.good.front().file.parent_path().string(), number)};
    if (opened_) opened_->forget();
    return opened_.emplace(*std::prev(after));
}

FramePtr PictureReader::read(std::uint64_t picture) {
    if (picture >= count_)
        throw InputError{fmt::format("picture {} does not exist; there are {}", picture, count_)};
    const std::uint64_t number = picture + 1;
    const OpenedSegment& segment = segment_with(number);
    const std::uint64_t place = number - segment.found().info.first;
    const PictureRecord& record = segment.records()[place];
    PictureFault fault = fault_of(record, number);
    Frame frame = frame_of(record, shape());
    if (fault == PictureFault::none) {
        frame.pixels.resize(shape().bytes());
        segment.read(place, frame.pixels);
        fault = fault_of(record, number, frame.pixels);
    }
    if (fault != PictureFault::none)
        throw InputError{
            fmt::format("{}: picture {} {}", segment.found().file.string(), number, words_for(fault))};
    return std::make_shared<const Frame>(std::move(frame));
}

}  // namespace shaker::pictures
