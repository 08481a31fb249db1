#include "daemon/bench/region_camera.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <optional>

#include "drivers/frame_pool.hpp"

namespace shaker::bench {

namespace {

constexpr int least_margin_px = 16;
constexpr double most_tilt = 0.34;  // sine of 20 degrees
constexpr int pool_frames = 192;    // more than the rings behind a camera hold

View view_of(const View& whole, const PictureRegion& region) {
    View view = whole;
    view.origin_px = {whole.origin_px[0] + region.x, whole.origin_px[1] + region.y};
    for (Target& t : view.targets) {
        t.roi_px[0] -= region.x;
        t.roi_px[1] -= region.y;
    }
    return view;
}

class RegionCamera final : public Camera {
public:
    explicit RegionCamera(std::unique_ptr<Camera> whole)
        : whole_{std::move(whole)},
          region_{region_of(whole_->view())},
          view_{view_of(whole_->view(), region_)} {}
    [[nodiscard]] const View& view() const override { return view_; }
    [[nodiscard]] DeviceCounts counts() const noexcept override { return whole_->counts(); }
    FramePtr read(std::chrono::milliseconds wait) override {
        const FramePtr frame = whole_->read(wait);
        return frame ? part_of(*frame) : nullptr;
    }
    [[nodiscard]] bool ended() const noexcept override { return whole_->ended(); }
    void stop() noexcept override { whole_->stop(); }

private:
    FramePtr part_of(const Frame& frame) {
        const int x = std::min(region_.x, frame.width), y = std::min(region_.y, frame.height);
        const int width = region_.width == 0 ? frame.width - x : std::min(region_.width, frame.width - x);
        const int height =
            region_.height == 0 ? frame.height - y : std::min(region_.height, frame.height - y);
        if (!pool_ && width > 0 && height > 0)
            pool_.emplace(pool_frames, width, height, frame.bytes_per_pixel);
        std::shared_ptr<Frame> part = pool_ ? pool_->acquire() : nullptr;
        if (!part) part = std::make_shared<Frame>();
        part->tick = frame.tick;
        part->arrived = frame.arrived;
        part->stamp = frame.stamp;
        part->mid_exposure = frame.mid_exposure;
        part->quality = frame.quality;
        part->width = width;
        part->height = height;
        part->bytes_per_pixel = frame.bytes_per_pixel;
        const std::size_t row =
            static_cast<std::size_t>(width) * static_cast<std::size_t>(frame.bytes_per_pixel);
        part->pixels.resize(row * static_cast<std::size_t>(height));
        for (int k = 0; k < height; ++k)
            std::memcpy(part->pixels.data() + static_cast<std::size_t>(k) * row,
                        frame.view().row(y + k) + std::ptrdiff_t{x} * frame.bytes_per_pixel, row);
        return part;
    }

    std::unique_ptr<Camera> whole_;
    PictureRegion region_;
    View view_;
    std::optional<FramePool> pool_;
};

}  // namespace

PictureRegion region_of(const View& view) {
    if (view.targets.empty()) return {};
    const bool along_rows = std::abs(view.along[1]) <= most_tilt,
               along_columns = std::abs(view.along[0]) <= most_tilt;
    if (!along_rows && !along_columns) return {};
    const std::size_t across = along_rows ? 1 : 0;
    int first = std::numeric_limits<int>::max(), last = 0;
    for (const Target& t : view.targets) {
        first = std::min(first, t.roi_px[across]);
        last = std::max(last, t.roi_px[across] + t.roi_px[across + 2]);
    }
    const int margin = std::max(least_margin_px, (last - first) / 2);
    const int from = std::max(0, first - margin);
    const int size = last + margin - from;
    return along_rows ? PictureRegion{0, from, 0, size} : PictureRegion{from, 0, size, 0};
}

void take_regions(Rig& rig) {
    for (std::unique_ptr<Camera>& camera : rig.cameras)
        if (!camera->view().positions) camera = std::make_unique<RegionCamera>(std::move(camera));
}

}  // namespace shaker::bench
