#pragma once
// The true view of a simulated camera, where it differs from the view in its settings; and the report of a
// camera that gives positions: true places on its picture, with noise.
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "drivers/data.hpp"
#include "drivers/optics/board.hpp"
#include "drivers/simulated/renderer.hpp"
#include "drivers/simulated/scene.hpp"

namespace shaker::simulated {

/// The view with the true scale, distance, direction, tilt and lens of the scene. The optical axis meets the
/// middle of the picture. Equal to the told view if the scene has none of these.
View true_view(const CameraTruth& camera);

/// Image of a point of a plane that appears at (centre_x, row) when its position is 0.
optics::Point seen_at(const View& truth, double offset_mm, double position_m, double centre_x, double row,
                      double px_per_m) noexcept;

/// A board that lies on the base in one place after the other, and is moved in the first quarter of each.
class ShownBoards {
public:
    explicit ShownBoards(const CameraTruth& camera);
    [[nodiscard]] bool any() const noexcept { return !poses_.empty(); }
    /// Pose at true time t; the last one stays.
    [[nodiscard]] optics::BoardPose at(double t) const noexcept;

private:
    double each_s_;
    std::vector<optics::BoardPose> poses_;
};

/// Poses of a text: four numbers each, the place of the board's middle from the picture's middle (a, b, mm),
/// its turn in degrees and the height of its face in mm. Empty also when the text is not such numbers.
std::vector<std::array<double, 4>> board_places(const std::string& text);

/// Standard deviation of a reported position, px: that of the tracker on the paper's bench, rounded up.
inline constexpr double sighting_sd_px = 0.01;

/// Sightings of the targets of `camera`, in their order: means over `poses`, which sample the exposure. NaN
/// for the walker when it is not visible, or when its middle is outside the picture. Deterministic: the noise
/// depends only on seed, tick and target.
std::vector<Sighting> sightings(const CameraTruth& camera, const PictureLayout& layout,
                                std::span<const Pose> poses, CameraTick tick, bool walker,
                                std::uint64_t seed);

}  // namespace shaker::simulated
