#include "drivers/footage/media_camera.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "drivers/errors.hpp"
#include "drivers/footage/csv.hpp"
#include "drivers/footage/media.hpp"
#include "drivers/quantity.hpp"
#include "drivers/ticks.hpp"

namespace shaker::footage {
namespace {

std::vector<double> read_times(const std::filesystem::path& file) {
    const std::array<std::string, 1> column{"t_s"};
    const CsvColumns table = read_csv(file, column);
    require_increasing(table);
    return table.values.front();
}

double median_step(const std::vector<double>& t) {
    std::vector<double> steps;
    for (std::size_t i = 1; i < t.size(); ++i) steps.push_back(t[i] - t[i - 1]);
    const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
    std::nth_element(steps.begin(), middle, steps.end());
    return *middle;
}

std::string counted(const std::filesystem::path& times, std::size_t rows, const std::filesystem::path& media,
                    std::int64_t frames) {
    return times.string() + ": has " + std::to_string(rows) + " rows, but " + media.string() + " has " +
           std::to_string(frames) + " frames; expected one row per frame";
}

class MediaCamera final : public Camera {
public:
    MediaCamera(const LabCamera& description, std::unique_ptr<Media> media)
        : description_{description}, view_{description.view}, media_{std::move(media)} {
        if (description_.times) times_ = read_times(*description_.times);
        const auto count = media_->count();
        if (description_.times && count && *count != static_cast<std::int64_t>(times_.size()))
            wrong_count(*count);
        find_rate();
        more_ = media_->next(ahead_);
        if (!more_) throw InputError{description_.file.string() + ": has no pictures"};
    }

    [[nodiscard]] const View& view() const override { return view_; }
    [[nodiscard]] bool ended() const noexcept override { return stopped_ || !more_; }
    void stop() noexcept override { stopped_ = true; }

    FramePtr read(std::chrono::milliseconds) override {
        if (ended()) return {};
        auto frame = std::make_shared<Frame>();
        const MasterTime time = stamp(*frame);
        frame->mid_exposure = time;
        frame->arrived = HostTime{std::chrono::nanoseconds{std::llround(1e9 * seconds(time))}};
        const PictureFormat format = media_->format();
        frame->width = format.width;
        frame->height = format.height;
        frame->bytes_per_pixel = format.bytes_per_pixel;
        frame->pixels = std::move(ahead_.pixels);
        ahead_ = {};
        ++given_;
        more_ = media_->next(ahead_);
        if (!more_ && description_.times && given_ != times_.size())
            wrong_count(static_cast<std::int64_t>(given_));
        return frame;
    }

private:
    [[noreturn]] void wrong_count(std::int64_t frames) const {
        throw InputError{counted(*description_.times, times_.size(), description_.file, frames)};
    }

    void find_rate() {
        if (view_.frame_rate_hz <= 0 && times_.size() > 1) view_.frame_rate_hz = 1 / median_step(times_);
        if (view_.frame_rate_hz <= 0) view_.frame_rate_hz = media_->rate_hz().value_or(0);
        const std::string camera = "camera \"" + view_.camera + "\": ";
        if (view_.frame_rate_hz <= 0)
            throw InputError{camera + description_.file.string() +
                             " does not state its frame rate; set frame_rate_hz or "
                             "times"};
        // The median step of `times` may already be the longest possible exposure: only a clearly longer one
        // is an error.
        const double most_s = (description_.times ? 1.01 : 1 + 1e-9) / view_.frame_rate_hz;
        if (view_.exposure_s > most_s)
            throw InputError{camera + "exposure_s = " + to_text(view_.exposure_s) +
                             " is longer than the time between frames, " + to_text(1 / view_.frame_rate_hz) +
                             " s"};
    }

    /// Tick, quality and time of the next frame.
    MasterTime stamp(Frame& frame) {
        if (!description_.times) {
            tick_ += 1 + ahead_.missed;
            frame.quality = ahead_.missed > 0 ? Quality::gap : Quality::good;
            frame.tick = CameraTick{tick_};
            return master_time(description_.first_exposure_s + duration_s(tick_, view_.frame_rate_hz));
        }
        if (given_ == times_.size()) wrong_count(static_cast<std::int64_t>(given_) + remaining());
        const double t = times_[given_];
        const double since_last = given_ > 0 ? t - times_[given_ - 1] : 0;
        const double steps =
            given_ > 0 ? std::clamp(std::round(since_last * view_.frame_rate_hz), 1.0, 1e15) : 1.0;
        tick_ += static_cast<std::int64_t>(steps);
        frame.quality = steps > 1 ? Quality::gap : Quality::good;
        frame.tick = CameraTick{tick_};
        return master_time(t);
    }

    /// Number of pictures from the next one to the end of the file.
    std::int64_t remaining() {
        std::int64_t n = 1;
        while (media_->next(ahead_)) ++n;
        return n;
    }

    LabCamera description_;
    View view_;
    std::unique_ptr<Media> media_;
    std::vector<double> times_;
    Picture ahead_;
    bool more_ = false;
    std::size_t given_ = 0;
    std::int64_t tick_ = -1;
    std::atomic<bool> stopped_ = false;
};

}  // namespace

OpenCamera open_media_camera(const LabCamera& description) {
    auto media =
        open_media(description.file, description.times ? MissingNumbers::left_out : MissingNumbers::refused);
    const std::string note = media->note();
    return {std::make_unique<MediaCamera>(description, std::move(media)), note};
}

}  // namespace shaker::footage
