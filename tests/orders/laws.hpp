#pragma once
// Laws: what must hold at every sample that leaves the DAC, whatever clients, devices and disk do.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "daemon/acquisition/channels.hpp"
#include "daemon/acquisition/streams.hpp"
#include "daemon/run/state.hpp"
#include "daemon/safety/limits.hpp"

namespace shaker::orders {

struct Violation {
    std::string law;
    double at_s = 0;  // virtual time
    std::string words;
};
/// Law, time and words in one line.
std::string text(const Violation& violation);

/// Checks the output block by block. Volts above `silence_V` count as a drive.
class Laws {
public:
    static constexpr double silence_V = 1e-9;

    /// axis: true direction of the shaker in the axes of the accelerometer.
    Laws(const DacInfo& dac, const AccelerometerInfo& accelerometer, const std::array<double, 3>& axis,
         const acquisition::Channels& channels, const acquisition::Streams& streams);

    /// A client aborted; the output has not yet written a block since.
    void aborted();
    /// The contact of the abort input opens, now or as soon as what the DAC holds is played.
    void contact_opened();
    /// The bench has accepted a client's clear.
    void cleared() noexcept { cleared_ = ++events_; }
    /// A client or a file has named this value for a limit.
    void limit_named(double value) { named_.insert(value); }
    /// The bench has obeyed the order to end the program.
    void left() { left_at_ = next_; }
    /// The bench has accepted an order to stop.
    void ended() { ended_ = Ended{next_, next_, INFINITY, 0}; }
    /// The state of the bench, as published by a step that was just made.
    void state(run::RunState now);
    /// Reads the trips of the streams. Call it before clients act.
    void see_trips();
    /// The limits in force, as published. Call after every change.
    void limits(const safety::Limits& limits);
    /// The bench has passed its self-test at rest.
    void self_tested() noexcept { self_tested_ = true; }
    /// Cameras with this frame rate have the walker as a target.
    void has_target(double frame_rate_hz) noexcept { frame_rate_hz_ = frame_rate_hz; }
    /// A camera has delivered a picture.
    void pictured() noexcept { pictured_at_ = next_; }
    /// The thread that judges pictures stands still.
    void unwatched() noexcept { unwatched_until_ = next_; }
    /// Peak of a loop check of the present drive, V.
    void check_level(std::function<double()> volts) { check_V_ = std::move(volts); }
    /// A loop check begins; it was passed, or an identification takes its place.
    void checks() noexcept { checked_ = false; }
    void checked() noexcept { checked_ = true; }
    /// The accelerometer has delivered samples.
    void sampled(std::span<const std::array<std::int32_t, 3>> counts);
    /// A block was handed to the DAC, which lost `lost` samples behind it.
    void played(std::span<const double> volts, std::int64_t lost);
    /// A drive of this frequency may be asked for: it begins with a whole period.
    void may_drive(double frequency_hz) noexcept { period_s_ = std::max(period_s_, 1 / frequency_hz); }
    /// Blocks from now on have the enable tone of the amplifier, or not.
    void enabled(bool on) noexcept { tone_ = on; }
    /// The DAC has taken back this many samples; they are never played.
    void took_back(std::int64_t samples) noexcept { next_ -= samples; }
    /// A client's request has had no answer since `since_s`.
    void unanswered(const std::string& request, double since_s);
    /// Heap calls in a real-time step.
    void allocated(const char* step, std::uint64_t calls);
    /// Any other violation.
    void broken(std::string law, std::string words);

    [[nodiscard]] double now_s() const noexcept { return static_cast<double>(next_) / rate_hz_; }
    [[nodiscard]] const std::vector<Violation>& violations() const noexcept { return violations_; }
    /// Hash of all volts so far.
    [[nodiscard]] std::uint64_t fingerprint() const noexcept { return hash_; }
    [[nodiscard]] std::uint64_t aborts() const noexcept { return aborts_; }
    [[nodiscard]] std::uint64_t trips() const noexcept { return trips_; }
    /// Longest time from an abort to the first sample of a silent output, s.
    [[nodiscard]] double slowest_abort_s() const noexcept { return slowest_abort_s_; }

private:
    /// From this tick on the output must be silent, until a clear that was given after the event.
    struct Silence {
        std::int64_t from;
        std::uint64_t event;
        bool abort;
        std::string why;
    };
    void see_judged();
    void check(double volt, std::int64_t tick);
    void check_age(double volt, std::int64_t tick);
    void check_left(std::span<const double> volts);
    void check_ended(std::span<const double> volts);
    void check_latched(const safety::Trip& trip);
    void check_limit(double was, double is);
    void check_view(double volt, std::int64_t tick);
    void check_level(std::span<const double> volts);
    void check_enable(std::span<const double> volts, bool lost);
    void require_silence(double after_s, bool abort, std::string why);
    [[nodiscard]] std::int64_t samples(double s) const noexcept;

    double rate_hz_;
    std::size_t block_;
    double enable_before_s_;
    AccelerometerInfo accelerometer_;
    std::array<double, 3> axis_;
    double patience_floor_s_;
    const acquisition::Channels& channels_;
    const acquisition::Streams& streams_;
    safety::Limits limits_;
    std::vector<std::pair<std::int64_t, double>> drive_limits_{};  // tick from which a drive limit holds, V
    std::int64_t next_ = 0;                                        // tick of the next block
    std::uint64_t events_ = 0;              // aborts, trips and clears, to put them in order
    std::uint64_t cleared_ = 0;             // event of the newest accepted clear
    std::uint64_t tripped_ = 0;             // event of the newest trip
    std::optional<safety::Trip> newest_{};  // that trip
    run::RunState state_ = run::RunState::init;
    std::set<double> named_{};             // values of limits that are not in force yet
    std::optional<std::int64_t> left_at_;  // tick of the order to end the program
    bool rests_ = false;                   // a block without drive came after that order
    /// After an order to stop: the largest volts of each window as long as the longest period.
    struct Ended {
        std::int64_t at = 0, window = 0;  // ticks of the order, and of the present window
        double before_V = 0, now_V = 0;   // of the last window and of the present one
    };
    std::optional<Ended> ended_;            // until the output is silent
    std::optional<std::int64_t> abort_at_;  // tick of the newest abort, until the output is silent
    std::vector<Silence> silences_{};
    bool self_tested_ = false;
    double mean_ = 0;  // of the acceleration along the axis, m/s^2
    std::int64_t sampled_ = 0;
    std::uint64_t judged_ = 0;
    std::int64_t judged_at_ = 0;
    std::int64_t aged_from_ = samples(2);  // tick from which the age of the samples is judged
    double frame_rate_hz_ = 0;             // 0: no camera has the walker as a target
    std::int64_t pictured_at_ = 0, unwatched_until_ = 0;
    std::function<double()> check_V_{};
    bool checked_ = false;           // since the drive was at rest
    double period_s_ = 0;            // the longest of the drives
    bool tone_ = false;              // the enable tone of the amplifier sounds
    std::int64_t tone_for_ = 0;      // samples
    std::int64_t tone_at_rest_ = 0;  // samples without a drive at its end
    std::size_t seen_trips_ = 0;
    double slowest_abort_s_ = 0;
    std::uint64_t aborts_ = 0, trips_ = 0;
    std::uint64_t hash_ = 1469598103934665603ULL;
    std::vector<Violation> violations_{};
};

}  // namespace shaker::orders
