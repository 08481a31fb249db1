#pragma once
// ViewTracker: follows the targets of one view from frame to frame. Fix and Track: position of a target in
// one frame.
#include <array>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "calibration/camera/camera_scale.hpp"
#include "drivers/data.hpp"
#include "drivers/time.hpp"
#include "drivers/view.hpp"

namespace shaker::tracking {

/// reacquired: first good frame after a loss. Found, but in doubt: degraded, partly hidden or blurred;
/// clipped, its bright side saturates; slipped, marks may have been mistaken for their neighbours. repeated:
/// the frame has rows of an earlier one (delivered twice, or torn), nothing in it counts.
enum class TrackState { ok, degraded, lost, reacquired, clipped, slipped, repeated };
/// In their order.
inline constexpr std::array track_words{"ok",      "degraded", "lost",    "reacquired",
                                        "clipped", "slipped",  "repeated"};

/// One target in one frame, px. Pixel centres are at whole numbers. NaN when lost.
struct Fix {
    double x_px = std::numeric_limits<double>::quiet_NaN();
    double y_px = std::numeric_limits<double>::quiet_NaN();
    double sd_px = std::numeric_limits<double>::quiet_NaN();  // standard deviation along the shaker's axis
    TrackState state = TrackState::lost;
};

/// A Fix in metres along the shaker's axis, on master time.
struct Track {
    CameraTick tick;
    MasterTime time;
    Fix fix;
    double x_m = std::numeric_limits<double>::quiet_NaN();
    double sd_m = std::numeric_limits<double>::quiet_NaN();
};

constexpr bool found(TrackState s) noexcept { return s != TrackState::lost && s != TrackState::repeated; }
constexpr bool doubtful(TrackState s) noexcept {
    return s == TrackState::degraded || s == TrackState::clipped || s == TrackState::slipped;
}

/// All targets of one camera. Not thread-safe: one per camera thread. Deterministic: equal frames give equal
/// fixes.
class ViewTracker {
public:
    explicit ViewTracker(const View& view);
    ~ViewTracker();
    ViewTracker(ViewTracker&&) noexcept;
    ViewTracker& operator=(ViewTracker&&) noexcept;
    /// Fixes of all targets in the next frame, in the order of view.targets. The first frame initialises the
    /// targets from their regions and throws InputError that names camera, target and region if one is not
    /// found. In later frames a target that is not found is `lost`. The span is valid until the
    /// next call.
    std::span<const Fix> update(const ImageView& image, CameraTick tick);
    /// The same for a frame that carries sightings: each target is ok where it was seen, or lost. Earlier
    /// frames do not count.
    std::span<const Fix> update(std::span<const Sighting> sightings);
    /// Lengths in the settings that the first picture has corrected, each in a sentence.
    [[nodiscard]] std::vector<std::string> corrections() const;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace shaker::tracking
