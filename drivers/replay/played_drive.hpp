#pragma once
// The samples that a run gave to its DAC, made again from the recorded changes of the drive.
#include <span>
#include <vector>

#include "drivers/data.hpp"
#include "drivers/devices.hpp"
#include "drivers/synthesiser.hpp"

namespace shaker {

/// Equal to the bit to what was played, as long as no sample was cut at a limit below the DAC's full scale (a
/// run that had to cut is stopped). Where the DAC ran empty the output was at zero.
class PlayedDrive {
public:
    /// frequency_hz: at which the drive began, silent. InputError when there was no DAC.
    PlayedDrive(const DacInfo& dac, double frequency_hz, std::vector<DriveChange> changes,
                const std::vector<PlayTime>& played);
    /// The next samples, in volts, beginning at DAC sample 0. InputError when a change is none that the
    /// Synthesiser makes at that sample.
    void fill(std::span<double> volts);

private:
    /// At the sample that is due, where `lost` samples of silence are a part of the change.
    void apply(const DriveChange& change, std::int64_t lost);
    void require_made(const DriveChange& change) const;

    Synthesiser synthesiser_;
    std::vector<DriveChange> changes_;
    std::vector<std::int64_t> lost_;  // samples, each time that the DAC ran empty
    std::size_t next_ = 0, next_lost_ = 0;
    std::int64_t silent_ = 0;  // samples until the DAC goes on
    bool due_ = false;         // the change before `next_` is taken with the next sample
};

}  // namespace shaker
