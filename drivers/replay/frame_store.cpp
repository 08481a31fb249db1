#include "drivers/replay/frame_store.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "drivers/errors.hpp"
#include "drivers/replay/frame_check.hpp"

namespace shaker {

namespace {

/// About 256 MB, in whole blocks.
std::uint64_t usual_frames(const FrameShape& shape) {
    constexpr std::uint64_t bytes = 256'000'000, least = 64;
    return std::max(least, bytes / shape.bytes() / FrameSegment::block * FrameSegment::block);
}

FrameShape shape_of(const Frame& frame) { return {frame.width, frame.height, frame.bytes_per_pixel}; }

std::string words_for(const FrameShape& s) {
    return fmt::format("{} x {} pixels of {} bytes", s.width, s.height, s.bytes_per_pixel);
}

/// Names go into file names; one that ends like a segment's would be taken for one.
void expect_name(const std::string& camera) {
    constexpr std::size_t most = 64;
    const auto odd = [](unsigned char c) { return c < ' ' || c == '/' || c == 0x7F; };
    if (camera.empty() || camera.size() > most || camera.front() == '.' || std::ranges::any_of(camera, odd))
        throw InputError{
            fmt::format("camera \"{}\": a name of 1 to {} bytes without slashes and control characters that "
                        "does not begin with a dot was expected",
                        camera, most)};
    constexpr std::size_t least_digits = 4;
    const std::size_t hyphen = camera.find_last_not_of("0123456789");
    if (hyphen != std::string::npos && camera[hyphen] == '-' && camera.size() - hyphen > least_digits)
        throw InputError{
            fmt::format("camera \"{}\": a name that does not end in a hyphen and four digits or more was "
                        "expected",
                        camera)};
}

}  // namespace

FrameStore::FrameStore(std::filesystem::path folder, std::string camera, std::uint64_t segment_frames)
    : folder_{std::move(folder)}, camera_{std::move(camera)}, segment_frames_{segment_frames} {
    expect_name(camera_);
    if (const auto files = segment_files(folder_, camera_); !files.empty())
        throw InputError{
            fmt::format("{}: is there already: pictures are not written over", files[0].string())};
}

FrameStore::~FrameStore() = default;

void FrameStore::prepare(const FrameShape& shape) {
    constexpr int most = FrameShape::most;
    if (segment_) throw std::logic_error{"pictures are prepared once"};
    if (shape.width < 1 || shape.width > most || shape.height < 1 || shape.height > most ||
        shape.bytes_per_pixel < 1 || shape.bytes_per_pixel > 2)
        throw InputError{
            fmt::format("camera \"{}\": pictures of {} were asked for; 1 x 1 to {} x {} of 1 or 2 "
                        "bytes can be stored",
                        camera_, words_for(shape), most, most)};
    if (segment_frames_ == 0) segment_frames_ = usual_frames(shape);
    std::error_code error;
    if (std::filesystem::create_directories(folder_, error)) sync_folder(folder_.parent_path());
    if (error) throw DeviceError{folder_.string() + ": cannot be made: " + error.message()};
    segment_.emplace(segment_file(folder_, camera_, 0), FrameSegmentInfo{camera_, shape, 1, segment_frames_});
}

// The helper has its own copies: it may outlast the segment they came from.
void FrameStore::begin_spare() {
    FrameSegmentInfo info = segment_->info();
    info.first = info.end();
    spare_ = std::async(std::launch::async,
                        [file = segment_file(folder_, camera_, (info.first - 1) / segment_frames_), info] {
                            return FrameSegment{file, info};
                        });
}

void FrameStore::go_on() {
    if (!spare_.valid()) begin_spare();
    FrameSegment next = spare_.get();
    next.follow(*segment_);
    if (closing_.valid()) closing_.get();
    closing_ = std::async(std::launch::async, [full = std::move(*segment_)]() mutable { full.sync(); });
    segment_ = std::move(next);
}

template <class Work>
auto FrameStore::guarded(Work work) {
    try {
        return work();
    } catch (...) {
        closed_ = true;
        throw;
    }
}

std::uint64_t FrameStore::add(const Frame& frame, bool more) {
    if (closed_) return 0;
    return guarded([&] {
        const FrameShape shape = shape_of(frame);
        if (!segment_) prepare(shape);
        if (shape != segment_->info().shape || frame.pixels.size() != shape.bytes())
            throw DeviceError{
                fmt::format("camera \"{}\": a picture of {} in {} bytes came after pictures of {}", camera_,
                            words_for(shape), frame.pixels.size(), words_for(segment_->info().shape))};
        if (segment_->full()) go_on();
        segment_->add(record_of(frame, taken_ + 1), frame.pixels, more);
        if (segment_->written() > 0 && !spare_.valid()) begin_spare();
        return ++taken_;
    });
}

void FrameStore::sync() {
    if (closed_ || !segment_) return;
    guarded([&] {
        segment_->sync();
        if (closing_.valid()) closing_.get();
    });
}

void FrameStore::finish() {
    sync();
    if (!segment_) return;
    // A spare that could not be made is not needed any more.
    if (spare_.valid()) spare_.wait();
    if (closing_.valid()) closing_.wait();
    closed_ = true;
    end_frames(folder_, camera_, stored());
}

std::uint64_t FrameStore::stored() const noexcept {
    return segment_ ? segment_->info().first - 1 + segment_->written() : 0;
}

}  // namespace shaker
