#include "drivers/hardware/genicam/genicam_camera.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <future>
#include <thread>
#include <utility>

#include "drivers/errors.hpp"
#include "drivers/hardware/clock/host_now.hpp"
#include "drivers/hardware/genicam/stream.hpp"
#include "drivers/quantity.hpp"

namespace shaker::genicam {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t queued_pictures = 48;
constexpr std::size_t least_given = 16, most_given = 256;   // frames held by readers at a time
constexpr std::size_t most_bytes = std::size_t{256} << 20;  // limit of their memory together
constexpr std::chrono::milliseconds attention{
    10};  // longest delay until stop() or a lost connection is noticed
constexpr std::chrono::milliseconds first_pause{100}, longest_pause{2000};  // between attempts to reopen

std::chrono::nanoseconds nanoseconds(double s) { return std::chrono::nanoseconds{std::llround(1e9 * s)}; }

std::unique_ptr<PictureBuffers> make_buffers(const GenicamPicture& picture) {
    const auto bytes = static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.height) *
                       static_cast<std::size_t>(picture.format->bytes_per_pixel());
    const std::size_t given = std::clamp(most_bytes / bytes, least_given, most_given);
    return std::make_unique<PictureBuffers>(picture, queued_pictures, given);
}

class GenicamCamera final : public Camera {
public:
    GenicamCamera(const GenicamSettings& settings, View view)
        : settings_{settings},
          view_{std::move(view)},
          stream_{std::make_unique<GenicamStream>(settings_, view_.camera)},
          picture_{stream_->picture()},
          period_{nanoseconds(1 / settings_.frame_rate_hz)},
          silence_{std::max<std::chrono::nanoseconds>(1s, 10 * period_)},
          exposures_{picture_.wide_ids ? hardware::ExposureCounter::Ids::wide
                                       : hardware::ExposureCounter::Ids::wrap_at_65535,
                     period_.count(), settings_.trigger == CameraTrigger::free ? 0 : silence_.count()} {
        view_.frame_rate_hz = settings_.frame_rate_hz;
        view_.exposure_s = picture_.exposure_s;
        buffers_ = make_buffers(picture_);
        stream_->start(*buffers_);
        heard_ = next_trigger_ = hardware::host_now();
    }

    [[nodiscard]] const std::vector<std::string>& granted() const { return stream_->granted(); }
    [[nodiscard]] const View& view() const override { return view_; }
    [[nodiscard]] bool ended() const noexcept override { return stopped_; }
    void stop() noexcept override { stopped_ = true; }
    [[nodiscard]] DeviceCounts counts() const noexcept override {
        return {taken_, lost_, incidents_, reopened_};
    }

    FramePtr read(std::chrono::milliseconds wait) override {
        const HostTime until = hardware::host_now() + wait;
        while (!stopped_) {
            const auto left =
                std::clamp<std::chrono::nanoseconds>(until - hardware::host_now(), 0ns, attention);
            if (FramePtr frame = stream_ != nullptr ? receive(left) : reopen(left)) return frame;
            if (hardware::host_now() >= until) break;
        }
        return nullptr;
    }

private:
    FramePtr receive(std::chrono::nanoseconds wait) {
        if (settings_.trigger == CameraTrigger::software) wait = std::min(wait, trigger());
        const auto received = stream_->receive(std::chrono::ceil<std::chrono::microseconds>(wait));
        const HostTime time = hardware::host_now();
        if (received) {
            heard_ = time;
            return received->whole ? place(*received) : broken();
        }
        const bool due = settings_.trigger != CameraTrigger::dac;
        if (stream_->control_lost() || (due && time - heard_ > silence_)) close(time);
        return nullptr;
    }

    FramePtr broken() {
        ++incidents_;
        return nullptr;
    }

    FramePtr place(const ReceivedPicture& received) {
        if (received.frame == nullptr)
            return broken();  // no free frame: the id of the next one shows the loss
        const hardware::ExposurePlace place = exposures_.next(received.sign);
        Frame& frame = *received.frame;
        frame.tick = place.tick;
        frame.stamp = received.sign.stamp;
        frame.arrived = received.sign.arrived;
        frame.quality = place.gap ? Quality::gap : Quality::good;
        lost_ += static_cast<std::uint64_t>(place.missed);
        incidents_ += place.clock_jumped ? 1 : 0;
        ++taken_;
        return received.frame;
    }

    /// Triggers a picture when one is due; returns the time to the next.
    std::chrono::nanoseconds trigger() {
        const HostTime time = hardware::host_now();
        if (time >= next_trigger_) {
            if (!stream_->trigger()) ++incidents_;
            next_trigger_ = std::max(next_trigger_ + period_, time);
        }
        return std::max<std::chrono::nanoseconds>(next_trigger_ - time, 0ns);
    }

    void close(HostTime time) {
        ++incidents_;
        away_since_ = next_attempt_ = time;
        pause_ = first_pause;
        exposures_.reopened();
        stream_->forsake();
        closing_ = std::move(stream_);
    }

    /// Closing and opening take seconds each when a camera does not answer, so a separate thread does both.
    FramePtr reopen(std::chrono::nanoseconds wait) {
        if (!attempt_.valid()) {
            if (hardware::host_now() < next_attempt_) {
                std::this_thread::sleep_for(
                    std::min<std::chrono::nanoseconds>(wait, next_attempt_ - hardware::host_now()));
                return nullptr;
            }
            attempt_ = std::async(std::launch::async, [this] {
                closing_.reset();
                auto stream = std::make_unique<GenicamStream>(settings_, view_.camera);
                if (stream->picture() != picture_)
                    throw DeviceError{"camera \"" + view_.camera + "\" (" + settings_.id +
                                      "): came back with a different picture size or format"};
                stream->start(*buffers_);
                return stream;
            });
        }
        if (attempt_.wait_for(wait) != std::future_status::ready) return nullptr;
        try {
            stream_ = attempt_.get();
            ++reopened_;
            heard_ = next_trigger_ = hardware::host_now();
        } catch (const DeviceError& error) {
            const double away_s = std::chrono::duration<double>{hardware::host_now() - away_since_}.count();
            if (away_s > settings_.give_up_s)
                throw DeviceError{std::string{error.what()} + "; it has been unavailable for " +
                                  to_text(0.1 * std::round(10 * away_s)) + " s"};
            next_attempt_ = hardware::host_now() + pause_;
            pause_ = std::min(2 * pause_, longest_pause);
        }
        return nullptr;
    }

    GenicamSettings settings_;
    View view_;
    std::unique_ptr<PictureBuffers> buffers_;  // must outlive the streams
    std::unique_ptr<GenicamStream> stream_;    // null while the camera is unavailable
    GenicamPicture picture_;
    std::chrono::nanoseconds period_;
    std::chrono::nanoseconds silence_;  // longer: the camera is gone, or its trigger pauses
    hardware::ExposureCounter exposures_;
    HostTime heard_;  // arrival of the last buffer
    HostTime next_trigger_;

    HostTime away_since_;
    HostTime next_attempt_;
    std::chrono::milliseconds pause_{};
    std::unique_ptr<GenicamStream> closing_;
    std::future<std::unique_ptr<GenicamStream>> attempt_;

    std::atomic<bool> stopped_ = false;
    std::atomic<std::uint64_t> taken_ = 0, lost_ = 0, incidents_ = 0, reopened_ = 0;
};

}  // namespace

std::unique_ptr<Camera> open_genicam_camera(const GenicamSettings& settings, View view,
                                            std::vector<std::string>* granted) {
    auto camera = std::make_unique<GenicamCamera>(settings, std::move(view));
    if (granted != nullptr)
        granted->insert(granted->end(), camera->granted().begin(), camera->granted().end());
    return camera;
}

}  // namespace shaker::genicam
