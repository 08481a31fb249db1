#include "drivers/recorded/pictures/picture_store.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <stdexcept>
#include <utility>
#include <vector>

#include "drivers/errors.hpp"
#include "drivers/recorded/pictures/picture_check.hpp"

namespace shaker::pictures {

namespace {

/// In whole blocks.
std::uint64_t usual_frames(const PictureShape& shape) {
    constexpr std::uint64_t least = 64;
    return std::max(least,
                    usual_segment_bytes / shape.bytes() / PictureSegment::block * PictureSegment::block);
}

PictureShape shape_of(const Frame& frame) { return {frame.width, frame.height, frame.bytes_per_pixel}; }

std::string words_for(const PictureShape& s) {
    return fmt::format("{} x {} pixels of {} bytes", s.width, s.height, s.bytes_per_pixel);
}

/// Camera names become file names; a name that ends like a segment's would be mistaken for one.
void expect_name(const std::string& camera) {
    constexpr std::size_t most = 64;
    const auto odd = [](unsigned char c) { return c < ' ' || c == '/' || c == 0x7F; };
    if (camera.empty() || camera.size() > most || camera.front() == '.' || std::ranges::any_of(camera, odd))
        throw InputError{fmt::format(
            "camera \"{}\": expected a name of 1 to {} bytes without slashes and control characters that "
            "does not begin with a dot",
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

PictureStore::PictureStore(std::filesystem::path folder, std::string camera, std::uint64_t segment_frames)
    : folder_{std::move(folder)}, camera_{std::move(camera)}, segment_frames_{segment_frames} {
    expect_name(camera_);
    if (const auto files = segment_files(folder_, camera_); !files.empty())
        throw InputError{
            fmt::format("{}: already exists; pictures are never overwritten", files[0].string())};
    maker_.grant();  // before the drive
    closer_.grant();
}

PictureStore::~PictureStore() = default;

void PictureStore::prepare(const PictureShape& shape) {
    constexpr int most = PictureShape::most;
    if (segment_) throw std::logic_error{"prepare() was called twice"};
    if (shape.width < 1 || shape.width > most || shape.height < 1 || shape.height > most ||
        shape.bytes_per_pixel < 1 || shape.bytes_per_pixel > 2)
        throw InputError{fmt::format(
            "camera \"{}\": pictures of {} are not supported; expected 1 x 1 to {} x {} of 1 or 2 "
            "bytes",
            camera_, words_for(shape), most, most)};
    if (segment_frames_ == 0) segment_frames_ = usual_frames(shape);
    std::error_code error;
    if (std::filesystem::create_directories(folder_, error)) h5::sync_folder(folder_.parent_path());
    if (error) throw DeviceError{folder_.string() + ": cannot be created: " + error.message()};
    auto lock = h5::FileLock::take_folder(folder_, h5::Sharing::shared);
    if (!lock) throw DeviceError{folder_.string() + ": another program recovers these pictures"};
    lock_ = std::move(*lock);
    segment_.emplace(segment_file(folder_, camera_, 0),
                     PictureSegmentInfo{camera_, shape, 1, segment_frames_});
}

// The helper has its own copies: it may outlive the segment they came from.
void PictureStore::begin_spare() {
    PictureSegmentInfo info = segment_->info();
    info.first = info.end();
    spare_ = maker_.run([file = segment_file(folder_, camera_, (info.first - 1) / segment_frames_), info] {
        return PictureSegment{file, info};
    });
}

void PictureStore::go_on() {
    if (!spare_.valid()) begin_spare();
    PictureSegment next = spare_.get();
    next.follow(*segment_);
    if (closing_.valid()) closing_.get();
    closing_ = closer_.run([full = std::move(*segment_)]() mutable { full.sync(); });
    segment_ = std::move(next);
}

template <class Work>
auto PictureStore::guarded(Work work) {
    try {
        return work();
    } catch (...) {
        closed_ = true;
        throw;
    }
}

std::uint64_t PictureStore::add(const Frame& frame, bool more) {
    if (closed_) return 0;
    return guarded([&] {
        const PictureShape shape = shape_of(frame);
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

void PictureStore::sync() {
    if (closed_ || !segment_) return;
    guarded([&] {
        segment_->sync();
        if (closing_.valid()) closing_.get();
    });
}

void PictureStore::finish() {
    sync();
    if (!segment_) return;
    // A spare segment that could not be created is no longer needed.
    if (spare_.valid()) spare_.wait();
    if (closing_.valid()) closing_.wait();
    closed_ = true;
    if (const auto damaged = end_frames(folder_, camera_, stored()); !damaged.empty())
        throw DeviceError{fmt::format("camera \"{}\": {}", camera_, damaged.front())};
}

std::future<void> PictureStore::finish_beside() {
    return closer_.run([this] { finish(); });
}

std::uint64_t PictureStore::stored() const noexcept {
    return segment_ ? segment_->info().first - 1 + segment_->written() : 0;
}

void finish(std::span<const std::unique_ptr<PictureStore>> stores, const std::function<void()>& progress) {
    std::vector<std::future<void>> ends;
    for (const auto& store : stores) ends.push_back(store->finish_beside());
    for (std::future<void>& end : ends) {
        end.get();
        progress();
    }
}

}  // namespace shaker::pictures
