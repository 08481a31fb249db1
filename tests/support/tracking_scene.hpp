#pragma once
// One target of each kind, drawn where it is told to be, and the tracker that follows it.
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "drivers/view.hpp"
#include "tests/support/test_picture.hpp"
#include "tracking/tracker.hpp"

namespace shaker::test {

/// A scene with one target: at `shift` = 0 it is where frame 0 has it. Grey levels 0..255, contrast about
/// 100.
struct TrackingScene {
    std::string name;
    View view;
    int width = 0, height = 0;
    double contrast = 100;
    std::function<void(TestPicture&, Point shift)> draw;
    /// Smallest standard deviation any method can have at a noise, px; NaN where there is no closed form.
    std::function<double(double noise)> bound;

    [[nodiscard]] TestPicture picture(Point shift) const;
};

/// disc, small disc (one dot), rectangle, dots, bars, patch; PSF of 0.8 px.
std::vector<TrackingScene> tracking_scenes();
const TrackingScene& tracking_scene(const std::string& name);

/// Frames in, fixes of the first target out.
class Follower {
public:
    explicit Follower(const View& view) : tracker_{view} {}
    Fix operator()(const Shot& shot) { return tracker_.update(shot.view(), CameraTick{tick_++}).front(); }
    void skip(std::int64_t frames) { tick_ += frames; }

private:
    ViewTracker tracker_;
    std::int64_t tick_ = 0;
};

}  // namespace shaker::test
