#pragma once
// Held drive: while the error of a locked drive is noise, corrections would only add it to the motion.
#include "drivers/drive.hpp"

namespace shaker::control {

inline constexpr int longest_hold = 100;  // windows

/// Mean error of the windows of one drive, and how much of it to correct: so much that the drive becomes the
/// mean of the windows before it and of its own.
class HeldDrive {
public:
    /// Starts a block. windows: the number of windows that the drive is the mean of.
    void begin(int windows);
    /// Adds the error of a window (m/s^2); noise: sd of one part of an amplitude. True when the mean of at
    /// least ten windows stands out (8 sd of the mean in one of the first `harmonics`), or after
    /// longest_hold windows: then the drive is to be corrected by `correction()`, and the next block begins.
    bool add(const Harmonics<Acceleration>& error, double noise, int harmonics);
    /// The part of the last block's mean error to correct, m/s^2.
    [[nodiscard]] const Harmonics<Acceleration>& correction() const noexcept { return correction_; }

private:
    int worth_ = 0, count_ = 0;
    Harmonics<Acceleration> sum_, correction_;
};

}  // namespace shaker::control
