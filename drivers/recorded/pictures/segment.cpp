#include "drivers/recorded/pictures/segment.hpp"

#include <algorithm>

namespace shaker::pictures {

namespace {

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
