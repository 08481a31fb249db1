#pragma once
// Scale, tilt, distance and lens of a fixed camera from pictures of a board in planes of known height.
#include <array>
#include <span>
#include <string>
#include <vector>

#include "calibration/camera/board_corners.hpp"
#include "calibration/estimate.hpp"
#include "drivers/optics/board.hpp"

namespace shaker::calibration {

/// Direction that becomes `along`: the one of the settings, the board's x, or the line on which the board was
/// moved from picture to picture.
enum class AxisFrom { settings, board, slid };

/// Knowledge before the fit; each error is a standard error. The fit takes them as observations.
struct BoardKnowledge {
    View settings{};                // along, and distance_mm (0: telecentric)
    double distance_error = 0.1;    // of the distance above, relative
    double centre_share = 0.03;     // of the optical axis from the middle of the picture, over its width
    double board_error = 2e-4;      // of the length of the board's squares, relative
    double offset_error_mm = 0.05;  // of each height
    double walker_offset_mm = 0;    // plane in which the scale is wanted too
    AxisFrom axis = AxisFrom::settings;
};

/// A picture and the height of the board's printed face over the reference plane, towards the camera.
struct PlacedBoard {
    SeenBoard seen{};
    double offset_mm = 0;
};

struct CornerResidual {
    std::size_t picture = 0;
    std::array<double, 2> at_px{}, off_px{};  // seen; seen minus fitted
    bool used = true;
};

/// The model: the board lies in the planes of drivers/optics/plane.hpp, with one place and angle a picture.
/// Unknown are scale, distance, tilt, centre and k1, k2 of the lens, the length of the board's squares, each
/// height and each pose; p1 = p2 = 0. Weighted least squares by Levenberg-Marquardt; the noise of the corners
/// is estimated from the residuals, and all errors follow from the covariance of the fit.
///
/// One plane seen from one place fixes the scale in that plane, but not the distance: tilt and distance
/// appear only as their quotient unless the tilt is large. The distance needs pictures at a second height;
/// otherwise it stays that of the settings, and the scale in the walker's plane has its error.
struct PlaneFit {
    View view{};  // mm_per_px, scale_error, distance_mm, along, tilt_deg, lens; focal_px = distance / scale
    double base_error = 0,
           walker_error = 0;  // relative standard errors of the scale; the larger is scale_error
    Estimate distance_mm{}, tilt_x_deg{}, tilt_y_deg{}, k1{}, k2{}, centre_x_px{}, centre_y_px{};
    Estimate axis_deg{};  // of `along` from the board's x in the first picture, towards its y
    bool distance_found = false;
    double rms_px = 0;    // of one coordinate, of the corners used
    double noise_px = 0;  // rms with the degrees of freedom
    int corners = 0, rejected = 0;
    std::array<double, 2> coverage{};  // part of the picture's width and height between the outermost corners
    std::vector<CornerResidual> residuals{};
    std::vector<std::string> findings{};
};

/// InputError names what the pictures do not determine and what to add: fewer than 30 corners, less than half
/// of the picture along the shaker's axis covered, an error of the scale above 0.5 %, a lens that maps no ray
/// to a corner of the picture.
PlaneFit fit_plane(std::span<const PlacedBoard> pictures, const optics::Board& board,
                   const BoardKnowledge& known);

/// Metres per px along the axis in a plane, mean over the middle 80 % of a picture.
double mean_scale(const View& view, double offset_mm, int width, int height);

}  // namespace shaker::calibration
