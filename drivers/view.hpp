#pragma once
// Geometry and targets of a camera's view, from a scene or a session file.
#include <array>
#include <string>
#include <string_view>
#include <vector>

namespace shaker {

enum class TargetKind { disc, rectangle, dots, bars, patch, code };
/// Their words in settings.
inline constexpr std::array<std::string_view, 6> target_kinds{"disc", "rectangle", "dots",
                                                              "bars", "patch",     "code"};
inline std::string_view word(TargetKind kind) { return target_kinds.at(static_cast<std::size_t>(kind)); }
enum class Polarity { bright, dark };

/// One object to track in a view. Lengths in mm in the object's own plane.
struct Target {
    std::string name;  // "walker", "base", or any name
    TargetKind kind = TargetKind::disc;
    double diameter_mm = 0;       // disc, dots
    double width_mm = 0;          // rectangle
    double pitch_mm = 0;          // bars, and dots in a row; 0: single dot
    std::array<int, 4> roi_px{};  // x, y, width, height in frame 0; contains the target in that frame
    double offset_mm = 0;         // distance from the reference plane, positive towards the camera
    Polarity polarity = Polarity::bright;
};

/// Distortion of a lens as OpenCV defines it: with x, y from the centre in units of focal_px and r^2 = x^2 +
/// y^2, x_picture = x (1 + k1 r^2 + k2 r^4) + 2 p1 x y + p2 (r^2 + 2 x^2), and with p1 and p2 exchanged for
/// y.
struct Lens {
    std::array<double, 2> centre_px{};  // foot of the optical axis on the sensor
    double focal_px = 0;                // unit of x and y; 0: no lens told, no distortion and no tilt
    double k1 = 0, k2 = 0;              // radial
    double p1 = 0, p2 = 0;              // tangential
    bool operator==(const Lens&) const = default;
    [[nodiscard]] std::array<double, 2> distorted(double x, double y) const noexcept {
        const double r2 = x * x + y * y, radial = 1 + r2 * (k1 + r2 * k2);
        return {x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
                y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y};
    }
};

/// Geometry and targets of one camera.
struct View {
    std::string camera;      // "top", "side"
    double mm_per_px = 0;    // in the reference plane; with a lens: square to its axis, at its centre
    double scale_error = 0;  // relative standard error of mm_per_px, systematic; 0: not told
    double distance_mm = 0;  // camera to reference plane; 0 = telecentric
    std::array<double, 2> along{1, 0};  // image direction of +x, the shaker's axis; unit length
    Lens lens{};
    std::array<double, 2> tilt_deg{};  // reference plane: its distance grows with image x (y) by the tangent
    std::string calibration{};         // text of the calibration file; empty: none
    double frame_rate_hz = 0;
    double exposure_s = 0;
    /// True: exposures start trigger_delay_s after the pulses on the DAC's second channel. False: the
    /// camera runs on its own clock, and `arrival_delay_s` is the shortest time from the start of an
    /// exposure to its arrival at the host.
    bool dac_triggered = false;
    double trigger_delay_s = 0;
    double arrival_delay_s = 0;
    std::vector<Target> targets;
    std::array<int, 2> origin_px{};  // position of the picture on the sensor if it is cropped; else 0, 0
    bool positions = false;          // frames carry sightings of the targets instead of pixels
};

}  // namespace shaker
