#pragma once
// What there is to see in a camera's view, as a scene or a session file describes it.
#include <array>
#include <string>
#include <vector>

namespace shaker {

enum class TargetKind { disc, rectangle, dots, bars, patch };
enum class Polarity { bright, dark };

/// One thing to follow in a view. Lengths in mm in the object's own plane.
struct Target {
    std::string name;  // "walker", "base", or any name
    TargetKind kind = TargetKind::disc;
    double diameter_mm = 0;       // disc, dots
    double width_mm = 0;          // rectangle
    double pitch_mm = 0;          // bars; dots when there are several
    std::array<int, 4> roi_px{};  // x, y, width, height in frame 0; the target is in it there
    double offset_mm = 0;         // towards the camera from the reference plane
    Polarity polarity = Polarity::bright;
};

/// Geometry of one camera's picture and what is in it.
struct View {
    std::string camera;                 // "top", "side"
    double mm_per_px = 0;               // in the reference plane
    double distance_mm = 0;             // camera to reference plane; 0 = telecentric
    std::array<double, 2> along{1, 0};  // image direction of +x, the shaker's axis; unit length
    double frame_rate_hz = 0;
    double exposure_s = 0;
    /// Exposures start at the pulses of the DAC's second channel, this long after them. Otherwise the camera
    /// runs by its own clock, and `arrival_delay_s` is the least time from the start of an exposure until the
    /// host has heard of it.
    bool dac_triggered = false;
    double trigger_delay_s = 0;
    double arrival_delay_s = 0;
    std::vector<Target> targets;
    std::array<int, 2> origin_px{};  // of its pictures on the sensor, when they are part of what that sees
};

}  // namespace shaker
