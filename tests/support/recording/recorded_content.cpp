#include "tests/support/recording/recorded_content.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <chrono>
#include <exception>
#include <limits>

#include "drivers/recorded/pictures/picture_reader.hpp"
#include "drivers/recorded/recording_file.hpp"

namespace shaker::test {

namespace {

void look_at_drive(const recorded::RecordingReader& file, RecordedContent& content) {
    const auto block = static_cast<std::int64_t>(file.header().dac.block_frames);
    const std::vector<PlayTime> played = file.play_times();
    for (std::size_t i = 1; i < played.size(); ++i)
        if (played[i].tick.n != played[i - 1].tick.n + block + played[i - 1].lost) ++content.missing;
    const double last = played.empty() ? 0 : static_cast<double>(played.back().tick.n + block);
    content.until_s = std::min(content.until_s, last / file.header().dac.rate_hz);
}

void look_at_accelerometer(const recorded::RecordingReader& file, RecordedContent& content) {
    const Rig rig = replay_rig(file, file.header(), false);
    AccelBlock block;
    std::int64_t next = 0;
    while (rig.accelerometer->read(block, std::chrono::milliseconds{0})) {
        if (block.first.n != next && !has(block.quality, Quality::gap)) ++content.missing;
        next = block.first.n + block.size;
    }
    content.until_s =
        std::min(content.until_s, static_cast<double>(next) / file.header().accelerometer.rate_hz);
}

void look_at_pictures(const recorded::RecordingReader& file, const std::vector<Frame>& frames,
                      CameraContent& camera, RecordedContent& content) {
    const std::vector<std::uint64_t> numbers = file.pictures_of(camera.camera);
    if (std::ranges::none_of(numbers, [](std::uint64_t n) { return n > 0; })) return;
    pictures::PictureReader pictures{recorded::pictures_folder(file.file()), camera.camera};
    std::uint64_t last = 0;
    for (std::size_t i = 0; i < frames.size() && i < numbers.size(); ++i) {
        if (numbers[i] == 0) continue;
        if (numbers[i] <= last || pictures.read(numbers[i] - 1)->tick != frames[i].tick)
            content.wrong.push_back(
                fmt::format("{}: frame {} has another frame's picture", camera.camera, i));
        last = numbers[i];
        ++camera.pictures;
    }
    camera.last_picture_s = seconds(pictures.read(pictures.count() - 1)->mid_exposure.value());
}

void look_at_tracks(const recorded::RecordingReader& file, const View& view, std::size_t frames,
                    RecordedContent& content) {
    for (const Target& target : view.targets)
        for (const recorded::Column& column :
             file.table(fmt::format("tracks/{}/{}", view.camera, target.name)))
            if (column.values.size() != frames)
                content.wrong.push_back(fmt::format("{}/{}: {} has {} rows beside {} frames", view.camera,
                                                    target.name, column.name, column.values.size(), frames));
}

CameraContent look_at_camera(const recorded::RecordingReader& file, const View& view,
                             RecordedContent& content) {
    CameraContent camera{.camera = view.camera, .rate_hz = view.frame_rate_hz};
    const std::vector<Frame> frames = file.frames(view.camera);
    for (std::size_t i = 1; i < frames.size(); ++i)
        if (frames[i].tick.n != frames[i - 1].tick.n + 1 && !has(frames[i].quality, Quality::gap))
            ++content.missing;
    camera.frames = frames.size();
    if (!frames.empty()) camera.last_frame_s = seconds(frames.back().mid_exposure.value());
    content.until_s = std::min(content.until_s, camera.last_frame_s);
    look_at_pictures(file, frames, camera, content);
    look_at_tracks(file, view, frames.size(), content);
    const auto count = [&](const char* what) {
        return static_cast<std::uint64_t>(file.scalar(fmt::format("pictures/{}/{}", view.camera, what)));
    };
    camera.produced = count("produced");
    camera.stored = count("stored");
    camera.dropped = count("dropped");
    if (camera.produced != camera.stored + camera.dropped || camera.produced != camera.frames ||
        camera.stored != camera.pictures)
        content.wrong.push_back(fmt::format(
            "{}: counts of {} produced, {} stored, {} dropped do not fit {} frames with {} "
            "pictures",
            view.camera, camera.produced, camera.stored, camera.dropped, camera.frames, camera.pictures));
    return camera;
}

}  // namespace

RecordedContent content_of(const std::filesystem::path& recording) {
    RecordedContent content{.until_s = std::numeric_limits<double>::infinity(), .cameras = {}, .wrong = {}};
    try {
        const recorded::RecordingReader file{recording};
        content.wrong = file.damage();
        look_at_drive(file, content);
        look_at_accelerometer(file, content);
        for (const View& view : file.header().views)
            content.cameras.push_back(look_at_camera(file, view, content));
    } catch (const std::exception& e) {
        content.wrong.emplace_back(e.what());
    }
    if (content.missing > 0)
        content.wrong.push_back(fmt::format("{} times something is missing", content.missing));
    return content;
}

}  // namespace shaker::test
