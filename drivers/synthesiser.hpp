#pragma once
// Samples of the drive voltage from its harmonics, on one integer phase. Real-time: no allocation, locks
// or log.
#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "drivers/drive.hpp"
#include "drivers/time.hpp"

namespace shaker {

/// Phase as a 128-bit fraction of a turn, in units of 2^-128 turn: sums wrap at whole turns and lose nothing.
__extension__ typedef unsigned __int128 Turns;

/// The upper word, in units of 2^-64 turn.
constexpr std::uint64_t high_word(Turns t) noexcept { return static_cast<std::uint64_t>(t >> 64); }
/// The lower word, in units of 2^-128 turn.
constexpr std::uint64_t low_word(Turns t) noexcept { return static_cast<std::uint64_t>(t); }
constexpr Turns turns_of(std::uint64_t high, std::uint64_t low) noexcept { return (Turns{high} << 64) | low; }

/// frequency / rate_hz, rounded up to a whole unit. Requires 0 <= frequency < rate_hz; other arguments
/// give a meaningless result.
constexpr Turns turns_per_sample(double frequency, double rate_hz) noexcept {
    // Long division, bit by bit. The remainder stays below the divisor and is an exact double: half
    // the rate is subtracted only from numbers up to twice as large.
    const double half = rate_hz / 2;
    double remainder = frequency;
    Turns quotient = 0;
    for (int bit = 0; bit < 128; ++bit) {
        const bool one = remainder >= half;
        if (one) remainder -= half;
        remainder *= 2;
        quotient = (quotient << 1) | Turns{one};
    }
    return quotient + (remainder > 0);
}

/// Command to the output thread: change to these harmonics at this frequency over `ramp_periods` periods, or
/// a soft stop.
struct DriveCommand {
    Harmonics<Voltage> volts;
    double frequency = 20.0;     // Hz
    int ramp_periods = 1;        // >= 1, periods of the old frequency; raised cosine
    std::uint64_t sequence = 0;  // copied into the DriveChange
    /// Above 0: a soft stop of this length, s, that begins with the next sample, also during a ramp. Volts,
    /// frequency and ramp are ignored then.
    double stop_s = 0;
    std::uint64_t underruns = 0;  // of the DAC since the start, that the sender of the command knew of
};

/// A command as it was applied. With the previous one it is enough to regenerate every sample.
struct DriveChange {
    DriveCommand command;
    DacTick first;  // first sample of the ramp, at the start of a period
    /// Samples. For a stop: above 0, the ramp that was under way stands still from `first` on; 0: no ramp was
    /// under way, or, in a recording of before, it went on.
    std::int64_t ramp = 0;
    Turns phase = 0;  // at `first`
    Turns step = 0;   // phase per sample after the ramp
    /// Samples, >= 0. Above 0: a stop, not a command. The signal that was playing is multiplied by a weight
    /// that falls from 1 at `first` to 0 at first + stop, followed by silence; `command` has no volts. A stop
    /// during another stop continues from the present weight. A soft stop has the sequence of its command, a
    /// trip's stop has 0.
    std::int64_t stop = 0;
    /// Samples, >= 0. Above 0: before this stop, the samples from `first` to first + taken_back were taken
    /// back from the DAC; they were never played.
    std::int64_t taken_back = 0;
    /// True if a change reported before this one never took effect, because its first sample was taken back.
    /// Every user of a list of changes ignores such changes.
    [[nodiscard]] bool voids(const DriveChange& earlier) const noexcept {
        return taken_back > 0 && earlier.first >= first;
    }
    /// First sample behind the ramp or the stop.
    [[nodiscard]] DacTick end() const noexcept { return {first.n + std::max(ramp, stop)}; }
};

/// The changes that took effect: without those that a later one voids.
std::vector<DriveChange> in_effect(std::vector<DriveChange> changes);
/// Index of the newest change in effect whose ramp or stop has ended at a DAC sample; 0 if there is none.
/// This change and those after it regenerate the drive from that sample on.
std::size_t in_force_at(std::span<const DriveChange> changes, double dac_sample);

/// Fills blocks with volts(t) = Im sum_q a_q e^{i q theta(t)}, a_q in V and theta the phase. Starts
/// silent at phase 0. A command takes effect at the next start of a period (the first sample whose phase
/// wrapped); complex amplitudes and frequency are ramped side by side. A command given during a ramp
/// waits for the first start of a period after the ramp. Samples depend only on the commands and the
/// ticks at which they took effect, not on block sizes or the machine.
///
/// Phase is summed in 128 bits and the harmonics read its upper 64. A step is frequency / rate rounded up
/// to 2^-128 turn, so n samples at one frequency are ahead of the exact phase by less than n 2^-128 turn.
/// Therefore the harmonics' phase is always within 2^-64 turn, and period k at one frequency starts at
/// the first sample at or after k rate / frequency, also where that is a whole number. This holds for the
/// first 2^42 samples (3 years at 48 kHz) at any frequency and rate. While the frequency is ramped, steps
/// are rounded to 2^-64 turn; after the ramp the phase is exact again, counted from its end.
class Synthesiser {
public:
    /// rate_hz: samples per second. frequency: Hz, of the silent start. limit_V: every sample is cut
    /// to +-limit_V. Throws InputError unless rate and limit are positive and the frequency is
    /// playable: at least one period in 2^32 samples, and every harmonic below half the rate.
    Synthesiser(double rate_hz, double frequency, double limit_V);

    /// Sets the next command; replaces one that has not taken effect yet. A soft stop takes effect with
    /// the next sample. Commands with non-finite values and commands during any stop are refused and
    /// counted.
    void set(const DriveCommand& command) noexcept;
    /// Samples from now on are cut to +-limit_V (positive and finite, else it is ignored). A lower limit
    /// than the last sample waits until the output is silent, so that it never makes a step: the caller
    /// stops the drive.
    void limit(double limit_V) noexcept;
    /// The next samples, in volts.
    void fill(std::span<double> volts) noexcept;
    /// Advances by `samples` samples without output, for time that the device lost.
    void skip(std::int64_t samples) noexcept;
    /// For an underrun of `samples` samples: advances as skip() does, is silent from there on, and
    /// drops a waiting command. change() reports a change to no volts with a ramp of 0 samples.
    void silence(std::int64_t samples) noexcept;
    /// From the next sample on, multiplies the signal by a raised cosine from 1 to 0 over `samples` (at least
    /// 1); then silence. A ramp of the volts stands still, so that the envelope never grows; ramp_goes_on: it
    /// does not, as in recordings of before. A ramp of the frequency goes on. Drops a waiting command;
    /// commands are refused until release(). A second stop, also one after a soft stop, that would end
    /// earlier makes the rest of the weight steeper, without a step; a later end is ignored. change() reports
    /// the stop at once.
    void stop(std::int64_t samples, bool ramp_goes_on = false) noexcept;
    /// Goes back to an earlier copy of this synthesiser and fills `volts` from there. Counters and the newest
    /// limit stay.
    void go_back(const Synthesiser& earlier, std::span<double> volts) noexcept;
    /// Accepts commands again after a stop has ended in silence. False while the stop has not ended.
    bool release() noexcept;
    /// True from stop() until release().
    [[nodiscard]] bool stopped() const noexcept { return stopped_; }
    /// True if the next sample is zero, and all that follow until a command takes effect.
    [[nodiscard]] bool silent() const noexcept { return order_ == 0; }
    /// True while a command has not taken effect yet.
    [[nodiscard]] bool waits() const noexcept { return pending_.has_value(); }

    /// The last change that began within the last fill(), skip(), silence(), stop() or set() of a soft stop;
    /// null when none did.
    [[nodiscard]] const DriveChange* change() const noexcept { return reported_ ? &*reported_ : nullptr; }
    /// Number of samples cut at the limit since the start. Must stay 0.
    [[nodiscard]] std::uint64_t clamped() const noexcept { return clamped_; }
    /// Largest |volts| of a sample before it was cut; 0 while none was cut.
    [[nodiscard]] double largest_clamped() const noexcept { return largest_clamped_; }
    /// Number of refused commands: not finite, not playable at this rate, or given during a stop.
    [[nodiscard]] std::uint64_t refused() const noexcept { return refused_; }
    /// Next sample to be filled and its phase.
    [[nodiscard]] DacTick tick() const noexcept { return tick_; }
    [[nodiscard]] Turns phase() const noexcept { return phase_; }
    /// The frequency that is played for a request. It exceeds the request by less than 2^-128 of the
    /// rate, so both are the same double.
    static double realised(double frequency, double rate_hz) noexcept;

private:
    /// Starts the pending change if it is due at this sample. Returns how many of the next `wanted`
    /// samples come before the next possible change.
    std::int64_t next_stretch(std::int64_t wanted) noexcept;
    void begin_change() noexcept;
    void fill_steady(std::span<double> volts) noexcept;
    void fill_ramp(std::span<double> volts) noexcept;
    void skip_ramp(std::int64_t samples) noexcept;
    void end_ramp() noexcept;
    void begin_stop(std::int64_t samples, std::uint64_t sequence, bool ramp_goes_on) noexcept;
    void hold_ramp() noexcept;
    void end_stop() noexcept;
    void put(std::span<const double> block, std::span<double> volts) noexcept;

    double rate_hz_;
    double limit_V_, next_limit_V_;
    double last_V_ = 0;  // the last sample
    DacTick tick_;
    Turns phase_ = 0;
    Turns step_;       // steady state, or before the ramp
    Turns last_step_;  // last increment of phase_: the phase has just wrapped when phase_ < last_step_
    Harmonics<Voltage> volts_;  // steady state, or before the ramp
    int order_ = 0;             // highest harmonic that is not silent, including those at the ramp's end
    DriveChange change_;        // the change that is being ramped, or the last one
    std::optional<DriveChange> reported_;
    bool ramping_ = false;
    bool stopped_ = false, stopping_ = false;
    DacTick stop_first_;
    std::int64_t stop_samples_ = 0;
    /// Angle of the weight's cosine at stop_first_, 2^-64 turns; half a turn is silence.
    std::uint64_t stop_angle_ = 0;
    std::optional<DriveCommand> pending_;
    std::uint64_t clamped_ = 0;
    double largest_clamped_ = 0;
    std::uint64_t refused_ = 0;
};

}  // namespace shaker
