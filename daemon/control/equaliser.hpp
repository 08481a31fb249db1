#pragma once
// Equaliser: corrects the harmonics of the drive voltage until the measured harmonics of the base match
// the target. Far from the target it steps and learns the plant; near it, it follows every window.
#include <array>
#include <complex>
#include <deque>
#include <optional>
#include <vector>

#include "daemon/control/held_drive.hpp"
#include "daemon/control/plant_matrix.hpp"
#include "drivers/drive.hpp"

namespace shaker::control {

/// "Locked": the error of each harmonic is at most this share of its target, or of gamma if it has no
/// target.
inline constexpr double kept_within = 1e-3;

struct EqualiserSettings {
    int harmonics = 8;  // K, 1..16: these are corrected; the target is 0 for harmonics it does not contain
    double volts_limit = 1;  // V, largest peak of the planned waveform
    double noise = 0;        // m/s^2, sd of one part of an amplitude in a window with the drive off; 0: each
                             // window's own sd is used
    std::vector<double> levels{0.4, 0.7, 0.9, 1};  // shares of the target, increasing, on the way up
    double pace = 0.1;                             // share of the error corrected per window near the target
    bool from_below = true;                        // false: start at the last level
    std::vector<int> hidden{};  // harmonics that others hide: without a target they are not corrected
};

/// One window: measured motion and drive.
struct PeriodWindow {
    Harmonics<Acceleration> measured;
    double sd = 0;             // m/s^2, of one part of an amplitude
    Harmonics<Voltage> volts;  // mean over the window
    bool steady = false;       // the newest drive was in force and unchanged during the whole window
};

/// Error of a window: E_q = R_q e^{i q tau} - Y_q for q = 1..K, with Y the measured and R the target
/// harmonics (m/s^2, convention of Harmonics) and tau (rad of harmonic 1) the common delay that minimises
/// sum_q |Y_q - R_q e^{i q tau}|^2: only the shape is controlled, a common delay of all harmonics
/// (sensor, clocks) is the same motion later.
///
/// Plant: dY = P dV, P real 2K x 2K (PlantMatrix). Converging: V += share * P^+ E after each settled
/// change, at levels of the target; each step updates P (Broyden). Tracking: V = (1 - mu) V + mu
/// (V_window + P^+ E) + D every window: the error belongs to the drive of its window, so corrections still
/// under way are not made twice. mu = 1/n in the n-th window, the mean of all windows so far, but between
/// pace (half of it when noise dominates) and 1/4. D: integral of 0.2 pace^2 P^+ E. Held, on request and
/// while locked: V becomes the mean of V_window + P^+ E of up to 100 windows, and stays until its mean error
/// stands out of the noise (HeldDrive).
///
/// Limit: if the peak of V exceeds volts_limit, V and R are scaled together: the shape stays, gamma falls
/// and is reported.
class Equaliser {
public:
    enum class Mode { converge, track, failed };
    struct Report {
        Mode mode = Mode::converge;
        std::array<double, max_harmonics>
            residual{};       // |mean error of ten windows| / gamma, for each harmonic
        double error = 1;     // |E| / |R| of this window, norms over K harmonics
        double level = 0;     // present target / requested gamma
        double reached = 1;   // largest reachable target / requested gamma; below 1 if the voltage limit or
                              // the plant prevents more
        double noise = 0;     // sd of one part of a window's amplitude / gamma
        int held = 0;         // windows in a row that changed nothing, because the drive is held
        bool locked = false;  // mean of ten windows: each harmonic within 0.1 % of gamma, those of the target
                              // within 0.1 % of themselves, or within three sd of the mean
        bool noise_limited = false;  // three sd of the mean exceed those 0.1 %
        bool no_motion = false;      // the base hardly moves for this drive: the drive was not changed
        /// The plant gave no more motion; the drive returned to the last that worked.
        bool unreachable = false;
        std::complex<double> gain = 1;  // common gain relative to the first response, as learned
    };

    /// response: m/s^2 per V at f, 2f, ... InputError unless finite and non-zero up to K.
    Equaliser(const Harmonics<Acceleration>& target,
              const std::array<std::complex<double>, max_harmonics>& response,
              const EqualiserSettings& settings = {});

    /// Voltage to play now.
    [[nodiscard]] const Harmonics<Voltage>& volts() const noexcept { return volts_; }
    /// Processes the next window and may change volts(). A window that is not finite, or that shows
    /// less than 5 % of the motion expected of its drive, changes nothing: the drive never rises on
    /// missing data.
    Report take(const PeriodWindow& window);
    /// Sets a new target at the same frequency. The drive changes at once by the learned plant, then
    /// corrects. known: the drive that was locked at this target before; it is used and held if the plant
    /// predicts it within 10 %.
    void retarget(const Harmonics<Acceleration>& target, const Harmonics<Voltage>* known = nullptr);
    /// Holds the drive until the next target, while it is locked.
    void hold() noexcept { hold_ = true; }
    /// New voltage limit, V; volts() changes at once if its peak is above.
    void limit(double volts);

private:
    struct Block {  // mean of windows at one drive
        Harmonics<Voltage> volts;
        Harmonics<Acceleration> measured;
    };
    struct Good {  // the last drive that worked
        Harmonics<Voltage> volts;
        PlantMatrix plant;
        double level;
    };
    [[nodiscard]] Harmonics<Acceleration> aim() const;  // target at the present level
    [[nodiscard]] Harmonics<Acceleration> error_of(const Harmonics<Acceleration>& measured) const;
    [[nodiscard]] bool moves(const PeriodWindow& window, double noise) const;
    void converge(const PeriodWindow& window, double noise);
    void measure_delay(const Block& block, double noise);
    void step(const Block& block, double noise);
    [[nodiscard]] bool does_harm(double size);
    void learn(const Harmonics<Voltage>& stepped, Harmonics<Acceleration> moved, double noise);
    void track(const PeriodWindow& window, const Harmonics<Acceleration>& error, double noise,
               Report& report);
    void follow(const PeriodWindow& window, double noise);
    void judge(const Harmonics<Acceleration>& error, double noise, Report& report);
    void enter_converge();
    void fall_back();
    void keep_within_limit();

    EqualiserSettings settings_;
    Harmonics<Acceleration> target_;
    double gamma_ = 0;           // m/s^2, sum of the target's amplitudes
    PlantMatrix plant_, first_;  // as learned, and as identified
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
    int worse_ = 0;  // consecutive steps that increased the error
    double share_ = 1, last_error_ = INFINITY;
    bool delay_measured_ = false;
    // Following and holding.
    Harmonics<Voltage> drift_, mean_;                               // mean: of V_window + P^+ E
    int followed_ = 0, averaged_ = 0, held_windows_ = 0, far_ = 0;  // windows; averaged_: in mean_
    bool hold_ = false, holds_ = false, known_ = false;  // the drive was locked at this target before
    HeldDrive held_;
    std::deque<Harmonics<Acceleration>> errors_;  // of the last ten windows at most
};

/// Largest |value| over a period, V: evaluated at 512 points, refined by a parabola.
double peak(const Harmonics<Voltage>& volts);

/// tau in rad of harmonic 1 that minimises sum_q |measured_q - wanted_q e^{i q tau}|^2.
double best_lag(const Harmonics<Acceleration>& wanted, const Harmonics<Acceleration>& measured);

/// a[q] e^{i q lag}: the harmonics of the same motion with all phases advanced by `lag` rad of harmonic
/// 1.
Harmonics<Acceleration> turned(const Harmonics<Acceleration>& h, double lag);

}  // namespace shaker::control
