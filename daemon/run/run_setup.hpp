#pragma once
// Preparation of a run: header of its recording, limits, predicted motion and plan.
#include <vector>

#include "daemon/bench/bench.hpp"
#include "daemon/run/run_settings.hpp"
#include "daemon/run/sequence.hpp"
#include "daemon/safety/preflight.hpp"
#include "drivers/recorded/recording_file.hpp"

namespace shaker::run {

/// Header of the run's recording. live: real time, so the header gets a date and an identifier. with_truth:
/// the file gets tables for the true positions of a simulated walker.
recorded::RecordingHeader run_header(const bench::Bench& bench, const std::vector<View>& views,
                                     const RunOptions& run, bool live, bool with_truth);
/// The limits of any run: the bench's limits without the detector `underrun`. After an empty DAC the drive
/// restarts softly by itself, a limited number of times.
safety::Limits limits_of_run(safety::Limits limits);
/// Something other than the data sheet shows the accelerometer's gain: gravity in the reading of its three
/// axes, or a camera that sees the base.
bool gain_shown(const Rig& rig);
/// InputError for a drive that the accelerometer does not see well enough to control it: too few samples a
/// period, or a response by the settings, without a file, that changes the amplitude of a driven
/// harmonic by more than a tenth.
void require_seen(const bench::Bench& bench, const Drive& drive);
/// InputError where the fastest view of walker or base takes too few pictures a period for a measurement.
void require_pictures(const Rig& rig, double frequency);

/// Peaks of voltage and motion that a drive needs by the data sheet, each with its limit.
std::vector<safety::Demand> run_demands(const bench::Bench& bench, const Drive& drive,
                                        const safety::Limits& limits);
/// The same for a motion of the base. frequency: of its first harmonic, Hz.
std::vector<safety::Demand> motion_demands(const bench::Bench& bench, const Harmonics<Acceleration>& motion,
                                           double frequency, const safety::Limits& limits);
RunPlan run_plan(const bench::Bench& bench, const RunOptions& run, const safety::Limits& limits);

}  // namespace shaker::run
