#include "tests/orders/laws.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "daemon/run/sequence.hpp"
#include "daemon/safety/output_guard.hpp"

namespace shaker::orders {

namespace {
constexpr std::size_t most_violations = 8;
constexpr double block_patience = 1.25;  // blocks of the accelerometer that the output always waits
constexpr double slack = 1 + 1e-6;       // of a limit
constexpr double motion_slack = 1.05;    // of a limit of motion: the daemon has fitted the axis
constexpr double mean_s = 4;             // time constant of gravity and offset
constexpr double contact_s = 0.06;       // the longest queue of the DAC in a plan, and two readings
constexpr double mean_known_s = 0.3;
constexpr double caught_up_s = 0.1;  // after an underrun
constexpr double frames_missing = 10;
constexpr double normal_age_s = 0.1;  // the longest queue of the DAC in a plan, delay and block of the sensor
constexpr double shown_s = 0.2;       // a published state is younger
constexpr double enabled_at_rest_s = 0.1;  // the tone behind a drive, and blocks
constexpr const char* left_law = "nothing driven after the order to leave";
}  // namespace

std::string text(const Violation& v) { return fmt::format("{}: at {:.4f} s {}", v.law, v.at_s, v.words); }

Laws::Laws(const DacInfo& dac, const AccelerometerInfo& accelerometer, const std::array<double, 3>& axis,
           const acquisition::Channels& channels, const acquisition::Streams& streams)
    : rate_hz_{dac.rate_hz},
      block_{dac.block_frames},
      enable_before_s_{dac.enable_before_s},
      accelerometer_{accelerometer},
      axis_{axis},
      patience_floor_s_{block_patience * AccelBlock::capacity / accelerometer.rate_hz},
      channels_{channels},
      streams_{streams} {}

std::int64_t Laws::samples(double s) const noexcept { return std::llround(s * rate_hz_); }

void Laws::broken(std::string law, std::string words) {
    if (violations_.size() < most_violations)
        violations_.push_back({std::move(law), now_s(), std::move(words)});
}

void Laws::require_silence(double after_s, bool abort, std::string why) {
    silences_.push_back({next_ + samples(after_s), ++events_, abort, std::move(why)});
}

// The next block begins the ramp.
void Laws::aborted() {
    ++aborts_;
    abort_at_ = next_;
    require_silence(limits_.hard_stop_s + 1 / rate_hz_, true, "an abort");
}

// It is read every 10 ms; the block that is being written and the next one follow.
void Laws::contact_opened() {
    require_silence(contact_s + 2 * static_cast<double>(block_) / rate_hz_ + limits_.hard_stop_s, false,
                    "the contact opened");
}

void Laws::state(run::RunState now) {
    const run::RunState before = std::exchange(state_, now);
    if (before == run::RunState::tripped && now != before && cleared_ < tripped_)
        broken("accepted clears only",
               fmt::format("from tripped to {} without an accepted clear", name(now)));
    if (left_at_ && next_ > *left_at_ + samples(shown_s) && driving(now) && now != run::RunState::ramp_down)
        broken(left_law, fmt::format("state {}", name(now)));
}

// Each value is in force once: one that comes back was put back by an order that did not name it.
void Laws::check_limit(double was, double is) {
    if (std::isfinite(was) && is != was && named_.erase(is) == 0)
        broken("an order changes what it names", fmt::format("limit {} changed to {}", was, is));
}

// A limit that was lowered holds after the present block and a hard stop; one that was raised holds at once.
void Laws::limits(const safety::Limits& limits) {
    const double was = limits_.drive.abort, is = limits.drive.abort;
    check_limit(was, is);
    check_limit(limits_.acceleration.abort, limits.acceleration.abort);
    limits_ = limits;
    if (is == was) return;
    if (is > was) drive_limits_.clear();
    const std::int64_t promised =
        is > was ? 0 : static_cast<std::int64_t>(block_) + samples(limits.hard_stop_s) + 1;
    drive_limits_.emplace_back(next_ + promised, is);
}

// Every trip asks for silence until a clear, except an underrun, after which the drive may come back softly.
void Laws::see_trips() {
    seen_trips_ = std::min(seen_trips_, streams_.trips.size());
    for (; seen_trips_ < streams_.trips.size(); ++seen_trips_) {
        const safety::Trip& trip = streams_.trips[seen_trips_];
        ++trips_;
        check_latched(trip);
        tripped_ = ++events_;
        newest_ = trip;
        if (trip.cause == safety::Cause::underrun) continue;
        require_silence(limits_.soft_stop_s + 1 / rate_hz_, false, fmt::format("trip {}", name(trip.cause)));
    }
}

// A contact that opens again while its stop is latched and silent leaves no further trip.
void Laws::check_latched(const safety::Trip& trip) {
    constexpr auto contact = safety::Cause::abort_input;
    if (trip.cause != contact || !newest_ || newest_->cause != contact || cleared_ > tripped_) return;
    const std::int64_t silent_at =
        newest_->tick + 2 * static_cast<std::int64_t>(block_) + samples(limits_.hard_stop_s);
    if (trip.tick > silent_at)
        broken("one trip for a latched contact",
               fmt::format("trips at the samples {} and {}", newest_->tick, trip.tick));
}

// A sample above the acceleration limit asks for silence: the block that is being written, the next one and
// a hard stop.
void Laws::sampled(std::span<const std::array<std::int32_t, 3>> counts) {
    for (const auto& sample : counts) {
        const auto a = accelerometer_.acceleration(sample);
        double along = 0;
        for (std::size_t k = 0; k < 3; ++k) along += axis_.at(k) * a.at(k);
        mean_ += (along - mean_) / std::min(static_cast<double>(++sampled_), mean_s * accelerometer_.rate_hz);
        const double level = std::abs(along - mean_), limit = limits_.acceleration.abort;
        if (static_cast<double>(sampled_) < mean_known_s * accelerometer_.rate_hz ||
            level < motion_slack * limit)
            continue;
        require_silence(2 * static_cast<double>(block_) / rate_hz_ + limits_.hard_stop_s, false,
                        fmt::format("a sample of {:.3f} m/s^2, limit {:.3f}", level, limit));
        return;
    }
}

// Without judged samples the output must have come to rest: patience, time for samples that are held back,
// the block in which it is noticed and the next one, and a soft stop.
void Laws::see_judged() {
    if (const std::uint64_t judged = channels_.judged; judged != judged_) {
        judged_ = judged;
        judged_at_ = next_;
    }
}

void Laws::check(double volt, std::int64_t tick) {
    if (std::abs(volt) <= silence_V) return;
    if (!std::exchange(self_tested_, true))
        broken("self-test before a drive", fmt::format("{:.6f} V without a passed self-test", volt));
    for (const auto& [from, limit] : drive_limits_)
        if (tick >= from && std::abs(volt) > limit * slack) {
            broken("drive limit", fmt::format("{:.6f} V above the limit of {:.6f} V", volt, limit));
            drive_limits_.clear();
            break;
        }
    for (auto s = silences_.begin(); s != silences_.end(); ++s)
        if (tick >= s->from) {
            broken("silence until a clear", fmt::format("{:.6f} V after {}", volt, s->why));
            silences_.erase(s);
            break;
        }
    const double patience_s = std::max(limits_.missing_s, patience_floor_s_) +
                              safety::OutputGuard::held_back_s + 2 * static_cast<double>(block_) / rate_hz_ +
                              limits_.soft_stop_s;
    if (tick - judged_at_ > samples(patience_s)) {
        broken("judged samples", fmt::format("{:.6f} V {:.4f} s after the last judged sample", volt,
                                             static_cast<double>(tick - judged_at_) / rate_hz_));
        judged_at_ = tick;
    }
}

// The clocks of a plan are right, so the ticks tell the age; in it are the queue of the DAC, the delay of the
// sensor and its block. It is judged when the least age is known, and not while the program catches up after
// an underrun.
void Laws::check_age(double volt, std::int64_t tick) {
    if (std::abs(volt) <= silence_V || tick < aged_from_) return;
    const double age_s = static_cast<double>(tick) / rate_hz_ -
                         static_cast<double>(channels_.checked_to) / accelerometer_.rate_hz;
    const double most_s = std::max(limits_.missing_s, patience_floor_s_) + safety::OutputGuard::held_back_s +
                          normal_age_s + 2 * static_cast<double>(block_) / rate_hz_ + limits_.soft_stop_s;
    if (age_s < most_s) return;
    broken("age of the samples", fmt::format("{:.6f} V with samples that are {:.4f} s old", volt, age_s));
    aged_from_ = tick + samples(1);
}

// The soft stop of the program ends, and what is at rest stays there.
void Laws::check_left(std::span<const double> volts) {
    if (!left_at_) return;
    const bool driven = std::ranges::any_of(volts, [](double v) { return std::abs(v) > silence_V; });
    if (driven && (rests_ || next_ > *left_at_ + samples(run::longest_soft_stop_s + shown_s))) {
        broken(left_law,
               fmt::format("driven {:.3f} s after it", static_cast<double>(next_ - *left_at_) / rate_hz_));
        left_at_.reset();
    }
    rests_ = rests_ || !driven;
}

// An order to stop begins with the next block, in every state: the envelope never grows from then on.
void Laws::check_ended(std::span<const double> volts) {
    if (!ended_) return;
    constexpr const char* law = "stop means stop";
    constexpr double fading = 1.02;  // a window begins at any phase of the drive
    const double since_s = static_cast<double>(next_ - ended_->at) / rate_hz_;
    double peak = 0;
    for (const double volt : volts) peak = std::max(peak, std::abs(volt));
    if (peak <= silence_V) return ended_.reset();
    ended_->now_V = std::max(ended_->now_V, peak);
    if (ended_->now_V > fading * ended_->before_V)
        broken(law, fmt::format("{:.6f} V {:.3f} s after it, {:.6f} V before", ended_->now_V, since_s,
                                ended_->before_V));
    else if (since_s > run::longest_soft_stop_s + shown_s)
        broken(law, fmt::format("{:.6f} V {:.3f} s after it", peak, since_s));
    else if (next_ < ended_->window + samples(period_s_))
        return;
    else
        return void(ended_ = Ended{ended_->at, next_, ended_->now_V, 0});
    ended_.reset();
}

// The newest picture of any camera may be as old as the limits say, but for silences of the DAC; two blocks
// and a soft stop follow, also after the thread that judges it stood still.
void Laws::check_view(double volt, std::int64_t tick) {
    if (std::abs(volt) <= silence_V || frame_rate_hz_ <= 0) return;
    const double stop_s = 2 * static_cast<double>(block_) / rate_hz_ + limits_.soft_stop_s;
    const double most_s = std::max(limits_.camera_missing_s, frames_missing / frame_rate_hz_) + stop_s;
    if (tick - pictured_at_ < samples(most_s) || tick - unwatched_until_ < samples(stop_s)) return;
    broken("a view of the walker", fmt::format("{:.6f} V {:.4f} s after the newest picture", volt,
                                               static_cast<double>(tick - pictured_at_) / rate_hz_));
    pictured_at_ = tick;
}

// From rest, and after the DAC ran empty, the base is driven at the level of the loop check until it is
// passed.
void Laws::check_level(std::span<const double> volts) {
    if (checked_ || !check_V_) return;
    double peak = 0;
    for (const double volt : volts) peak = std::max(peak, std::abs(volt));
    if (peak <= silence_V) return;
    const double most = check_V_();
    if (peak <= most * slack) return;
    broken("a loop check before a drive", fmt::format("{:.6f} V, the loop check has {:.6f} V", peak, most));
    checked_ = true;
}

// The amplifier is on before the drive comes, and off when nothing is driven for a while. A drive waits for
// the start of its period.
void Laws::check_enable(std::span<const double> volts, bool lost) {
    if (enable_before_s_ <= 0) return;
    const bool driven = std::ranges::any_of(volts, [](double v) { return std::abs(v) > silence_V; });
    if (driven && (!tone_ || tone_for_ < samples(enable_before_s_)))
        broken("the amplifier is on before the drive",
               fmt::format("a drive {:.4f} s after the start of the enable tone",
                           static_cast<double>(tone_for_) / rate_hz_));
    tone_for_ = tone_ && !lost ? tone_for_ + std::ssize(volts) : 0;
    tone_at_rest_ = tone_for_ > 0 && !driven ? tone_at_rest_ + std::ssize(volts) : 0;
    if (tone_at_rest_ < samples(enable_before_s_ + period_s_ + enabled_at_rest_s)) return;
    broken("the amplifier is off at rest", fmt::format("its enable tone sounds {:.3f} s without a drive",
                                                       static_cast<double>(tone_at_rest_) / rate_hz_));
    tone_at_rest_ = 0;
}

void Laws::played(std::span<const double> volts, std::int64_t lost) {
    see_trips();
    see_judged();
    check_level(volts);
    check_enable(volts, lost > 0);
    std::erase_if(silences_, [&](const Silence& s) { return cleared_ > s.event; });
    for (std::size_t i = 0; i < volts.size(); ++i) {
        hash_ = (hash_ ^ std::bit_cast<std::uint64_t>(volts[i])) * 1099511628211ULL;
        check(volts[i], next_ + static_cast<std::int64_t>(i));
        check_age(volts[i], next_ + static_cast<std::int64_t>(i));
        check_view(volts[i], next_ + static_cast<std::int64_t>(i));
        if (!abort_at_) continue;
        const auto since_s =
            static_cast<double>(next_ + static_cast<std::int64_t>(i) - *abort_at_) / rate_hz_;
        if (std::abs(volts[i]) > silence_V)
            slowest_abort_s_ = std::max(slowest_abort_s_, since_s);
        else if (since_s > limits_.hard_stop_s)
            abort_at_.reset();
    }
    check_left(volts);
    check_ended(volts);
    next_ += static_cast<std::int64_t>(volts.size()) + lost;
    if (lost == 0) return;
    checked_ = false;
    pictured_at_ += lost;  // the DAC triggers the cameras
    aged_from_ = std::max(aged_from_, next_ + samples(caught_up_s));
    judged_at_ = std::max(judged_at_, next_ - samples(patience_floor_s_));
}

void Laws::unanswered(const std::string& request, double since_s) {
    broken("a promised answer", fmt::format("{} has had no answer since {:.3f} s", request, since_s));
}

void Laws::allocated(const char* step, std::uint64_t calls) {
    broken("no allocation", fmt::format("{} heap calls in the step of the {}", calls, step));
}

}  // namespace shaker::orders
