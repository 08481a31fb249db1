#pragma once
// PlayedDrive: regenerates the samples that a run sent to its DAC from the recorded changes of the drive.
#include <span>
#include <vector>

#include "drivers/data.hpp"
#include "drivers/devices.hpp"
#include "drivers/synthesiser.hpp"

namespace shaker::recorded {

/// Equal to the bit to the played samples, unless samples were cut at a limit below the DAC's full scale
/// (such a run is stopped). During underruns the output was zero.
class PlayedDrive {
public:
    /// frequency_hz: of the initial silent drive. InputError when there was no DAC.
    PlayedDrive(const DacInfo& dac, double frequency_hz, std::vector<DriveChange> changes,
                const std::vector<PlayTime>& played);
    /// The next samples, in volts, starting at DAC sample 0. InputError when the Synthesiser could not have
    /// made a recorded change at that sample.
    void fill(std::span<double> volts);

private:
    /// At the sample that is due; `lost` samples of silence belong to the change.
    void apply(const DriveChange& change, std::int64_t lost);
    void require_made(const DriveChange& change) const;

    Synthesiser synthesiser_;
    std::vector<DriveChange> changes_;
    std::vector<std::int64_t> lost_;  // samples, for each underrun
    std::size_t next_ = 0, next_lost_ = 0;
    std::int64_t silent_ = 0;  // samples of silence left
    bool due_ = false;         // the change before `next_` takes effect with the next sample
};

}  // namespace shaker::recorded
