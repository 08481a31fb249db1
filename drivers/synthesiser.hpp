#pragma once
// Harmonics of voltage to samples on one 64-bit integer phase. Real-time: nothing here allocates, locks or logs.
#include <cstdint>
#include <span>

#include "drivers/drive.hpp"
#include "drivers/time.hpp"

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
    DacTick first;            // first sample of the ramp: a start of a period
    std::int64_t ramp = 0;    // samples
    std::uint64_t phase = 0;  // at `first`; 2^64 is one turn
    std::uint64_t step = 0;   // phase a sample after the ramp
};

/// Fills blocks of samples. Starts silent at phase 0; a command is taken at the next start of a period (the first
/// sample whose phase wrapped) and ramped in as complex coefficients, with the frequency ramped beside them.
class Synthesiser {
public:
    /// rate_hz: samples a second; frequency: of the silent start; limit_V: no sample leaves beyond +-limit_V.
    Synthesiser(double rate_hz, double frequency, double limit_V);

    /// The next command; replaces one that has not been taken yet. Non-finite values are refused (counted).
    void set(const DriveCommand& command) noexcept;
    /// The next samples, in volts.
    void fill(std::span<double> volts) noexcept;

    /// Last change that began inside the last fill(); null when none did.
    [[nodiscard]] const DriveChange* change() const noexcept;
    /// Samples cut at the limit since the start. Must stay 0.
    [[nodiscard]] std::uint64_t clamped() const noexcept;
    /// Commands refused because they were not finite or not playable at this rate.
    [[nodiscard]] std::uint64_t refused() const noexcept;
    /// Next sample to be filled and its phase.
    [[nodiscard]] DacTick tick() const noexcept;
    [[nodiscard]] std::uint64_t phase() const noexcept;
    /// The frequency that is really played for a request: a whole number of 2^-64 turns a sample.
    static double realised(double frequency, double rate_hz) noexcept;

private:
    // (helper: private members are yours)
};

}  // namespace shaker
