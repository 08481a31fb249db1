#include "drivers/replay/frame_segment.hpp"

#include <algorithm>

namespace shaker {

namespace {

/// Under another name until it is complete: a crash leaves no half-made segment.
DiskFile made(const std::filesystem::path& name, const FrameSegmentImage& image) {
    DiskFile file = DiskFile::create(unfinished(name));
    try {
        file.reserve(image.bytes);
        file.write(0, image.head);
        file.sync();
        file.rename(name);
    } catch (...) {
        std::error_code ignored;
        std::filesystem::remove(file.path(), ignored);
        throw;
    }
    return file;
}

}  // namespace

FrameSegment::FrameSegment(const std::filesystem::path& file, const FrameSegmentInfo& info)
    : FrameSegment{file, info, image_of(info)} {}

FrameSegment::FrameSegment(const std::filesystem::path& file, const FrameSegmentInfo& info,
                           const FrameSegmentImage& image)
    : info_{info}, plan_{image.plan}, file_{made(file, image)}, begin_{image.plan.frames_at} {
    records_.reserve(large_block);
}

void FrameSegment::add(const FrameRecord& record, std::span<const std::byte> pixels, bool more) {
    if (pages_.empty())
        pages_.resize(whole_pages(page_bytes + large_block * info_.shape.bytes()) / page_bytes);
    std::ranges::copy(
        pixels, std::as_writable_bytes(std::span{pages_}).begin() + static_cast<std::ptrdiff_t>(gathered_));
    gathered_ += pixels.size();
    records_.push_back(record);
    ++taken_;
    if (records_.size() >= (more ? large_block : block) || full()) write();
}

void FrameSegment::write() {
    if (records_.empty()) return;
    // The last page is written with what it has so far and again when it is full: what it held before is
    // written over with the same bytes.
    const auto bytes = std::as_writable_bytes(std::span{pages_});
    const std::size_t whole = whole_pages(gathered_);
    std::ranges::fill(bytes.subspan(gathered_, whole - gathered_), std::byte{});
    file_.write_pages(begin_, bytes.first(whole));
    file_.write(plan_.index_at + written_ * sizeof(FrameRecord), std::as_bytes(std::span{records_}));
    written_ = taken_;
    records_.clear();
    const std::size_t done = gathered_ / page_bytes * page_bytes;
    gathered_ -= done;
    begin_ += done;
    std::ranges::copy(bytes.subspan(done, gathered_), bytes.begin());
}

void FrameSegment::sync() {
    write();
    file_.sync();
}

}  // namespace shaker
