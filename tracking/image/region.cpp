#include "tracking/image/region.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>
#include <vector>

#include "calibration/camera/camera_scale.hpp"

namespace shaker::tracking {

Subject subject_of(const View& view, const Target& target) {
    const auto& r = target.roi_px;
    std::string label = "camera " + view.camera + ", target " + target.name + ", roi_px [" +
                        std::to_string(r[0]) + ", " + std::to_string(r[1]) + ", " + std::to_string(r[2]) +
                        ", " + std::to_string(r[3]) + "]";
    const double scale =
        calibration::mm_per_px_at(view, target.offset_mm, r[0] + 0.5 * (r[2] - 1), r[1] + 0.5 * (r[3] - 1));
    if (!(scale > 0) || !std::isfinite(scale)) {
        throw InputError{label + ": scale is " + std::to_string(scale) +
                         " mm per px; mm_per_px must be positive and offset_mm less than distance_mm"};
    }
    return {std::move(label), target, view.along, scale};
}

std::optional<Correction> correction_of(std::string key, double told_mm, double told_px, double measured_px) {
    constexpr double right = 0.01, right_px = 0.25;
    const double ratio = measured_px / told_px;
    if (!(told_px > 0) || std::abs(measured_px - told_px) <= std::max(right * told_px, right_px)) return {};
    return Correction{std::move(key), told_mm, told_mm * ratio};
}

Box region_in(const Subject& subject, const ImageView& image) {
    const auto& r = subject.target.roi_px;
    if (r[2] < 4 || r[3] < 4) throw InputError{subject.label + ": width and height must be at least 4 px"};
    // A region may extend slightly beyond the edge of the image.
    const auto clipped = [](int from, int size, int limit) {
        const std::int64_t end = std::int64_t{from} + size;
        return std::pair{std::clamp(from, 0, limit),
                         static_cast<int>(std::clamp<std::int64_t>(end, 0, limit))};
    };
    const auto [x0, x1] = clipped(r[0], r[2], image.width);
    const auto [y0, y1] = clipped(r[1], r[3], image.height);
    const double share = (static_cast<double>(x1) - x0) * (static_cast<double>(y1) - y0) /
                         (static_cast<double>(r[2]) * static_cast<double>(r[3]));
    if (share < 0.5 || x1 - x0 < 4 || y1 - y0 < 4) {
        throw InputError{subject.label + ": at least half must be inside the image of " +
                         std::to_string(image.width) + " x " + std::to_string(image.height) + " px"};
    }
    return {x0, y0, x1, y1};
}

Levels levels_in(const Subject& subject, const ImageView& image, const Box& box) {
    std::vector<double> values;
    with_pixels(image, [&](auto pixels) {
        for (int y = box.y0; y < box.y1; ++y) {
            for (int x = box.x0; x < box.x1; ++x) values.push_back(pixels.at(x, y));
        }
    });
    const auto percentile = [&](std::size_t percent) {
        const auto nth = values.begin() + static_cast<std::ptrdiff_t>((values.size() - 1) * percent / 100);
        std::nth_element(values.begin(), nth, values.end());
        return *nth;
    };
    const Levels levels{percentile(1), percentile(50), percentile(99)};
    if (!(levels.high - levels.low >= 2)) {
        throw InputError{subject.label + ": no contrast in the region; grey levels span " +
                         std::to_string(levels.low) + " to " + std::to_string(levels.high)};
    }
    return levels;
}

Axis axis_of(const Subject& subject) {
    const auto [x, y] = subject.along;
    const double cosine = std::max(std::abs(x), std::abs(y)) / std::hypot(x, y);
    if (!(cosine >= std::cos(20 * std::numbers::pi / 180))) {
        throw InputError{subject.label + ": along = [" + std::to_string(x) + ", " + std::to_string(y) +
                         "]; this kind of target requires at most 20 degrees from an image axis"};
    }
    return std::abs(x) >= std::abs(y) ? Axis::x : Axis::y;
}

double crossing_px(const Subject& subject, double length_mm) {
    const auto [x, y] = subject.along;
    const double cosine = std::max(std::abs(x), std::abs(y)) / std::hypot(x, y);
    return length_mm / subject.mm_per_px / cosine;
}

}  // namespace shaker::tracking
