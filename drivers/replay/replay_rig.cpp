#include "drivers/errors.hpp"
#include "drivers/replay/opened_session.hpp"

namespace shaker {

namespace {

class RecordedAccelerometer final : public Accelerometer {
public:
    explicit RecordedAccelerometer(const SessionReader& r)
        : info_{r.header().accelerometer},
          counts_{h5::read<std::int32_t>(r.opened().entry.get(), "raw/accelerometer/counts")},
          first_{h5::read<std::int64_t>(r.opened().entry.get(), "raw/accelerometer/block_first")},
          arrived_{h5::read<std::int64_t>(r.opened().entry.get(), "raw/accelerometer/block_arrived")},
          quality_{h5::read<std::uint8_t>(r.opened().entry.get(), "raw/accelerometer/block_quality")},
          size_{h5::read<std::uint8_t>(r.opened().entry.get(), "raw/accelerometer/block_size")} {
        if (arrived_.size() != first_.size() || quality_.size() != first_.size() ||
            size_.size() != first_.size())
            throw InputError{"recording: raw/accelerometer has block columns of different length"};
        std::size_t samples = 0;
        for (const std::uint8_t n : size_) {
            if (n > AccelBlock::capacity)
                throw InputError{"recording: raw/accelerometer/block_size " + std::to_string(n) +
                                 " is more than " + std::to_string(AccelBlock::capacity)};
            samples += n;
        }
        if (3 * samples != counts_.size())
            throw InputError{"recording: raw/accelerometer/counts has " + std::to_string(counts_.size()) +
                             " values, its blocks have 3 x " + std::to_string(samples)};
    }
    [[nodiscard]] AccelerometerInfo info() const override { return info_; }
    bool read(AccelBlock& block, std::chrono::milliseconds) override {
        if (ended()) return false;
        const std::size_t n = size_[next_];
        block = {.first = {first_[next_]},
                 .arrived = HostTime{std::chrono::nanoseconds{arrived_[next_]}},
                 .quality = static_cast<Quality>(quality_[next_]),
                 .size = static_cast<int>(n)};
        for (std::size_t i = 0; i < n; ++i)
            for (std::size_t k = 0; k < 3; ++k) block.counts[i][k] = counts_[3 * (sample_ + i) + k];
        sample_ += n;
        ++next_;
        return true;
    }
    [[nodiscard]] bool ended() const noexcept override { return next_ >= first_.size(); }
    void stop() noexcept override { next_ = first_.size(); }

private:
    AccelerometerInfo info_;
    std::vector<std::int32_t> counts_;
    std::vector<std::int64_t> first_, arrived_;
    std::vector<std::uint8_t> quality_, size_;
    std::size_t next_ = 0, sample_ = 0;
};

class RecordedCameraStream final : public Camera {
public:
    RecordedCameraStream(const SessionReader& r, const View& view)
        : entry_{r.opened().entry.get()},
          view_{view},
          at_{"raw/" + view.camera + "/"},
          tick_{h5::read<std::int64_t>(entry_, at_ + "tick")},
          arrived_{h5::read<std::int64_t>(entry_, at_ + "arrived")},
          stamp_{h5::read<std::int64_t>(entry_, at_ + "stamp")},
          mid_{h5::read<double>(entry_, at_ + "mid_exposure")},
          quality_{h5::read<std::uint8_t>(entry_, at_ + "quality")} {
        if (arrived_.size() != tick_.size() || stamp_.size() != tick_.size() || mid_.size() != tick_.size() ||
            quality_.size() != tick_.size())
            throw InputError{"recording: " + at_ + " has columns of different length"};
        if (tick_.empty()) return;
        const auto [shape, bytes] = h5::description_of(entry_, at_ + "frames");
        if (shape.size() != 3 || shape[0] != tick_.size() || shape[1] > 20000 || shape[2] > 20000)
            throw InputError{"recording: " + at_ + "frames is not " + std::to_string(tick_.size()) +
                             " pictures of at most 20000 x 20000 pixels"};
        if (bytes != 1 && bytes != 2)
            throw InputError{"recording: " + at_ + "frames has neither 8 nor 16 bits"};
        height_ = static_cast<int>(shape[1]);
        width_ = static_cast<int>(shape[2]);
        bytes_ = static_cast<int>(bytes);
    }
    [[nodiscard]] const View& view() const override { return view_; }
    FramePtr read(std::chrono::milliseconds) override {
        if (ended()) return nullptr;
        auto frame = std::make_shared<Frame>();
        frame->tick = {tick_[next_]};
        frame->arrived = HostTime{std::chrono::nanoseconds{arrived_[next_]}};
        if (stamp_[next_] != no_stamp) frame->stamp = CameraStamp{stamp_[next_]};
        if (mid_[next_] == mid_[next_]) frame->mid_exposure = master_time(mid_[next_]);
        frame->quality = static_cast<Quality>(quality_[next_]);
        frame->width = width_;
        frame->height = height_;
        frame->bytes_per_pixel = bytes_;
        const std::size_t pixels = static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
        frame->pixels.resize(pixels * static_cast<std::size_t>(bytes_));
        if (bytes_ == 1) {
            h5::read_row<std::uint8_t>(entry_, at_ + "frames", next_,
                                       {reinterpret_cast<std::uint8_t*>(frame->pixels.data()), pixels});
        } else {
            h5::read_row<std::uint16_t>(entry_, at_ + "frames", next_,
                                        {reinterpret_cast<std::uint16_t*>(frame->pixels.data()), pixels});
        }
        ++next_;
        return frame;
    }
    [[nodiscard]] bool ended() const noexcept override { return next_ >= tick_.size(); }
    void stop() noexcept override { next_ = tick_.size(); }

private:
    hid_t entry_;
    View view_;
    std::string at_;
    std::vector<std::int64_t> tick_, arrived_, stamp_;
    std::vector<double> mid_;
    std::vector<std::uint8_t> quality_;
    int width_ = 0, height_ = 0, bytes_ = 1;
    std::size_t next_ = 0;
};

}  // namespace

Rig replay_rig(const SessionReader& reader) {
    Rig rig;
    rig.name = "replay:";
    if (reader.header().accelerometer.rate_hz > 0)
        rig.accelerometer = std::make_unique<RecordedAccelerometer>(reader);
    if (!reader.header().keep_frames) return rig;
    for (const View& view : reader.header().views)
        rig.cameras.push_back(std::make_unique<RecordedCameraStream>(reader, view));
    return rig;
}

}  // namespace shaker
