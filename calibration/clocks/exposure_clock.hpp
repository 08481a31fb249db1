#pragma once
// When the exposures of one camera were, on the drive's time, from its own stamps and their arrival.
#include <optional>
#include <vector>

#include "calibration/clocks/clock_tracker.hpp"
#include "drivers/data.hpp"
#include "drivers/view.hpp"

namespace shaker::calibration {

/// When an exposure was, by the camera and by the host: what its time is found from when it is not told.
struct FrameStamp {
    CameraTick tick;
    std::optional<CameraStamp> stamp;
    HostTime arrived;
};

/// The camera's clock is mapped to host time by the shortest delays of its frames; a camera without a clock
/// is taken by its count of exposures and its frame rate. A camera that the DAC triggers is then put on the
/// pulse it answers, which is exact: the first frame answers the first pulse, and by how long the stamps lag
/// behind the pulses any later frame finds its own, whatever was lost in between. Stamps that jump (a camera
/// that started anew, a clock that was set) begin a new epoch with a map of its own.
class ExposureClock {
public:
    ExposureClock(const View& view, double dac_rate_hz);
    /// The next frame. Its number is the count of frames before it.
    void add(const FrameStamp& frame);
    /// A frame whose mid-exposure was told with it: it has no number and counts for exposures() only.
    void count(const FrameStamp& frame) { ticks_.add(frame.tick, frame.arrived); }
    /// Frames that were added.
    [[nodiscard]] std::size_t frames() const noexcept { return frames_; }
    /// Middle of the exposure of frame `number`, which has been added, by what is known so far.
    [[nodiscard]] MasterTime mid_exposure(std::size_t number, const FrameStamp& frame,
                                          const ClockMap<DacClock>& dac);
    /// How often the stamps jumped.
    [[nodiscard]] std::size_t jumps() const noexcept { return epochs_.size() - 1; }
    /// The lag behind the pulses is found again, by the maps at the next mid_exposure().
    void forget_lag() noexcept { lag_known_ = false; }
    /// Count of exposures against arrival; nominal rate 1 Hz when the view's is unknown.
    [[nodiscard]] const ClockTracker<CameraClock>& exposures() const noexcept { return ticks_; }
    /// The camera's own clock against arrival, since its last jump.
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
    std::chrono::nanoseconds jump_;  // more than this off the map is a jump
    std::size_t patience_;           // frames that must all be late before it is believed
    std::vector<Epoch> epochs_;
    ClockTracker<CameraClock> ticks_;
    std::optional<FrameStamp> before_;  // the newest frame with a stamp
    bool suspect_ = false;              // the stamps' step was not that of the count
    std::vector<FrameStamp> late_;      // the newest frames since then, all of them later than a jump
    std::vector<FrameStamp> first_;     // frames that the lag is learnt from
    std::size_t frames_ = 0;
    bool lag_known_ = false;
    double lag_samples_ = 0;  // of the stamps behind the pulses
};

}  // namespace shaker::calibration
