#pragma once
// Master times of one camera's exposures, from the camera's stamps and the arrival of its frames.
#include <optional>
#include <vector>

#include "calibration/clocks/clock_tracker.hpp"
#include "drivers/data.hpp"
#include "drivers/view.hpp"

namespace shaker::calibration {

/// The stamps of a frame, from which the time of its exposure is computed if the frame does not carry it.
struct FrameStamp {
    CameraTick tick;
    std::optional<CameraStamp> stamp;
    HostTime arrived;
};

/// The camera's clock is mapped to host time by the shortest delays of its frames. A camera without a clock
/// is mapped by its count of exposures and its frame rate.
///
/// A camera that the DAC triggers gets the exact time of its trigger pulse: with s the DAC sample of a frame
/// by the maps, L the lag of frames behind pulses (median over the first frames, of which frame k answers
/// pulse k), f_s the DAC's rate and r the frame rate, the frame answers pulse round((s - L) r / f_s). Lost
/// frames do not matter.
///
/// Stamps that jump (a restarted camera, an adjusted clock) start a new epoch with its own map.
class ExposureClock {
public:
    ExposureClock(const View& view, double dac_rate_hz);
    /// Adds the next frame. Its number is the count of frames added before it.
    void add(const FrameStamp& frame);
    /// Adds a frame that carries its mid-exposure: it has no number and is used for exposures() only.
    void count(const FrameStamp& frame) { ticks_.add(frame.tick, frame.arrived); }
    /// Number of added frames.
    [[nodiscard]] std::size_t frames() const noexcept { return frames_; }
    /// Middle of the exposure of the added frame `number`, by the present maps.
    [[nodiscard]] MasterTime mid_exposure(std::size_t number, const FrameStamp& frame,
                                          const ClockMap<DacClock>& dac);
    /// Number of jumps of the stamps.
    [[nodiscard]] std::size_t jumps() const noexcept { return epochs_.size() - 1; }
    /// The next mid_exposure() determines the lag behind the pulses again, from the maps at that time.
    void forget_lag() noexcept { lag_known_ = false; }
    /// Clock of the count of exposures; nominal rate 1 Hz when the view's rate is unknown.
    [[nodiscard]] const ClockTracker<CameraClock>& exposures() const noexcept { return ticks_; }
    /// The camera's own clock since its last jump.
    [[nodiscard]] const ClockTracker<CameraStampClock>& stamps() const noexcept {
        return epochs_.back().stamps;
    }

private:
    struct Epoch {
        std::size_t first;  // number of its first frame
        ClockTracker<CameraStampClock> stamps;
    };
    void begin_epoch(std::size_t first);
    void add_stamp(const FrameStamp& frame);
    void forget_suspicion();
    [[nodiscard]] double start_sample(std::size_t number, const FrameStamp& frame,
                                      const ClockMap<DacClock>& dac) const;
    void learn_lag(const ClockMap<DacClock>& dac);

    View view_;
    double dac_rate_hz_;
    std::chrono::nanoseconds jump_;  // deviation from the map above which stamps have jumped
    std::size_t patience_;           // consecutive late frames needed as evidence of a jump
    std::vector<Epoch> epochs_;
    ClockTracker<CameraClock> ticks_;
    std::optional<FrameStamp> before_;  // the newest frame with a stamp
    bool suspect_ = false;              // a step of the stamps did not agree with the count of exposures
    std::vector<FrameStamp> late_;      // newest frames since then, each late by more than jump_
    std::vector<FrameStamp> first_;     // frames from which the lag is determined
    std::size_t frames_ = 0;
    bool lag_known_ = false;
    double lag_samples_ = 0;  // lag of the stamps behind the pulses, DAC samples
};

}  // namespace shaker::calibration
