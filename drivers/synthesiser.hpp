#pragma once
// Harmonics of voltage to samples on one integer phase. Real-time: nothing allocates, locks or logs.
#include <cstdint>
#include <optional>
#include <span>

#include "drivers/drive.hpp"
#include "drivers/time.hpp"
#include "drivers/turns.hpp"

namespace shaker {

/// What the output thread is told: go to these harmonics at this frequency, over `ramp_periods` periods.
struct DriveCommand {
    Harmonics<Voltage> volts;
    double frequency = 20.0;     // Hz
    int ramp_periods = 1;        // >= 1, of the frequency before the change; raised cosine
    std::uint64_t sequence = 0;  // told back when applied
};

/// A command as it was applied: enough, with the one before, to regenerate every sample.
struct DriveChange {
    DriveCommand command;
    DacTick first;          // first sample of the ramp: a start of a period
    std::int64_t ramp = 0;  // samples
    Turns phase = 0;        // at `first`
    Turns step = 0;         // phase a sample after the ramp
    /// > 0: no command but a stop. What was being played, mid-ramp or not, goes on under a weight that falls
    /// from 1 at `first` to 0 this many samples later, where silence begins; `command` has no volts, `ramp`
    /// is 0. In the midst of another stop the weight goes on from where that one had brought it.
    std::int64_t stop = 0;
};

/// Fills blocks of samples. Starts silent at phase 0; a command is taken at the next start of a period (the
/// first sample whose phase wrapped) and ramped in as complex coefficients, with the frequency ramped beside
/// them. A command given during a ramp waits for the start of a period after its end. Samples depend on the
/// commands and the ticks at which they were taken alone, not on the sizes of the blocks nor on the machine.
///
/// Phase is summed in 128 bits and the harmonics read its upper 64. A step is frequency / rate rounded up to
/// 2^-128 turn, so n samples at one frequency are ahead of the exact phase by less than n 2^-128 turn: the
/// harmonics' phase is within 2^-64 turn for ever, and period k of a run at one frequency starts at the
/// sample where it should, the first at or after k rate / frequency, also where that is a whole number. This
/// holds for the first 2^42 samples (3 years at 48 kHz) of any frequency and rate. During a ramp of the
/// frequency the steps on the way are rounded to 2^-64 turn; what follows is exact from where the ramp ended.
class Synthesiser {
public:
    /// rate_hz: samples a second; frequency: of the silent start; limit_V: no sample leaves beyond +-limit_V.
    /// Throws InputError unless rate and limit are positive and the frequency is playable: at least one
    /// period in 2^32 samples, and every harmonic below half the rate.
    Synthesiser(double rate_hz, double frequency, double limit_V);

    /// The next command; replaces one that has not been taken yet. Non-finite values are refused (counted).
    void set(const DriveCommand& command) noexcept;
    /// The next samples, in volts.
    void fill(std::span<double> volts) noexcept;
    /// Goes on as if `samples` samples had been filled, for time the device lost.
    void skip(std::int64_t samples) noexcept;
    /// The device stood empty for `samples`: goes on as skip() does, but silent from there on, and forgets a
    /// command that waits. change() tells it as a change to no volts with a ramp of 0 samples.
    void silence(std::int64_t samples) noexcept;
    /// From the next sample on, whatever would have been played, ramps included, is multiplied by a raised
    /// cosine from 1 to 0 over `samples` (at least 1), then silence. A command that waits is forgotten and
    /// every one given before release() is refused. During a stop, one that would end earlier makes what is
    /// left of the weight steeper, without a step; any other changes nothing. change() tells a stop at once.
    void stop(std::int64_t samples) noexcept;
    /// After a stop has ended in silence: commands are taken again. False when it has not ended yet.
    bool release() noexcept;
    /// A stop is under way, or was and has not been released.
    [[nodiscard]] bool stopped() const noexcept { return stopped_; }
    /// The next sample is zero, and so are all that follow until a command is taken.
    [[nodiscard]] bool silent() const noexcept { return order_ == 0; }

    /// Last change that began inside the last fill(), skip(), silence() or stop(); null when none did.
    [[nodiscard]] const DriveChange* change() const noexcept { return told_ ? &*told_ : nullptr; }
    /// Samples cut at the limit since the start. Must stay 0.
    [[nodiscard]] std::uint64_t clamped() const noexcept { return clamped_; }
    /// Largest |volts| among those that were cut, before they were; 0 when none was.
    [[nodiscard]] double largest_clamped() const noexcept { return largest_clamped_; }
    /// Commands refused because they were not finite or not playable at this rate, or came during a stop.
    [[nodiscard]] std::uint64_t refused() const noexcept { return refused_; }
    /// Next sample to be filled and its phase.
    [[nodiscard]] DacTick tick() const noexcept { return tick_; }
    [[nodiscard]] Turns phase() const noexcept { return phase_; }
    /// The frequency that is really played for a request: above it by less than 2^-128 of the rate, which to
    /// a double is the same number.
    static double realised(double frequency, double rate_hz) noexcept;

private:
    /// Starts the pending change if it is due at this sample; returns how many of the next `wanted` samples
    /// come before anything else can happen.
    std::int64_t next_stretch(std::int64_t wanted) noexcept;
    void begin_change() noexcept;
    void fill_steady(std::span<double> volts) noexcept;
    void fill_ramp(std::span<double> volts) noexcept;
    void skip_ramp(std::int64_t samples) noexcept;
    void end_ramp() noexcept;
    void end_stop() noexcept;
    void put(std::span<const double> block, std::span<double> volts) noexcept;

    double rate_hz_;
    double limit_V_;
    DacTick tick_;
    Turns phase_ = 0;
    Turns step_;                // steady, or before the ramp
    Turns last_step_;           // what led to phase_: the phase has just wrapped when phase_ < last_step_
    Harmonics<Voltage> volts_;  // steady, or before the ramp
    int order_ = 0;             // harmonics that are not silent, those of the ramp's end included
    DriveChange change_;        // whose ramp is played, or was played last
    std::optional<DriveChange> told_;
    bool ramping_ = false;
    bool stopped_ = false, stopping_ = false;
    DacTick stop_first_;
    std::int64_t stop_samples_ = 0;
    std::uint64_t stop_angle_ =
        0;  // of the weight's cosine at stop_first_, 2^-64 turns; silence is at half a turn
    std::optional<DriveCommand> pending_;
    std::uint64_t clamped_ = 0;
    double largest_clamped_ = 0;
    std::uint64_t refused_ = 0;
};

}  // namespace shaker
