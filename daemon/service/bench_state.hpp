#pragma once
// The published state of the bench. All numbers are in SI units.
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "daemon/acquisition/executors.hpp"
#include "daemon/acquisition/time_histogram.hpp"
#include "daemon/control/identification.hpp"
#include "daemon/law/fit.hpp"
#include "daemon/law/slope_mu.hpp"
#include "daemon/recording/folder.hpp"
#include "daemon/recording/journal.hpp"
#include "daemon/reduction/reduction.hpp"
#include "daemon/reduction/series.hpp"
#include "daemon/report/results.hpp"
#include "daemon/run/state.hpp"
#include "daemon/run/walk_prediction.hpp"
#include "daemon/safety/limits.hpp"
#include "daemon/safety/preflight.hpp"
#include "drivers/devices.hpp"
#include "drivers/drive.hpp"
#include "drivers/point_fields.hpp"
#include "tracking/tracker.hpp"

namespace shaker::service {

/// One harmonic of the base's motion in the newest window, m/s^2. The origin of time is such that the first
/// harmonic of the target has the same phase in `measured`.
struct HarmonicState {
    std::complex<double> target, measured;
    double sigma = 0;  // standard error of real and imaginary part of `measured`
};

struct BaseState {
    Drive got;  // gamma, rho and phi of the measured harmonics 1 and 2
    std::array<HarmonicState, max_harmonics> harmonics{};
    int controlled = 0;     // number of controlled harmonics, from the first on
    double rms = 0;         // acceleration along the shaker's axis, m/s^2
    double residual = 0;    // rms of the acceleration without harmonics and mains, m/s^2
    double volts_peak = 0;  // of the drive, V
};

struct WalkerState {
    double x_m = 0;
    double edge_m = 0;  // distance of its outline from the nearer end of the picture
    /// x at the picture's left and right end (upper and lower, if x runs along the height); NaN: not known.
    double left_m = NAN, right_m = NAN;
    /// How far it may go towards -x and +x until its outline is at the edge limit, mean over a period, m.
    std::array<double, 2> ways_m{NAN, NAN};
    std::optional<double> drift_m;  // of a period, newest periods
    int lost = 0;                   // consecutive frames without the walker
};

/// The measurement of a result.
struct ResultOrigin {
    std::uint64_t number = 0;         // counts measurements from 1 since the daemon's start
    Drive asked;                      // set-point during the measurement
    double from_s = NAN, to_s = NAN;  // master time
};

/// True when all numbers of two set-points are equal.
inline bool same(const Drive& a, const Drive& b) {
    return a.frequency == b.frequency && a.gamma == b.gamma && a.rho == b.rho && a.phi == b.phi &&
           a.overtones == b.overtones;
}

/// What a run at the set-point will take. Counted in periods of the drive.
struct OutlookState {
    int before = 0;   // expected, from the order until the first measurement
    int walking = 0;  // of these, with a walker that goes; and after the last measurement
    std::optional<run::PredictedWalk> walk;  // empty: not known
    double way_m = NAN;  // to the limit at the edge in the direction of the walk, less its oscillation
    struct Size {
        double bytes_per_s = NAN;  // NaN: the cameras are not open for these pictures
        double first_bytes = 0;    // of the pictures of the first second
    };
    std::array<Size, recorded::kept_pictures_words.size()> sizes{};  // of a recording, by its pictures
};

/// How far a run is.
struct ProgressState {
    int measurement = 0;        // the one that is under way or comes next, from 1
    int measurements = 0;       // that are asked for; 0: until another order
    double periods_done = 0;    // of the one under way
    double left_s = NAN;        // expected until the end of all that are asked for, else of this one
    std::string waits_for;      // what the next measurement waits for; empty while one is under way
    double walk_mps = NAN;      // of the walker, newest periods
    double periods_left = NAN;  // until the limit at the edge, by walk_mps
};

/// Largest value of a quantity in a period, against its limit.
struct GaugeState {
    std::string quantity, unit;
    double limit = 0;
    double set_point = NAN;  // predicted at the set-point
    double live = NAN;       // in the newest period; NaN: nothing is driven
};

/// Constants of an opened bench.
struct BenchFacts {
    std::string rig;
    DacInfo dac;
    AccelerometerInfo accelerometer;
    std::vector<View> views;
    int soft_start_periods = 0;
    calibration::Estimate mu{NAN, NAN};  // friction coefficient in the settings; NaN: not known
    double gravity = paper_g;            // at the place, m/s^2
    bool simulated = false;              // the walker may be put back by an order
};

struct ClockState {
    std::string name;
    double ppm = 0, ppm_sigma = 0;
    double residual_s = 0;  // mean delay of the stamps minus the shortest one
};

/// Time that the tracking of pictures takes.
struct TrackingState {
    double median_s = 0;    // half of the pictures of the slowest camera take less; upper end of a bin
    double slowest_s = 0;   // 99.9 % of them take less
    double core_share = 0;  // of one processor, all cameras at their frame rates
};

/// Data lost between the threads since the start, because a ring was full.
struct LostState {
    std::uint64_t plays = 0, changes = 0, blocks = 0, frames = 0, trips = 0, samples_clamped = 0;
};

struct RecordingState {
    std::string name;        // file name of the open recording; empty: no recording
    bool finishing = false;  // the run is over, and its recording is being completed
    double backlog = 0;      // filled share of its queue, 0 to 1
    std::uint64_t pieces_lost = 0;
    double free_bytes = 0;  // in the folder of recordings
    double room_bytes = 0;  // of these, for recordings; the others must stay free
    recording::RecordedRate rate{};
};

/// A camera's newest picture with the positions of its targets.
struct PictureState {
    std::string camera;
    double t_s = 0;  // master time
    FramePtr frame;  // null before the first picture
    double px_per_mm = 0;
    std::vector<tracking::Fix> fixes;
    std::vector<Target> targets;
    /// The region of each target moved with it, x, y, width, height in px; empty: the target is lost.
    std::vector<std::optional<std::array<int, 4>>> regions_now{};
    std::string not_found{};  // why its targets are not followed yet; empty: they are
};

/// Acceleration of the base over two periods at equidistant phases, m/s^2.
struct WaveformState {
    double t_s = 0, period_s = 0;  // master time of the window; length of a period
    std::vector<float> asked, measured;
};

/// "closed", "open" or "unreadable".
constexpr const char* word_of(Contact contact) noexcept {
    return contact == Contact::closed ? "closed" : contact == Contact::open ? "open" : "unreadable";
}

/// A campaign that was ordered.
struct CampaignState {
    std::string name;      // of the plan
    std::string title{};   // of the plan
    std::string folder{};  // beside the recordings, without path
    bool active = false;   // false: it has ended, and its table is written
    std::string doing{};   // "measuring", "returning", "changing", "paused", "ended", "interrupted"
    bool paused = false;
    bool waits = false;  // paused, and nothing happens before a person gives a word
    std::size_t points = 0, ended = 0;
    int number = 0;          // of the point in progress or next; 0: none
    std::string point{};     // in progress or next, in words; empty at the end
    double left_s = NAN;     // as predicted and corrected by the points so far; NaN: no campaign is measured
    std::string newest{};    // newest event in words
    std::string known_mu{};  // with a target for mu: what is known of it
};

/// The newest check of a plan, before anything moves.
struct PlanCheckState {
    std::string name;        // of the plan
    bool under_way = false;  // the rest is not known yet
    std::size_t points = 0, fit = 0;
    double bench_s = NAN, bytes = NAN;   // of the points that fit
    std::string summary{};               // the sums in words
    std::vector<std::string> misfits{};  // points that do not fit, with reasons; at most `most_misfits`
    static constexpr std::size_t most_misfits = 5;
};

struct BenchState {
    std::uint64_t answered = 0;  // orders since the start
    bool orders_wait = false;    // for the disk: they may start a drive
    run::RunState state{};
    double now_s = 0, since_s = 0;  // master time; start of the present state
    std::shared_ptr<const BenchFacts> facts;
    Drive wanted;                           // set-point
    std::vector<safety::Demand> predicted;  // predicted peaks at the set-point, with their limits
    MeasurementPlan plan;                   // of the next run; `measurements`: 0
    std::optional<CampaignState> campaign;  // under way, or the last one
    std::optional<PlanCheckState> plan_check;
    std::vector<std::string> plans;  // names that a campaign can be ordered by
    bool closed_loop = true;         // in the following runs
    bool record = false;             // the next run is recorded
    std::string record_name;  // of the next recording, without folder and ending; empty: a name from the time
    recorded::KeptPictures pictures{};
    bool armed = false;   // idle, and a set-point within the limits was ordered
    bool locked = false;  // all controlled harmonics are at their targets
    bool measuring = false;
    OutlookState outlook;
    /// Empty: nothing is driven, or the walker is brought to the middle.
    std::optional<ProgressState> progress;
    std::vector<GaugeState> gauges;
    bool to_middle = false;  // the walker is being brought to the middle of the picture
    std::shared_ptr<const control::IdentifiedResponse> response;  // null before an identification
    double reached = 1;             // largest share of the requested gamma that the bench can reach
    std::optional<BaseState> base;  // empty before the first window
    WaveformState waveform;         // empty before the first window
    std::optional<WalkerState> walker;
    std::vector<PictureState> pictures_now;
    std::optional<safety::Trip> trip;
    double trip_s = 0;
    std::string trip_file;  // recording with the stop, in the folder of recordings; empty: not complete yet
    std::vector<PictureState> trip_pictures;  // newest pictures at the trip; empty without a trip
    bool may_clear = false;
    std::shared_ptr<const reduction::Reduction> result;  // of the newest measurement; null before the first
    ResultOrigin result_origin;                          // of `result`
    law::Friction friction;                              // of `result`: friction against v_R
    std::string not_reduced;                             // reason why the newest measurement has no result
    double measured_from_s = NAN;  // master time of the newest measurement; NaN before the first
    std::vector<reduction::DrivenPoint> points;   // the newest measurements, oldest first
    std::vector<recording::MeasuredPart> parts;   // intervals of master time, one per point
    std::vector<double> closed_form;              // v_D without stick, m/s, one per point; NaN: mu not known
    std::optional<reduction::MirrorPair> mirror;  // newest point and its partner at phi + pi
    std::optional<reduction::NullPhase> null;     // newest phase without drift
    calibration::Estimate mu;                     // fitted, otherwise from the settings; NaN: not known
    law::Fit fitted_mu;  // mu_ac of the newest measurements; NaN with the reason in its note
    std::vector<ClockState> clocks;
    std::vector<DeviceReport> devices;
    LostState lost;
    acquisition::PeriodJitter::Seen jitter;
    std::optional<TrackingState> tracking;              // empty: no picture has been tracked
    std::vector<acquisition::RealTimeGrant> real_time;  // empty: no request, as on a simulated rig
    std::optional<Contact> contact;                     // of the abort input; empty: no abort input
    std::optional<bool> enable_output;                  // true: on; empty: no enable output
    RecordingState recording;
    safety::Limits limits;
    std::uint64_t aborts = 0, trips = 0;
};

}  // namespace shaker::service
