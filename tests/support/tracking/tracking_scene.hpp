#pragma once
// One target of each kind, drawn at a given position, and the tracker that follows it.
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "drivers/view.hpp"
#include "tests/support/tracking/test_picture.hpp"
#include "tracking/tracker.hpp"

namespace shaker::test {

/// What a lens and a distance make of a scene.
struct Look {
    double blur = 0.8;  // sigma of the PSF, px
    double size = 1;    // magnification about the middle of the picture
    double turn = 0;    // rad, of a patch about its middle
};

/// A scene with one target; `shift` = 0 is its position in frame 0. Grey levels 0..255, contrast about
/// 100.
struct TrackingScene {
    std::string name;
    View view;
    int width = 0, height = 0;
    double contrast = 100;
    std::function<void(TestPicture&, tracking::Point shift, const Look&)> draw;
    /// Smallest possible standard deviation at this noise, px; NaN without a closed form.
    std::function<double(double noise)> bound;

    [[nodiscard]] TestPicture picture(tracking::Point shift, const Look& look = {}) const;
};

/// disc, small disc (one dot), two arcs of a disc that is higher than the picture (small, and as wide as in
/// the paper), a disc beside another, rectangle, dots, bars, patch, code, code as wide as in the paper; PSF
/// of 0.8 px.
std::vector<TrackingScene> tracking_scenes();
const TrackingScene& tracking_scene(const std::string& name);

/// Frames in, fixes of the first target out.
class Follower {
public:
    explicit Follower(const View& view) : tracker_{view} {}
    tracking::Fix operator()(const Shot& shot) {
        return tracker_.update(shot.view(), CameraTick{tick_++}).front();
    }
    void skip(std::int64_t frames) { tick_ += frames; }

private:
    tracking::ViewTracker tracker_;
    std::int64_t tick_ = 0;
};

}  // namespace shaker::test
