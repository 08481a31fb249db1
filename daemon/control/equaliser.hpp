#pragma once
// Closes the drive loop: measured harmonics of the base correct the harmonics of the voltage. Far from the
// target it steps and learns how the plant answers; near it, it follows every window.
#include <array>
#include <complex>
#include <deque>
#include <optional>
#include <vector>

#include "daemon/control/plant_matrix.hpp"
#include "drivers/drive.hpp"

namespace shaker {

/// What "locked" means: each harmonic is this share of what is asked of it, or of gamma, off at most.
inline constexpr double kept_within = 1e-3;

struct EqualiserSettings {
    int harmonics = 8;       // K, 1..16: these are corrected, those the target does not have towards zero
    double volts_limit = 1;  // peak of the planned waveform
    double noise = 0;        // m/s^2, sd of an amplitude's part in one window with the drive off; 0: as each
                             // window says of itself
    std::vector<double> levels{0.4, 0.7, 0.9, 1};  // of the target, on the way up
    double pace = 0.1;                             // share of the error taken away each window once near
    bool from_below = true;                        // false: begin at the last level
};

/// One window as the sensor saw it, and what was played meanwhile.
struct MotionWindow {
    Harmonics<Acceleration> measured;
    double sd = 0;             // of an amplitude's part
    Harmonics<Voltage> volts;  // mean over the window
    bool steady = false;       // the newest drive was in force, unchanged, all through it
};

/// Only the shape is controlled: a common delay of all harmonics (the sensor's, the clocks') is the same
/// motion somewhat later, so the target is turned to the time at which it fits best.
class Equaliser {
public:
    enum class Mode { converge, track, failed };
    struct Report {
        Mode mode = Mode::converge;
        std::array<double, max_harmonics> residual{};  // |mean error of ten windows| / gamma, a harmonic
        double error = 1;     // of this window: norm over K harmonics, of the target's
        double level = 0;     // share of the asked gamma that is gone for at present
        double reached = 1;   // share of the asked gamma that the limit, or the plant, lets through
        double noise = 0;     // sd / gamma of a window's amplitude part
        bool locked = false;  // ten windows: each harmonic within 0.1 % of gamma, and those of the target
                              // within 0.1 % of themselves, or within three times their own noise
        bool noise_limited = false;     // that noise is above those 0.1 %
        bool no_motion = false;         // the base hardly moves for this drive: nothing was changed
        bool unreachable = false;       // the plant gave no more; the drive went back to what worked
        std::complex<double> gain = 1;  // common gain against the first response, as found out on the way
    };

    /// response: m/s^2 a volt at f, 2f, ...; InputError unless finite and not zero up to K.
    Equaliser(const Harmonics<Acceleration>& target,
              const std::array<std::complex<double>, max_harmonics>& response,
              const EqualiserSettings& settings = {});

    /// The drive to play now.
    [[nodiscard]] const Harmonics<Voltage>& volts() const noexcept { return volts_; }
    /// Takes the next window and perhaps changes volts(). One that is not finite, or that shows hardly any of
    /// the motion that its drive must make, changes nothing: the drive is never raised on missing data.
    Report take(const MotionWindow& window);
    /// A new target at the same frequency: the drive goes there at once as far as is known, then corrects.
    void retarget(const Harmonics<Acceleration>& target);

private:
    struct Block {  // windows of one drive
        Harmonics<Voltage> volts;
        Harmonics<Acceleration> measured;
    };
    struct Good {  // what worked
        Harmonics<Voltage> volts;
        PlantMatrix plant;
        double level;
    };
    [[nodiscard]] Harmonics<Acceleration> aim() const;  // the target at the present level
    [[nodiscard]] Harmonics<Acceleration> error_of(const Harmonics<Acceleration>& measured) const;
    [[nodiscard]] bool moves(const MotionWindow& window, double noise) const;
    void converge(const MotionWindow& window, double noise);
    void step(const Block& block, double noise);
    [[nodiscard]] bool does_harm(double size);
    void learn(const Harmonics<Voltage>& stepped, const Harmonics<Acceleration>& moved, double noise);
    void follow(const MotionWindow& window, double noise);
    void judge(const Harmonics<Acceleration>& error, double noise, Report& report);
    void enter_converge();
    void fall_back();
    void keep_within_limit();

    EqualiserSettings settings_;
    Harmonics<Acceleration> target_;
    double gamma_ = 0;           // sum of the target's amplitudes
    PlantMatrix plant_, first_;  // as it is known now, and as it was identified
    Harmonics<Voltage> volts_;
    Mode mode_ = Mode::converge;
    std::size_t level_ = 0;
    double limit_V_;
    double reached_ = 1;
    bool unreachable_ = false;
    std::complex<double> gain_ = 1;
    std::optional<Good> good_;
    // Converging.
    std::optional<Block> last_;
    Harmonics<Voltage> before_step_;
    std::optional<Harmonics<Acceleration>> before_;
    Harmonics<Acceleration> sum_;
    int waited_ = 0, summed_ = 0, blocks_ = 0;
    int worse_ = 0;  // steps in a row after which the error was larger
    double share_ = 1, last_error_ = INFINITY;
    // Following.
    Harmonics<Voltage> drift_;
    int far_ = 0;
    std::deque<Harmonics<Acceleration>> errors_;  // of the last ten windows
};

/// Largest |value| of a period, evaluated at 512 points and refined by a parabola.
double peak(const Harmonics<Voltage>& volts);

/// The time (rad of harmonic 1) by which `wanted` must be turned to come nearest to `measured`.
double best_lag(const Harmonics<Acceleration>& wanted, const Harmonics<Acceleration>& measured);

/// The same motion, later by `lag` rad of harmonic 1... as the sensor sees it: a[q] e^{i q lag}.
Harmonics<Acceleration> turned(const Harmonics<Acceleration>& h, double lag);

}  // namespace shaker
