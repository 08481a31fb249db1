#pragma once
// Follows the targets of one view from frame to frame.
#include <memory>
#include <span>
#include <vector>

#include "calibration/camera_scale.hpp"
#include "drivers/data.hpp"
#include "drivers/view.hpp"
#include "tracking/track.hpp"

namespace shaker {

/// All targets of one camera. Not thread-safe; one per camera thread. Deterministic: same frames, same fixes.
class ViewTracker {
public:
    explicit ViewTracker(const View& view);
    ~ViewTracker();
    ViewTracker(ViewTracker&&) noexcept;
    ViewTracker& operator=(ViewTracker&&) noexcept;
    /// Positions of all targets (in the order of view.targets) in the next frame. The first frame initialises
    /// the targets from their regions and throws InputError naming camera, target and region when one is not
    /// there; later a target that is not found is `lost`. The span is valid until the next call.
    std::span<const Fix> update(const ImageView& image, CameraTick tick);

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace shaker
