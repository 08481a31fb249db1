#pragma once
// Runs of an hour with known truth and without pictures: exact motion as trackers and devices would report
// it.
#include <cstdint>

#include "daemon/acquisition/streams.hpp"
#include "daemon/recording/recorder.hpp"

namespace shaker::test {

/// A settled Coulomb walker on the paper's bench near the phase at which it does not drift, so that it stays
/// in view. 2.17 rad: it rests on the base for part of each period and wanders by less than 0.1 m an hour.
struct LongRun {
    double seconds = 3600;
    Drive drive{.frequency = 20, .gamma = paper_g, .rho = 0.5, .phi = 2.17};
    double position_noise_m = 2e-6;  // white, standard deviation of each position
    double lost = 1e-4;              // share of frames in which the walker is not found
    double heard_jitter_s = 50e-6;   // mean by which stamps of the DAC's blocks are late
    std::uint64_t seed = 1;
};

struct LongStreams {
    recorded::RecordingHeader header;  // of a recording without pictures
    acquisition::Streams streams;      // with master times
    double v_D = 0;                    // m/s, exact
    double from_s = 0, to_s = 0;
};

/// Accelerometer and cameras are those of paper_scene(): sensor model, clocks, noise and views. Throws
/// InputError when a period is not a whole number of the DAC's samples.
LongStreams make_long_streams(const LongRun& run);

/// Gives every raw stream of it to a recording, as a run would.
void record_raw(recording::Recorder& file, const acquisition::Streams& streams);

}  // namespace shaker::test
