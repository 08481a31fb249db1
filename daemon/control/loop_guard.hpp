#pragma once
// What a window of whole periods shows to be wrong: the slow half of the safety, in the control thread. The
// fast half looks at every sample (sample_guard.hpp).
#include <array>
#include <complex>
#include <optional>

#include "daemon/control/equaliser.hpp"
#include "daemon/control/harmonic_estimator.hpp"
#include "daemon/control/identification.hpp"
#include "daemon/control/limits.hpp"
#include "daemon/control/trip.hpp"

namespace shaker {

/// A window beside what is known of the plant.
struct JudgedWindow {
    const PeriodEstimate& estimate;
    const MotionWindow& motion;
    std::array<std::complex<double>, max_harmonics>
        response{};                    // m/s^2 a volt, as identified or by the sheet
    Harmonics<Acceleration> target{};  // 0 where none is gone for yet
    Equaliser::Report report{};
    double noise = 0;       // m/s^2, of an amplitude's part in a window with the drive off
    std::int64_t tick = 0;  // DAC sample at the window's end
    bool followed = false;  // the equaliser has had a part in it
};

class LoopGuard {
public:
    explicit LoopGuard(const Limits& limits) : limits_{limits} {}
    /// Other levels from now on.
    void hold_to(const Limits& limits) noexcept { limits_ = limits; }

    /// In this order: no numbers; next to none of the motion that the drive must make (an open sensor, a
    /// loose cable; a frozen sensor when there is no noise either); motion across the axis; more drive than
    /// four times what the response asks for; a loop that failed or, once it was near its target, is away by
    /// half of it; a harmonic of a tenth of the target or more that is 3 dB off in two windows in a row.
    /// Warnings are counted.
    std::optional<Trip> check(const JudgedWindow& window, Warnings& warnings);
    /// Of what was found out: an open sensor, a gain four times off or a polarity against the data sheet's.
    /// `axis_known`: else the sign of the sensor's axis is not known either. At the end too little motion a
    /// drive is wrong as well; on the way the base may still stick.
    std::optional<Trip> check(const IdentifiedResponse& response, bool axis_known, bool ended,
                              std::int64_t tick) const;
    /// A new target, or a drive that comes up: nothing is judged against it until the loop is near it.
    void settling() noexcept { near_ = false, off_ = 0; }

private:
    [[nodiscard]] bool on(Cause cause) const { return limits_.detectors[static_cast<std::size_t>(cause)]; }
    std::optional<Trip> judge_target(const JudgedWindow& window, Warnings& warnings);

    Limits limits_;
    bool near_ = false;
    int off_ = 0;  // windows in a row with a harmonic out of its band
};

}  // namespace shaker
