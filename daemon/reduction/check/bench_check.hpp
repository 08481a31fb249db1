#pragma once
// Checks of the bench by the motion itself: gain of the cameras over that of the accelerometer, from the
// motion of the base that both see; tilt of the base from gravity, and its share of v_D.
#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "calibration/accelerometer/tumble.hpp"
#include "calibration/estimate.hpp"
#include "calibration/harmonics/harmonic_fit.hpp"

namespace shaker::reduction {

/// The base in one view.
struct SeenBase {
    std::string view;
    calibration::HarmonicFit position;   // m, on master time
    calibration::HarmonicSamples track;  // of that fit
    double exposure_s = 0;
    double scale_error = 0;  // relative standard error of the view's scale, systematic; 0: not known
};

/// One view at one harmonic q. With the base's acceleration A_q by the accelerometer, X_q its position by the
/// view, f the frequency and T the exposure:
///     ratio e^{-i q w delay} = -(q w)^2 X_q / (A_q sin(pi q f T) / (pi q f T))
struct RatioAt {
    int view = 0;  // index of the view
    int q = 0;
    calibration::Estimate ratio;
    calibration::Estimate delay_s;  // of the view behind the accelerometer on master time
};

struct ViewRatio {
    std::string view;
    calibration::Estimate ratio;  // harmonics 1 and 2
    double scale_error = 0;       // as SeenBase
};

/// Errors are standard errors by the noise of both instruments, which is taken as white; the accelerometer's
/// part is common to all views. Harmonics 1 and 2 where they exceed four standard errors in both. Delays of
/// all views have a mean of about 0 where the lag of the accelerometer's clock was fitted to the same motion.
struct GainRatio {
    std::vector<RatioAt> at;
    std::vector<ViewRatio> views;             // those with at least one harmonic
    calibration::Estimate ratio;              // all views; NaN: the base does not move enough
    calibration::Estimate second_over_first;  // ratio at 2w over that at w; free of both gains
    double systematic = NAN;  // relative standard error of `ratio` by scales and gain; NaN: no error is known
    bool alarm = false;       // the verdict: they disagree, in a ratio or in phi
};

/// Phases. A lower corner f_c leads harmonic q by poles atan(f_c / (q f)); a time between the instruments
/// leads it in proportion to q. phi = alpha_2 - 2 alpha_1 shows the first alone.
struct Corner {
    calibration::Estimate hz;  // taken off the result: of each pole as told; not told: of one pole that turns
                               // phi as much; NaN: none, or not known
    calibration::Estimate phi_off;  // rad: phi by the cameras minus that by the accelerometer with the told
                                    // corner; NaN: no check is left
    double phi_told = NAN;  // rad: standard error of phi by that of the told corner, the same in all runs
    bool alarm = false;     // phi_off exceeds four standard errors
    bool unknown = false;   // it was not told, and the cameras do not show it
    bool large = false;     // it moves the amplitude of the first harmonic by more than a tenth
};

/// gain_error: relative standard error of the accelerometer's gain along the axis, systematic; 0: not known.
GainRatio gain_ratio(const calibration::HarmonicFit& acceleration, std::span<const SeenBase> views,
                     double gain_error);

/// Words that notes of an alarm begin with (a tilt is no alarm), that a note on a degraded result contains,
/// and that one on a corner that is not known begins with.
inline constexpr std::string_view alarm_note = "bench check: the ", degraded_note = "the result is degraded",
                                  corner_note = "phi is not corrected for the accelerometer's lower corner";

/// The verdict. An alarm has a note for each view whose ratio differs from 1, and one where the ratios at w
/// and 2w differ, by more than four standard errors. The error of a view's ratio contains the systematic
/// errors that are known.
void note_gain(GainRatio& check, const calibration::HarmonicFit& acceleration,
               std::span<const SeenBase> views, double gain_error, std::vector<std::string>& notes);

/// What a ratio of two scales of acceleration often comes from, as "; a factor of 10 (or 1/10) is often the
/// gain ..."; empty for others.
std::string scale_cause(double ratio);

/// Adds the notes: phi differs, the corner is not known, the corner is large.
void note_corner(const Corner& corner, double frequency_hz, std::vector<std::string>& notes);

/// The accelerometer's fits with the shaker's axis.
struct SensorFits {
    const calibration::HarmonicFit* along = nullptr;          // m/s^2; constant: - g sin(tilt) + offset
    std::array<const calibration::HarmonicFit*, 2> across{};  // on across_axes(axis)
    std::array<double, 3> axis{};                             // unit vector in sensor axes
    bool axis_from_motion = false;                            // else it is exact
    const std::optional<calibration::Tumble>* calibration = nullptr;
};

/// Angle between the shaker's axis and the horizontal, positive: +x points downhill. From the mean
/// acceleration along the axis over that of all axes.
struct Tilt {
    calibration::Estimate angle;  // rad; sigma: noise, axis and calibration; NaN: the offset is not known
    double noise = NAN;           // rad, the part of sigma by noise and axis
    calibration::Estimate v_D;    // m/s, part of v_D that the tilt causes
    double mu = NAN;              // with this friction coefficient
};

/// The angle. NaN when gravity is not in the reading (mean acceleration outside 9 to 10.6 m/s^2).
Tilt tilt_of(const SensorFits& sensor);

/// Friction coefficient by the walker's deceleration in slip: median of -sgn(v - v_base) dv/dt over the
/// phases at which the walker slides, over g. Good to a few percent; NaN without slip. phase: 0..1.
double friction_in_slip(std::span<const double> phase, std::span<const double> v,
                        std::span<const double> v_base, double frequency_hz);

/// Sets the share of v_D: by Coulomb's law with `mu` on the measured base, v_D at this tilt minus v_D on a
/// level base. Its error contains that of the angle and 10 % of the share for the law and mu. Remains NaN
/// where the law misses the measured v_D by more than a tenth of gamma/omega. v_D falls and rises with the
/// tilt at rates that differ by up to three, because a stick appears on one side.
void set_share(Tilt& tilt, const calibration::HarmonicFit& acceleration, double mu, double v_D);

}  // namespace shaker::reduction
