#include "daemon/service/outlook.hpp"

#include <algorithm>
#include <cmath>

#include "daemon/recording/recorder.hpp"
#include "daemon/safety/preflight.hpp"

namespace shaker::service {

namespace {

// Periods that the parts of a run usually take; with a steady walker, settling ends after about this many.
constexpr int identifies = 110, checks = 16, settles = 45, follows = 3;
constexpr double shortest_s = 60;      // a shorter recording is mostly fixed parts: its rate is of no use
constexpr double bytes_per_s = 0.8e6;  // of a recording without pictures: measured on the simulated bench

/// Expected periods of a state before the first measurement.
int lasts(run::RunState state, const BenchState& s) {
    switch (state) {
        case run::RunState::identify:
            return identifies;
        case run::RunState::loop_check:
            return checks;
        case run::RunState::ramp:
            return s.facts ? s.facts->soft_start_periods : 0;
        case run::RunState::run:
            return s.plan.settle > 0 ? s.plan.settle + settles / 2 : settles;
        default:
            return 0;
    }
}

/// Expected periods from the start of `from` until the first measurement.
int until_measured(run::RunState from, const BenchState& s) {
    if (from == run::RunState::ramp_down) return 0;
    int sum = 0;
    for (const run::RunState step :
         {run::RunState::identify, run::RunState::loop_check, run::RunState::ramp, run::RunState::run})
        if (step >= from && (from != run::RunState::identify || step != run::RunState::loop_check))
            sum += lasts(step, s);
    return sum;
}

// Pictures of one second; 0 while the cameras have given none.
double pictures_per_s(const BenchState& s) {
    double bytes = 0;
    for (std::size_t i = 0; i < s.pictures_now.size(); ++i)
        if (const FramePtr& frame = s.pictures_now[i].frame; frame && s.facts)
            bytes += s.facts->views.at(i).frame_rate_hz * static_cast<double>(frame->pixels.size());
    return bytes;
}

OutlookState::Size size_of(recorded::KeptPictures kept, const BenchState& s) {
    const recording::RecordedRate& last = s.recording.rate;
    const bool known = std::isfinite(last.bytes_per_s) && !(last.lasted_s < shortest_s);
    OutlookState::Size size{known ? last.bytes_per_s : bytes_per_s, 0};
    if (kept == recorded::KeptPictures::first_second) size.first_bytes = pictures_per_s(s);
    if (recorded::keeps_all(kept))
        size.bytes_per_s += last.pictures == kept && std::isfinite(last.pictures_per_s) ? last.pictures_per_s
                                                                                        : pictures_per_s(s);
    return size;
}

}  // namespace

OutlookState outlook(const BenchState& s, const std::optional<run::PredictedWalk>& walk,
                     recorded::KeptPictures opened) {
    OutlookState o;
    o.before = until_measured(s.response ? run::RunState::loop_check : run::RunState::identify, s);
    const int ramp = lasts(run::RunState::ramp, s);
    o.walking = ramp + lasts(run::RunState::run, s) + follows;  // half of each of two ramps
    o.walk = walk;
    if (walk && s.walker) {
        const double swing_m = safety::largest_displacement(harmonics(s.wanted), s.wanted.frequency);
        o.way_m = std::max(0.0, s.walker->ways_m.at(walk->v_D.value < 0 ? 0 : 1) - swing_m);
    }
    for (std::size_t i = 0; i < o.sizes.size(); ++i)
        if (const auto kept = static_cast<recorded::KeptPictures>(i); recordable(kept, opened))
            o.sizes.at(i) = size_of(kept, s);
    return o;
}

bool recordable(recorded::KeptPictures pictures, recorded::KeptPictures opened) noexcept {
    if (!recorded::keeps_all(pictures)) return true;
    return pictures ==
           (opened == recorded::KeptPictures::first_second ? recorded::KeptPictures::region : opened);
}

double room_bytes(double free_bytes) noexcept {
    return std::isnan(free_bytes)
               ? NAN
               : std::max(0.0,
                          free_bytes - static_cast<double>(recording::RecorderSettings{}.least_free_bytes));
}

ProgressState progress_of(const BenchState& s, const run::Sequence& sequence) {
    const double f = s.wanted.frequency;
    const MeasurementPlan& plan = sequence.plan().task.plan;  // of the point, in a campaign
    const int measured = static_cast<int>(sequence.measured().size()), left = sequence.left();
    const int asked = plan.measurements;
    ProgressState p;
    p.measurement = measured + 1;
    p.measurements = asked == 0 ? 0 : (s.state == run::RunState::run ? measured + left : asked);
    p.waits_for = sequence.waits_for();
    double rest = (p.measurements == 0 ? 1 : p.measurements - measured) * plan.periods;
    if (sequence.measuring()) {
        p.periods_done = std::clamp((s.now_s - sequence.from_s()) * f, 0.0, 1.0 * plan.periods);
        rest -= p.periods_done;
    } else if (s.state != run::RunState::run || measured == 0) {
        const double gone = std::min((s.now_s - s.since_s) * f, 1.0 * lasts(s.state, s));
        rest += until_measured(s.state, s) - gone;
    }
    if (s.state != run::RunState::ramp_down) p.left_s = std::max(0.0, rest / f);
    if (!s.walker || !s.walker->drift_m || s.state != run::RunState::run) return p;
    p.walk_mps = *s.walker->drift_m * f;
    const double periods =
        run::periods_to_edge(s.walker->ways_m, *s.walker->drift_m, sequence.walker().swing_m());
    if (periods < 1e6) p.periods_left = periods;
    return p;
}

}  // namespace shaker::service
