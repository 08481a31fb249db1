#pragma once
// What the bench is at, as a value for those who look at it from outside. Every number is SI.
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "daemon/acquisition/period_jitter.hpp"
#include "daemon/control/identification.hpp"
#include "daemon/recording/journal.hpp"
#include "daemon/reduction/reduction.hpp"
#include "daemon/reduction/series.hpp"
#include "daemon/report/results.hpp"
#include "daemon/run/state.hpp"
#include "daemon/safety/limits.hpp"
#include "daemon/safety/preflight.hpp"
#include "drivers/devices.hpp"
#include "drivers/drive.hpp"
#include "tracking/track.hpp"

namespace shaker::service {

/// One harmonic of the base's motion in the newest period.
struct HarmonicState {
    std::complex<double> target,
        measured;      // m/s^2; the first that is asked for has the phase it is asked for with
    double sigma = 0;  // of each part of `measured`
};

struct BaseState {
    Drive got;  // gamma, rho and phi that harmonics 1 and 2 amount to
    std::array<HarmonicState, max_harmonics> harmonics{};
    int controlled = 0;   // of them
    double rms = 0;       // m/s^2 along the axis
    double residual = 0;  // of it, what is neither a harmonic nor mains
    double volts_peak = 0;
};

struct WalkerState {
    double x_m = 0;
    double edge_m = 0;                   // of its outline from the nearer end of the picture
    double left_m = NAN, right_m = NAN;  // x at the picture's left and right end (upper and lower, where x
                                         // runs along the picture's height); NaN: not known
    int lost = 0;                        // frames in a row
};

/// Which measurement a result belongs to.
struct ResultOrigin {
    std::uint64_t number = 0;         // of the measurement, from 1 at the daemon's start
    Drive asked;                      // set-point during the measurement
    double from_s = NAN, to_s = NAN;  // master time
};

/// Same set-point, every number of it.
inline bool same(const Drive& a, const Drive& b) {
    return a.frequency == b.frequency && a.gamma == b.gamma && a.rho == b.rho && a.phi == b.phi &&
           a.overtones == b.overtones;
}

/// What does not change while the bench is open.
struct BenchFacts {
    std::string rig;
    DacInfo dac;
    AccelerometerInfo accelerometer;
    std::vector<View> views;
    int soft_start_periods = 0;
    std::filesystem::path recordings;    // folder
    calibration::Estimate mu{NAN, NAN};  // of walker and base, as the settings have it; NaN: not known
};

struct ClockState {
    std::string name;
    double ppm = 0, ppm_sigma = 0;
    double residual_s = 0;  // mean delay of its stamps beyond the shortest
};

/// What was lost on the way between the threads since the start.
struct LostState {
    std::uint64_t plays = 0, changes = 0, blocks = 0, frames = 0, trips = 0, samples_clamped = 0;
};

struct RecordingState {
    std::string name;  // empty: nothing is recorded
    double backlog = 0;
    std::uint64_t pieces_lost = 0;
    double free_bytes = 0;  // where recordings go
};

/// A camera's newest picture with what is tracked in it.
struct PictureState {
    std::string camera;
    double t_s = 0;
    FramePtr frame;  // null before the first
    double px_per_mm = 0;
    std::vector<tracking::Fix> fixes;
    std::vector<Target> targets;
};

/// Two periods of the base's motion at even phases, m/s^2.
struct WaveformState {
    double t_s = 0, period_s = 0;
    std::vector<float> asked, measured;
};

struct BenchState {
    std::uint64_t answered = 0;  // orders so far
    run::RunState state{};
    double now_s = 0, since_s = 0;  // master time; of the state's beginning
    std::shared_ptr<const BenchFacts> facts;
    Drive wanted;
    std::vector<safety::Demand> predicted;  // peaks of what is wanted
    int periods = 0;                        // of a measurement
    int settle = 0;                         // before it, of the settled drive; 0: until the walker is steady
    bool closed_loop = true;                // as the runs that follow will be
    bool record = false;                    // the next run is recorded
    std::string record_name;  // of that recording, without folder and ending; empty: by the time
    recorded::KeptPictures pictures{};
    bool armed = false;  // idle, with a drive that was asked for and is within the limits
    bool locked = false, measuring = false;
    std::shared_ptr<const control::IdentifiedResponse> response;  // null before it was found out
    double reached = 1;  // of the asked gamma, that the bench can give
    std::optional<BaseState> base;
    WaveformState waveform;  // empty before the clocks are known
    std::optional<WalkerState> walker;
    std::vector<PictureState> pictures_now;
    std::optional<safety::Trip> trip;
    double trip_s = 0;
    bool may_clear = false;
    std::shared_ptr<const reduction::Reduction> result;  // of the newest measurement; null before the first
    ResultOrigin result_origin;                          // of that
    std::string not_reduced;                             // why the newest measurement has none
    double measured_from_s = NAN;                // master time of that measurement; NaN before the first
    std::vector<reduction::DrivenPoint> points;  // the newest measurements, oldest first
    std::vector<recording::MeasuredPart> parts;  // of master time, one a point
    std::vector<double> closed_form;  // v_D without stick, m/s, one a point; NaN where mu is not known
    std::optional<reduction::MirrorPair> mirror;  // of the newest of them
    std::optional<reduction::NullPhase> null;     // the newest that was found
    calibration::Estimate mu;  // as that tells it, else as the settings have it; NaN: not known
    std::vector<ClockState> clocks;
    std::vector<DeviceReport> devices;
    LostState lost;
    acquisition::PeriodJitter::Seen jitter;
    RecordingState recording;
    safety::Limits limits;
    std::uint64_t aborts = 0, trips = 0;
};

}  // namespace shaker::service
