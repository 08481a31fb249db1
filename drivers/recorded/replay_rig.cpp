#include <atomic>
#include <optional>

#include "drivers/errors.hpp"
#include "drivers/recorded/opened_recording.hpp"
#include "drivers/recorded/pictures/picture_reader.hpp"

namespace shaker::recorded {

namespace {

/// Samples or pictures that were delivered, and those missing between. counts(): any thread.
class Delivered {
public:
    void add(std::int64_t first, std::int64_t size) noexcept {
        if (next_ && first > *next_) lost_ += static_cast<std::uint64_t>(first - *next_);
        next_ = first + size;
        taken_ += static_cast<std::uint64_t>(size);
    }
    [[nodiscard]] DeviceCounts counts() const noexcept { return {.taken = taken_, .lost = lost_}; }

private:
    std::optional<std::int64_t> next_;
    std::atomic<std::uint64_t> taken_{0}, lost_{0};
};

class RecordedAccelerometer final : public Accelerometer {
public:
    RecordedAccelerometer(const RecordingReader& r, const AccelerometerInfo& info)
        : info_{info},
          counts_{h5::read<std::int32_t>(r.opened().entry.get(), path_of(raw::counts))},
          blocks_{read_rows<RawBlock>(r.opened().entry.get(), raw::blocks)} {
        std::size_t samples = 0;
        for (const RawBlock& block : blocks_) samples += block.size;
        if (3 * samples != counts_.size())
            throw InputError{"recording: raw/accelerometer/counts has " + std::to_string(counts_.size()) +
                             " values, its blocks have 3 x " + std::to_string(samples)};
    }
    [[nodiscard]] AccelerometerInfo info() const override { return info_; }
    [[nodiscard]] DeviceCounts counts() const noexcept override { return read_.counts(); }
    bool read(AccelBlock& block, std::chrono::milliseconds) override {
        if (ended()) return false;
        const RawBlock& head = blocks_[next_];
        const std::size_t n = head.size;
        block = {.first = head.first, .arrived = head.arrived, .quality = head.quality, .size = head.size};
        for (std::size_t i = 0; i < n; ++i)
            for (std::size_t k = 0; k < 3; ++k) block.counts[i][k] = counts_[3 * (sample_ + i) + k];
        sample_ += n;
        ++next_;
        read_.add(head.first.n, static_cast<std::int64_t>(n));
        return true;
    }
    [[nodiscard]] bool ended() const noexcept override { return stopped_ || next_ >= blocks_.size(); }
    void stop() noexcept override { stopped_ = true; }

private:
    AccelerometerInfo info_;
    std::vector<std::int32_t> counts_;
    std::vector<RawBlock> blocks_;
    std::size_t next_ = 0, sample_ = 0;
    Delivered read_;
    std::atomic<bool> stopped_{false};
};

class RecordedCamera final : public Camera {
public:
    RecordedCamera(const RecordingReader& r, const View& view)
        : view_{view},
          tick_{h5::read<std::int64_t>(r.opened().entry.get(), "raw/" + view.camera + "/tick")},
          picture_{h5::read<std::uint64_t>(r.opened().entry.get(), "raw/" + view.camera + "/picture")} {
        if (picture_.size() != tick_.size())
            throw InputError{"recording: raw/" + view.camera + " has columns of different lengths"};
        if (!tick_.empty()) pictures_.emplace(pictures_folder(r.file()), view.camera);
    }
    [[nodiscard]] const View& view() const override { return view_; }
    [[nodiscard]] DeviceCounts counts() const noexcept override { return read_.counts(); }
    FramePtr read(std::chrono::milliseconds) override {
        if (ended()) return nullptr;
        const std::string which =
            "recording: raw/" + view_.camera + "/picture " + std::to_string(picture_[next_]);
        if (picture_[next_] == 0 || picture_[next_] > pictures_->count())
            throw InputError{which + " is not one of the " + std::to_string(pictures_->count()) +
                             " stored pictures"};
        FramePtr frame = pictures_->read(picture_[next_] - 1);
        if (frame->tick.n != tick_[next_])
            throw InputError{which + " belongs to frame " + std::to_string(frame->tick.n) +
                             ", not to frame " + std::to_string(tick_[next_])};
        ++next_;
        read_.add(frame->tick.n, 1);
        return frame;
    }
    [[nodiscard]] bool ended() const noexcept override { return stopped_ || next_ >= tick_.size(); }
    void stop() noexcept override { stopped_ = true; }

private:
    View view_;
    std::vector<std::int64_t> tick_;
    std::vector<std::uint64_t> picture_;
    std::optional<pictures::PictureReader> pictures_;
    std::size_t next_ = 0;
    Delivered read_;
    std::atomic<bool> stopped_{false};
};

class RecordedPositions final : public Camera {
public:
    RecordedPositions(const RecordingReader& r, const View& view)
        : view_{view}, frames_{r.frames(view.camera)} {
        for (const Frame& frame : frames_)
            if (frame.sightings.size() != view.targets.size())
                throw InputError{"recording: raw/" + view.camera + "/sightings has " +
                                 std::to_string(frame.sightings.size()) + " targets, the view has " +
                                 std::to_string(view.targets.size())};
    }
    [[nodiscard]] const View& view() const override { return view_; }
    [[nodiscard]] DeviceCounts counts() const noexcept override { return read_.counts(); }
    FramePtr read(std::chrono::milliseconds) override {
        if (ended()) return nullptr;
        read_.add(frames_[next_].tick.n, 1);
        return std::make_shared<const Frame>(std::move(frames_[next_++]));
    }
    [[nodiscard]] bool ended() const noexcept override { return stopped_ || next_ >= frames_.size(); }
    void stop() noexcept override { stopped_ = true; }

private:
    View view_;
    std::vector<Frame> frames_;
    std::size_t next_ = 0;
    Delivered read_;
    std::atomic<bool> stopped_{false};
};

std::unique_ptr<Camera> recorded_camera(const RecordingReader& reader, const View& view) {
    if (view.positions) return std::make_unique<RecordedPositions>(reader, view);
    return std::make_unique<RecordedCamera>(reader, view);
}

}  // namespace

Rig replay_rig(const RecordingReader& reader, const RecordingHeader& header, bool pictures) {
    Rig rig;
    rig.name = "replay:";
    if (header.accelerometer.rate_hz > 0)
        rig.accelerometer = std::make_unique<RecordedAccelerometer>(reader, header.accelerometer);
    for (const View& view : header.views)
        if (pictures) rig.cameras.push_back(recorded_camera(reader, view));
    return rig;
}

}  // namespace shaker::recorded
