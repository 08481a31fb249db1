#pragma once
// A trip as a recording and the results tell it.
#include <string>

#include "daemon/safety/trip.hpp"

namespace shaker::recording {

/// A trip and what the run was at.
struct RecordedTrip {
    safety::Trip trip;
    std::string state;  // of the run: "identify"
    double at_s = 0;    // master time of the sample that violated; NaN while the sensor's clock was not known
};

/// "at 3.021 s in state run: soft stop, ..."
std::string text(const RecordedTrip& trip);

}  // namespace shaker::recording
