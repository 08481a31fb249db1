#pragma once
// DriveController: from measured windows to the drive voltage. Noise, identification, equaliser, live
// set-points.
#include <functional>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "daemon/control/equaliser.hpp"
#include "daemon/control/identification.hpp"
#include "daemon/control/period_windows.hpp"

namespace shaker::control {

struct ControllerSettings {
    Drive drive;
    double volts_limit = 1;
    bool identify = true;  // false: the data sheet's response is used
    bool equalise = true;  // false: the drive stays at target / response
    std::function<std::complex<double>(double)>
        sheet;  // response of the data sheet, m/s^2 per V at a frequency in Hz
};

class DriveController {
public:
    explicit DriveController(const ControllerSettings& settings);

    /// A window without drive: measures the noise.
    void quiet(const PeriodEstimate& window);
    /// Discards the measured noise; quiet() measures it again.
    void forget_noise() noexcept { noise_ = 0, quiet_windows_ = 0; }

    /// Starts identification; false when `identify` or `equalise` is off.
    bool begin_identification();
    /// Uses a response that was identified earlier.
    void adopt(const IdentifiedResponse& response) { identified_ = response; }
    /// Sets the target of the next begin(), at any frequency.
    void aim(const Drive& drive) { settings_.drive = drive; }
    /// Switches the correction by measured windows on or off, from the next begin() on.
    void close_loop(bool on) noexcept { settings_.equalise = on; }
    /// Lines of the mains in the sensor, Hz: harmonics that lie on one and have no target are not corrected,
    /// from the next begin() or set() at another frequency on.
    void hide(std::vector<double> lines_hz) { lines_hz_ = std::move(lines_hz); }
    [[nodiscard]] bool hums() const noexcept { return !lines_hz_.empty(); }
    /// Harmonics of a frequency (Hz) that lie on one of these lines, in the order of q.
    [[nodiscard]] std::vector<int> hidden(double frequency) const;
    /// New voltage limit, from the next window on; an identification keeps the limit with which it began.
    void limit(double volts) noexcept;
    /// Discards the identified response; the data sheet is used until the next identification.
    void forget() noexcept { identified_.reset(); }
    /// Starts the drive towards the target.
    void begin();
    /// Voltage to play now.
    [[nodiscard]] const Harmonics<Voltage>& volts() const noexcept { return volts_; }

    enum class Outcome { nothing, step, correction, identified };
    /// Processes a window. `newest`: the last posted command was in force during it. Returns step:
    /// volts() changed so much that it must settle before a measurement; correction: volts() changed
    /// slightly; identified: identification has ended, begin() may follow.
    Outcome take(const PeriodWindows::Window& window, bool newest);
    /// A new set-point, at any frequency. Requires begin(). At a set-point that was locked since begin(), or
    /// whose mirror partner was, that drive is used again.
    void set(const Drive& drive);
    /// For a measurement: a locked drive is held until the next set-point (Equaliser::hold).
    void hold() noexcept {
        if (equaliser_) equaliser_->hold();
    }

    [[nodiscard]] const Drive& drive() const noexcept { return settings_.drive; }
    [[nodiscard]] const std::optional<IdentifiedResponse>& identified() const noexcept { return identified_; }
    /// Levels identified so far, during identification; else null.
    [[nodiscard]] const IdentifiedResponse* found() const noexcept {
        return identification_ ? &identification_->response() : nullptr;
    }
    /// Report for the last window; default before the first.
    [[nodiscard]] const Equaliser::Report& report() const noexcept { return report_; }
    /// m/s^2, sd of one part of an amplitude in a window with the drive off; 0: unknown.
    [[nodiscard]] double noise() const noexcept { return noise_; }
    /// The present estimate of the response at q * frequency, m/s^2 per V.
    [[nodiscard]] std::array<std::complex<double>, max_harmonics> response_at(double frequency) const;

private:
    ControllerSettings settings_;
    double noise_ = 0;
    int quiet_windows_ = 0;
    Harmonics<Voltage> volts_;
    std::unique_ptr<Identification> identification_;
    std::optional<IdentifiedResponse> identified_;
    std::unique_ptr<Equaliser> equaliser_;
    Equaliser::Report report_;
    struct Known {
        Harmonics<Acceleration> target;
        Harmonics<Voltage> volts;
    };
    void remember(const Known& locked);
    /// Null: not known.
    [[nodiscard]] const Harmonics<Voltage>* known_drive(const Harmonics<Acceleration>& target) const;
    [[nodiscard]] EqualiserSettings equaliser_settings(bool from_below) const;
    std::vector<Known> known_;  // locked drives of this equaliser and their mirror images, the newest last
    std::vector<double> lines_hz_;
};

inline constexpr int controlled_harmonics = 8;
static_assert(controlled_harmonics >= most_driven);

}  // namespace shaker::control
