#include "drivers/hardware/video/video_camera.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cmath>
#include <condition_variable>
#include <cstring>
#include <mutex>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "drivers/codecs/codecs.hpp"
#include "drivers/descriptor.hpp"
#include "drivers/errors.hpp"
#include "drivers/frame_pool.hpp"
#include "drivers/hardware/clock/exposure_counter.hpp"
#include "drivers/hardware/clock/host_now.hpp"
#include "drivers/quantity.hpp"
#include "drivers/time.hpp"

namespace shaker::video {

namespace {

using namespace std::chrono_literals;

constexpr std::size_t most_bytes = std::size_t{256} << 20;  // of frames held by readers
constexpr std::size_t least_frames = 16, most_frames = 256;
constexpr int grey_fourcc = 'G' | 'R' << 8 | 'E' << 16 | 'Y' << 24;  // V4L2's name of 8-bit grey
constexpr std::chrono::seconds silence{2};
constexpr std::chrono::milliseconds attention{
    10};  // longest delay until stop() is noticed while waiting for a device

std::string why_unreadable(const std::filesystem::path& path) {
    const Descriptor fd{::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)};
    if (fd < 0) return std::strerror(errno);
    return "OpenCV cannot read its format";
}

/// Pictures from OpenCV, as grey frames of a pool.
class Source {
public:
    Source(const std::filesystem::path& path, int backend, const std::string& camera)
        : path_{path}, camera_{camera} {
        if (!capture_->open(path.string(), backend)) fail("cannot be opened: " + why_unreadable(path));
    }
    [[noreturn]] void fail(const std::string& what) const {
        throw DeviceError{"camera \"" + camera_ + "\" (" + path_.string() + "): " + what};
    }
    cv::VideoCapture& capture() { return *capture_; }

    /// Decodes the grabbed picture; the first one defines the size.
    bool retrieve() {
        if (!capture_->retrieve(raw_) || raw_.empty()) return false;
        if (raw_.channels() == 1)
            grey_ = raw_;
        else
            cv::cvtColor(raw_, grey_, raw_.channels() == 4 ? cv::COLOR_BGRA2GRAY : cv::COLOR_BGR2GRAY);
        if (grey_.depth() != CV_8U && grey_.depth() != CV_16U) fail("its pixels are not integers");
        if (!pool_) {
            const std::size_t bytes = grey_.total() * grey_.elemSize();
            const auto frames = std::clamp(most_bytes / bytes, least_frames, most_frames);
            size_ = grey_.size();
            depth_ = grey_.depth();
            pool_.emplace(static_cast<int>(frames), grey_.cols, grey_.rows,
                          static_cast<int>(grey_.elemSize()));
        }
        if (grey_.size() != size_ || grey_.depth() != depth_) fail("its pictures change their size");
        return true;
    }
    /// The decoded picture; null when readers hold all frames.
    std::shared_ptr<Frame> frame() {
        std::shared_ptr<Frame> frame = pool_->acquire();
        if (frame == nullptr) return frame;
        const std::size_t row = static_cast<std::size_t>(grey_.cols) * grey_.elemSize();
        for (int y = 0; y < grey_.rows; ++y)
            std::memcpy(&frame->pixels[static_cast<std::size_t>(y) * row], grey_.ptr(y), row);
        return frame;
    }
    [[nodiscard]] cv::Size size() const { return size_; }

private:
    std::filesystem::path path_;
    std::string camera_;
    std::unique_ptr<cv::VideoCapture> capture_ = codecs::new_capture();
    cv::Mat raw_, grey_;
    cv::Size size_;
    int depth_ = CV_8U;
    std::optional<FramePool> pool_;
};

class MovieCamera final : public Camera {
public:
    MovieCamera(const VideoSettings& settings, View view, std::vector<std::string>& granted)
        : view_{std::move(view)},
          paced_{settings.paced},
          source_{settings.file, cv::CAP_FFMPEG, view_.camera} {
        const double own = source_.capture().get(cv::CAP_PROP_FPS);
        view_.frame_rate_hz = settings.frame_rate_hz > 0 ? settings.frame_rate_hz : own;
        if (!(view_.frame_rate_hz > 0)) source_.fail("does not report its frame rate; set frame_rate_hz");
        advance();
        if (!more_) source_.fail("has no pictures");
        granted.push_back("movie of " + std::to_string(source_.size().width) + " x " +
                          std::to_string(source_.size().height) + " at " + to_text(view_.frame_rate_hz) +
                          " Hz (its own " + to_text(own) + ")" + (paced_ ? "" : ", as fast as possible"));
    }

    [[nodiscard]] const View& view() const override { return view_; }
    [[nodiscard]] DeviceCounts counts() const noexcept override { return {taken_, lost_, 0, 0}; }
    [[nodiscard]] bool ended() const noexcept override { return stopped_ || !more_; }
    void stop() noexcept override {
        const std::scoped_lock lock{mutex_};
        stopped_ = true;
        changed_.notify_all();
    }

    FramePtr read(std::chrono::milliseconds wait) override {
        if (ended()) return nullptr;
        if (!began_) began_ = hardware::host_now();
        const double media_s = duration_s(next_, view_.frame_rate_hz);
        const auto media = std::chrono::nanoseconds{std::llround(1e9 * media_s)};
        if (paced_ && !reached(*began_ + media, wait)) return nullptr;
        const std::shared_ptr<Frame> frame = source_.frame();
        if (frame == nullptr && !paced_) return nullptr;  // wait until a frame is free
        if (frame == nullptr) {
            ++lost_;
        } else {
            frame->tick = {next_};
            frame->stamp = CameraStamp{media.count()};
            frame->arrived = hardware::host_now();
            frame->quality = next_ > last_ + 1 ? Quality::gap : Quality::good;
            last_ = next_;
            ++taken_;
        }
        advance();
        return frame;
    }

private:
    void advance() {
        more_ = source_.capture().grab() && source_.retrieve();
        ++next_;
    }
    /// False if the time has not been reached after `wait`.
    bool reached(HostTime due, std::chrono::milliseconds wait) {
        std::unique_lock lock{mutex_};
        const auto left = due - hardware::host_now();
        if (left.count() <= 0) return true;
        changed_.wait_for(lock, std::min<std::chrono::nanoseconds>(left, wait),
                          [&] { return stopped_.load(); });
        return !stopped_ && hardware::host_now() >= due;
    }

    View view_;
    bool paced_;
    Source source_;
    std::int64_t next_ = -1, last_ = -1;
    std::optional<HostTime> began_;
    std::mutex mutex_;
    std::condition_variable changed_;
    std::atomic<bool> stopped_ = false, more_ = true;
    std::atomic<std::uint64_t> taken_ = 0, lost_ = 0;
};

class V4l2Camera final : public Camera {
public:
    V4l2Camera(const VideoSettings& settings, View view, std::vector<std::string>& granted)
        : view_{std::move(view)}, source_{settings.device, cv::CAP_V4L2, view_.camera} {
        configure(settings, granted);
        if (!source_.capture().grab() || !source_.retrieve()) source_.fail("sends no pictures");
        const cv::Size size = source_.size();
        if (settings.width > 0 && size != cv::Size{settings.width, settings.height})
            source_.fail("cannot deliver pictures of " + std::to_string(settings.width) + " x " +
                         std::to_string(settings.height) + " pixels; it offers " +
                         std::to_string(size.width) + " x " + std::to_string(size.height));
        granted.push_back("pictures of " + std::to_string(size.width) + " x " + std::to_string(size.height));
        const double period_s = view_.frame_rate_hz > 0 ? 1 / view_.frame_rate_hz : 0;
        exposures_.emplace(hardware::ExposureCounter::Ids::wide, std::llround(1e9 * period_s), 0);
        heard_ = hardware::host_now();
    }

    [[nodiscard]] const View& view() const override { return view_; }
    [[nodiscard]] DeviceCounts counts() const noexcept override { return {taken_, lost_, incidents_, 0}; }
    [[nodiscard]] bool ended() const noexcept override { return stopped_; }
    void stop() noexcept override { stopped_ = true; }

    FramePtr read(std::chrono::milliseconds wait) override {
        const HostTime until = hardware::host_now() + wait;
        while (!stopped_) {
            if (ready(std::clamp<std::chrono::nanoseconds>(until - hardware::host_now(), 1ms, attention)))
                if (FramePtr frame = take()) return frame;
            if (hardware::host_now() - heard_ > silence) source_.fail("sent no picture for 2 s");
            if (hardware::host_now() >= until) break;
        }
        return nullptr;
    }

private:
    void configure(const VideoSettings& settings, std::vector<std::string>& granted) {
        cv::VideoCapture& c = source_.capture();
        if (c.set(cv::CAP_PROP_FOURCC, grey_fourcc))
            c.set(cv::CAP_PROP_CONVERT_RGB, 0);
        else
            granted.emplace_back("grey: converted from the colour that the device sends");
        if (settings.width > 0) {
            c.set(cv::CAP_PROP_FRAME_WIDTH, settings.width);
            c.set(cv::CAP_PROP_FRAME_HEIGHT, settings.height);
        }
        if (settings.frame_rate_hz > 0) c.set(cv::CAP_PROP_FPS, settings.frame_rate_hz);
        view_.frame_rate_hz = c.get(cv::CAP_PROP_FPS);
        granted.push_back("frame rate " + to_text(view_.frame_rate_hz) + " Hz (requested " +
                          (settings.frame_rate_hz > 0 ? to_text(settings.frame_rate_hz) : "none") + ")");
        if (settings.exposure_s <= 0) return;
        constexpr double by_hand = 1, unit_s = 1e-4;  // V4L2_EXPOSURE_MANUAL; exposure in 100 us
        const bool set = c.set(cv::CAP_PROP_AUTO_EXPOSURE, by_hand) &&
                         c.set(cv::CAP_PROP_EXPOSURE, std::round(settings.exposure_s / unit_s));
        if (set) view_.exposure_s = unit_s * c.get(cv::CAP_PROP_EXPOSURE);
        granted.push_back(set ? "exposure " + to_text(view_.exposure_s) + " s (requested " +
                                    to_text(settings.exposure_s) + ")"
                              : "exposure: cannot be set on this device (requested " +
                                    to_text(settings.exposure_s) + " s)");
    }

    bool ready(std::chrono::nanoseconds wait) {
        try {
            return codecs::wait_for_picture(source_.capture(), wait);
        } catch (const cv::Exception& error) {
            source_.fail("is gone: " + error.err);
        }
    }

    FramePtr take() {
        if (!source_.capture().grab()) source_.fail("is gone");
        const HostTime time = hardware::host_now();
        heard_ = time;
        if (!source_.retrieve()) {
            ++incidents_;
            return nullptr;
        }
        const std::shared_ptr<Frame> frame = source_.frame();
        if (frame == nullptr) {  // the stamp of the next one shows the loss
            ++incidents_;
            return nullptr;
        }
        const auto stamp =
            std::chrono::nanoseconds{std::llround(1e6 * source_.capture().get(cv::CAP_PROP_POS_MSEC))};
        const auto age = time.time_since_epoch() - stamp;
        // A stamp computed from the frame rate may be slightly in the future.
        const bool monotonic = age > -silence && age < silence;
        frame->arrived = monotonic ? HostTime{std::min(stamp, time.time_since_epoch())} : time;
        if (monotonic) frame->stamp = CameraStamp{stamp.count()};
        const hardware::ExposurePlace place = exposures_->next({{}, frame->stamp, frame->arrived});
        frame->tick = place.tick;
        frame->quality = place.gap ? Quality::gap : Quality::good;
        lost_ += static_cast<std::uint64_t>(place.missed);
        ++taken_;
        return frame;
    }

    View view_;
    Source source_;
    std::optional<hardware::ExposureCounter> exposures_;
    HostTime heard_;
    std::atomic<bool> stopped_ = false;
    std::atomic<std::uint64_t> taken_ = 0, lost_ = 0, incidents_ = 0;
};

}  // namespace

VideoSettings read_video_settings(SettingsTable& table) {
    VideoSettings s;
    if (table.has("device") == table.has("file"))
        table.fail("", "expected either device = \"/dev/video...\" or file = \"a movie\"");
    s.device = table.text("device", "");
    if (const std::filesystem::path file = table.text("file", ""); !file.empty())
        s.file = table.folder() / file;
    s.width = table.integer("width_px", 0, 65536, 0);
    s.height = table.integer("height_px", 0, 65536, 0);
    if ((s.width == 0) != (s.height == 0)) table.fail("width_px", "requires height_px, and the reverse");
    s.frame_rate_hz = table.number("frame_rate_hz", {0, 100000}, 0);
    s.exposure_s = table.number("exposure_s", {0, 10}, 0);
    s.paced = table.choice("pace", {"rate", "fast"}, 0) == 0;
    return s;
}

std::unique_ptr<Camera> open_video_camera(const VideoSettings& settings, View view,
                                          std::vector<std::string>* granted) {
    std::vector<std::string> lines;
    std::unique_ptr<Camera> camera;
    if (settings.file.empty())
        camera = std::make_unique<V4l2Camera>(settings, std::move(view), lines);
    else
        camera = std::make_unique<MovieCamera>(settings, std::move(view), lines);
    if (granted != nullptr) granted->insert(granted->end(), lines.begin(), lines.end());
    return camera;
}

}  // namespace shaker::video
