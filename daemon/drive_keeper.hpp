#pragma once
// From measured windows to the drive: noise, identification, then the equaliser, for live set-points too.
#include <functional>
#include <memory>
#include <optional>

#include "daemon/control/equaliser.hpp"
#include "daemon/control/identification.hpp"
#include "daemon/motion_windows.hpp"

namespace shaker {

struct KeeperSettings {
    Drive drive;
    double volts_limit = 1;
    bool identify = true;  // false: the data sheet is taken for the response
    bool equalise = true;  // false: the drive stays what the response makes of the target
    std::function<std::complex<double>(double)> sheet;  // response at a frequency, m/s^2 a volt
};

class DriveKeeper {
public:
    explicit DriveKeeper(const KeeperSettings& settings);

    /// A window without a drive: tells the noise.
    void quiet(const PeriodEstimate& window);

    /// Begins to find out the response; false when it is not to be found out.
    bool begin_identification();
    /// Takes a response that was found out before instead.
    void adopt(const IdentifiedResponse& response) { identified_ = response; }
    /// Another target for begin() to go for, of any frequency.
    void aim(const Drive& drive) { settings_.drive = drive; }
    /// Whether what is measured corrects the drive from the next begin() on.
    void close_loop(bool on) noexcept { settings_.equalise = on; }
    /// The response is to be found out anew.
    void forget() noexcept { identified_.reset(); }
    /// Begins to go for the target.
    void begin();
    /// What to play now.
    [[nodiscard]] const Harmonics<Voltage>& volts() const noexcept { return volts_; }

    enum class Outcome { nothing, step, correction, identified };
    /// A window; `newest`: the command posted last was in force in it. step: volts() changed by what must
    /// settle before anything is measured; correction: by a little; identified: begin() may follow.
    Outcome take(const MotionWindows::Window& window, bool newest);
    /// A new set-point, of any frequency; begin() before.
    void set(const Drive& drive);

    [[nodiscard]] const Drive& drive() const noexcept { return settings_.drive; }
    [[nodiscard]] const std::optional<IdentifiedResponse>& identified() const noexcept { return identified_; }
    /// What the levels so far have found out, while it is being found out; else null.
    [[nodiscard]] const IdentifiedResponse* found() const noexcept {
        return identification_ ? &identification_->response() : nullptr;
    }
    /// Of the last window; default before the first.
    [[nodiscard]] const Equaliser::Report& report() const noexcept { return report_; }
    /// m/s^2, sd of an amplitude's part in one window with the drive off; 0: not known.
    [[nodiscard]] double noise() const noexcept { return noise_; }
    /// The response at q f as it is known now.
    [[nodiscard]] std::array<std::complex<double>, max_harmonics> response_at(double frequency) const;

private:
    KeeperSettings settings_;
    double noise_ = 0;
    int quiet_windows_ = 0;
    Harmonics<Voltage> volts_;
    std::unique_ptr<Identification> identification_;
    std::optional<IdentifiedResponse> identified_;
    std::unique_ptr<Equaliser> equaliser_;
    Equaliser::Report report_;
};

inline constexpr int controlled_harmonics = 8;
static_assert(controlled_harmonics >= most_driven);

}  // namespace shaker
