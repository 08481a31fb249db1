#pragma once
// What a simulated camera really sees, where that differs from what its view tells.
#include <string>
#include <vector>

#include "drivers/optics/board_picture.hpp"
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

}  // namespace shaker::simulated
