#pragma once
// The output loop: synthesiser, guard and latch of the drive. A trip latches the output; only an operator's
// clear that was given after the newest trip and the newest abort unlatches it.
#include <cstdint>
#include <optional>
#include <vector>

#include "daemon/acquisition/channels.hpp"
#include "daemon/acquisition/enable_window.hpp"
#include "daemon/acquisition/queued_blocks.hpp"
#include "daemon/safety/output_guard.hpp"
#include "drivers/devices.hpp"
#include "drivers/synthesiser.hpp"
#include "drivers/trigger_train.hpp"

namespace shaker::acquisition {

struct DriveOutput {
    /// block: samples per write. limits: enforced by the guard; every sample stays below the drive's abort
    /// level; empty: no guard. accelerometer_rate_hz: of the accelerometer whose silence stops the drive;
    /// 0: no accelerometer.
    DriveOutput(const DacInfo& dac, double frequency, double frames_per_second, std::size_t block,
                const std::optional<safety::Limits>& limits = {}, double accelerometer_rate_hz = 0);
    double full_scale_V;
    double rate_hz;
    Synthesiser synthesiser;
    safety::OutputGuard guard;
    TriggerTrain triggers;
    std::vector<double> volts, pulses;
    QueuedBlocks queued;
    EnableWindow enable;
    bool has_contact = false;                       // there is an abort input
    std::uint64_t openings = 0, contact_reads = 0;  // values of the Channels that were answered
    std::int64_t contact_read_at = 0;               // DAC sample of the last reading
    std::int64_t drives_until = 0;                  // DAC sample after the last one that was not zero
    PlayTime played;                                // of the last block
    std::uint64_t underruns = 0;                    // of the DAC since the start
    std::int64_t empty_from = 0, empty_to = 0;      // DAC samples: the last time the DAC was empty
    std::uint64_t aborted = 0;                      // value of Channels::aborts that was answered
    bool failed = false;                            // a loop has failed and its stop was ordered
    safety::Trip newest{};                          // number 0: no trip yet
    std::optional<safety::Trip> unreported;         // newest trip that found a full ring
    std::optional<Clearance> clearance;             // waits for silence
};

/// Answers trips (also its own), aborts and clears, takes the newest drive, fills one block and plays it. A
/// stop starts with the first sample of that block. Before a hard stop, queued samples are taken back from
/// the DAC if the drive ends earlier by it: the block then starts behind the last sample that stays, and the
/// change that reports the stop has their number. The enable output of the amplifier follows the drive
/// (EnableWindow). Real-time except for Dac::write.
void output_step(DriveOutput& output, Dac& dac, Channels& channels);

}  // namespace shaker::acquisition
