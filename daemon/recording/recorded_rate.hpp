#pragma once
// Disk space that recordings take.
#include <cmath>

#include "drivers/recorded/recording_file.hpp"

namespace shaker::recording {

/// Rates of the newest complete recording.
struct RecordedRate {
    double bytes_per_s = NAN;     // without pictures; NaN: no recording was completed yet
    double pictures_per_s = NAN;  // bytes of its pictures per second
    recorded::KeptPictures pictures{};
    double lasted_s = NAN;  // its length; NaN: not known
};

}  // namespace shaker::recording
