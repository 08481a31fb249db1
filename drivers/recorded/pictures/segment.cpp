#include "drivers/recorded/pictures/segment.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <charconv>
#include <optional>
#include <stdexcept>
#include <utility>

#include "drivers/recorded/h5/image.hpp"

namespace shaker::pictures {

namespace {

/// A contiguous data set whose space is allocated now and never filled by HDF5.
h5::Handle reserved(hid_t parent, const std::string& name, hid_t type, const std::vector<hsize_t>& shape) {
    const h5::Handle create{H5Pcreate(H5P_DATASET_CREATE), name};
    h5::check(H5Pset_layout(create.get(), H5D_CONTIGUOUS), name);
    h5::check(H5Pset_alloc_time(create.get(), H5D_ALLOC_TIME_EARLY), name);
    h5::check(H5Pset_fill_time(create.get(), H5D_FILL_TIME_NEVER), name);
    h5::check(H5Pset_obj_track_times(create.get(), false), name);
    const h5::Handle space{H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr), name};
    return {H5Dcreate2(parent, name.c_str(), type, space.get(), H5P_DEFAULT, create.get(), H5P_DEFAULT),
            name};
}

/// The segment number in a file name; empty when it is not a segment of this camera.
std::optional<std::uint64_t> number_in(const std::string& name, const std::string& camera) {
    const std::string begin = camera + "-", end = ".h5";
    constexpr std::size_t least_digits = 4, most_digits = 9;
    if (!name.starts_with(begin) || !name.ends_with(end) || name.size() <= begin.size() + end.size())
        return std::nullopt;
    const char* const from = name.data() + begin.size();
    const char* const to = name.data() + name.size() - end.size();
    const auto digits = static_cast<std::size_t>(to - from);
    if (digits < least_digits || digits > most_digits) return std::nullopt;
    std::uint64_t number = 0;
    const auto [stopped, error] = std::from_chars(from, to, number);
    if (error != std::errc{} || stopped != to) return std::nullopt;
    return number;
}

/// Created under a temporary name until it is complete: a crash leaves no incomplete segment.
h5::DiskFile made(const std::filesystem::path& name, const PictureSegmentImage& image) {
    h5::DiskFile file = h5::DiskFile::create(h5::unfinished(name));
    try {
        file.reserve(image.bytes);
        file.write(0, image.head);
        file.sync();
        file.rename(name, h5::DiskFile::Existing::keep);
    } catch (...) {
        std::error_code ignored;
        std::filesystem::remove(file.path(), ignored);
        throw;
    }
    return file;
}

}  // namespace

hid_t pixel_type(const PictureShape& shape) {
    return shape.bytes_per_pixel == 1 ? H5T_STD_U8LE : H5T_STD_U16LE;
}

h5::Handle record_type() {
    const std::string what = "record of a picture";
    h5::Handle type{H5Tcreate(H5T_COMPOUND, sizeof(PictureRecord)), what};
    const auto insert = [&](const char* name, std::size_t at, hid_t member) {
        h5::check(H5Tinsert(type.get(), name, at, member), what);
    };
    insert("number", offsetof(PictureRecord, number), H5T_STD_U64LE);
    insert("tick", offsetof(PictureRecord, tick), H5T_STD_I64LE);
    insert("arrived", offsetof(PictureRecord, arrived), H5T_STD_I64LE);
    insert("stamp", offsetof(PictureRecord, stamp), H5T_STD_I64LE);
    insert("mid_exposure", offsetof(PictureRecord, mid_exposure), H5T_IEEE_F64LE);
    insert("quality", offsetof(PictureRecord, quality), H5T_STD_U8LE);
    insert("crc32c", offsetof(PictureRecord, pixels_crc32c), H5T_STD_U32LE);
    insert("record_crc32c", offsetof(PictureRecord, record_crc32c), H5T_STD_U32LE);
    return type;
}

PictureSegmentImage image_of(const PictureSegmentInfo& info) {
    PictureSegmentImage image;
    h5::Image file{h5::page_bytes};
    const h5::Handle root = h5::open_group(file.id(), "/");
    h5::set_attribute(root.get(), "camera", info.camera);
    h5::set_attribute(root.get(), "width", std::int64_t{info.shape.width});
    h5::set_attribute(root.get(), "height", std::int64_t{info.shape.height});
    h5::set_attribute(root.get(), "bytes_per_pixel", std::int64_t{info.shape.bytes_per_pixel});
    h5::set_attribute(root.get(), "first_number", static_cast<std::int64_t>(info.first));
    const h5::Handle index = reserved(root.get(), "index", record_type().get(), {info.places});
    const h5::Handle frames = reserved(
        root.get(), "frames", pixel_type(info.shape),
        {info.places, static_cast<hsize_t>(info.shape.height), static_cast<hsize_t>(info.shape.width)});
    h5::set_attribute(frames.get(), "units", std::string{"count"});
    if (info.places == 0) {
        image.bytes = file.size();
        image.head = file.head(image.bytes);
        return image;
    }
    image.plan = {H5Dget_offset(index.get()), H5Dget_offset(frames.get())};
    const std::uint64_t end = image.plan.frames_at + info.places * info.shape.bytes();
    // The last page of pictures is written whole: nothing may follow them.
    if (image.plan.frames_at % h5::page_bytes != 0 || file.size() != end)
        throw std::logic_error{"HDF5 did not put the pictures on a page at the end of the file"};
    image.head = file.head(image.plan.frames_at);
    image.bytes = h5::whole_pages(end);
    return image;
}

std::filesystem::path segment_file(const std::filesystem::path& folder, const std::string& camera,
                                   std::uint64_t segment) {
    return folder / fmt::format("{}-{:04}.h5", camera, segment);
}

std::vector<std::filesystem::path> segment_files(const std::filesystem::path& folder,
                                                 const std::string& camera) {
    std::vector<std::pair<std::uint64_t, std::filesystem::path>> found;
    std::error_code none;
    for (const auto& entry : std::filesystem::directory_iterator{folder, none})
        if (const auto number = number_in(entry.path().filename().string(), camera))
            found.emplace_back(*number, entry.path());
    std::ranges::sort(found);
    std::vector<std::filesystem::path> files;
    files.reserve(found.size());
    for (auto& [number, file] : found) files.push_back(std::move(file));
    return files;
}

std::vector<std::filesystem::path> unfinished_files(const std::filesystem::path& folder,
                                                    const std::string& camera) {
    std::vector<std::filesystem::path> files;
    std::error_code none;
    for (const auto& entry : std::filesystem::directory_iterator{folder, none}) {
        std::filesystem::path of = entry.path();
        while (of.extension() == ".part") of.replace_extension();
        if (of == entry.path()) continue;
        if (of == link_file(folder, camera) || number_in(of.filename().string(), camera))
            files.push_back(entry.path());
    }
    return files;
}

std::filesystem::path link_file(const std::filesystem::path& folder, const std::string& camera) {
    return folder / (camera + ".h5");
}

PictureSegment::PictureSegment(const std::filesystem::path& file, const PictureSegmentInfo& info)
    : PictureSegment{file, info, image_of(info)} {}

PictureSegment::PictureSegment(const std::filesystem::path& file, const PictureSegmentInfo& info,
                               const PictureSegmentImage& image)
    : info_{info}, plan_{image.plan}, file_{made(file, image)}, begin_{image.plan.frames_at} {
    records_.reserve(large_block);
}

void PictureSegment::add(const PictureRecord& record, std::span<const std::byte> pixels, bool more) {
    if (pages_.empty())
        pages_.resize(h5::whole_pages(h5::page_bytes + large_block * info_.shape.bytes()) / h5::page_bytes);
    std::ranges::copy(
        pixels, std::as_writable_bytes(std::span{pages_}).begin() + static_cast<std::ptrdiff_t>(gathered_));
    gathered_ += pixels.size();
    records_.push_back(record);
    ++taken_;
    if (records_.size() >= (more ? large_block : block) || full()) write();
}

void PictureSegment::write() {
    if (records_.empty()) return;
    // The last page is written with its present contents and again when it is full; the earlier bytes are
    // rewritten unchanged.
    const auto bytes = std::as_writable_bytes(std::span{pages_});
    const std::size_t whole = h5::whole_pages(gathered_);
    std::ranges::fill(bytes.subspan(gathered_, whole - gathered_), std::byte{});
    file_.write_pages(begin_, bytes.first(whole));
    file_.write(plan_.index_at + written_ * sizeof(PictureRecord), std::as_bytes(std::span{records_}));
    written_ = taken_;
    records_.clear();
    const std::size_t done = gathered_ / h5::page_bytes * h5::page_bytes;
    gathered_ -= done;
    begin_ += done;
    std::ranges::copy(bytes.subspan(done, gathered_), bytes.begin());
}

void PictureSegment::sync() {
    write();
    file_.sync();
}

}  // namespace shaker::pictures
