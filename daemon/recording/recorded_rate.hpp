#pragma once
// Disk space that recordings take.
#include <cmath>

#include "drivers/recorded/recording_file.hpp"

namespace shaker::recording {

/// Rate of the newest complete recording.
struct RecordedRate {
    double bytes_per_s = NAN;  // with its pictures; NaN: no recording was completed yet
    recorded::KeptPictures pictures{};
};

}  // namespace shaker::recording
