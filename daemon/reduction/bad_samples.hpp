#pragma once
// Bad accelerometer samples: single ones and frozen stretches are left out of the base's motion.
#include <cstddef>
#include <string>
#include <vector>

#include "daemon/reduction/aligner.hpp"
#include "daemon/reduction/measurement.hpp"

namespace shaker::reduction {

/// Accelerometer samples in the time of the cameras that do not follow the base's motion.
struct BadSamples {
    std::size_t tested = 0;   // number of samples in that time
    std::size_t single = 0;   // far from the fitted motion
    std::size_t frozen = 0;   // repeats of one value while the base moves
    bool same_phase = false;  // they come at the same phase of the period
    [[nodiscard]] std::size_t count() const noexcept { return single + frozen; }
    /// More than 1 % of the samples, or at the same phase: what remains may be biased.
    [[nodiscard]] bool degrade() const noexcept {
        return same_phase || 100 * static_cast<double>(count()) > static_cast<double>(tested);
    }
};

/// align() without bad samples, which are removed from `m`. The alignment is repeated only when some are
/// found.
///
/// A sample is bad when a residual of the fit of the base's motion, along or across the shaker's axis,
/// exceeds 8 standard deviations (from their median absolute value) and 5 % of gamma; a smaller deviation of
/// a sample has no effect on the results. A run of 4 or more equal values of one sensor axis is frozen when
/// one of its samples is bad, or when the base's motion changes by a quarter of its range meanwhile. The
/// samples have the same phase when so many of their groups begin within 1/64 of a period that chance
/// explains it with a probability below 1e-3 (three of three do).
///
/// Adds a note when more than 0.1 % of the samples are bad or when they degrade the result. Throws InputError
/// as align() does, and when more than half of the samples are bad.
Alignment align_without_bad_samples(Measurement& m, BadSamples& found, std::vector<std::string>& notes);

}  // namespace shaker::reduction
