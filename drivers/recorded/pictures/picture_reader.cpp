#include "drivers/recorded/pictures/picture_reader.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>

#include "drivers/errors.hpp"

namespace shaker::pictures {

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
