#pragma once
// A trip in a recording and in the results.
#include <string>

#include "daemon/safety/trip.hpp"

namespace shaker::recording {

/// A trip with its time and the state of the run.
struct RecordedTrip {
    safety::Trip trip;
    std::string state;  // of the run: "identify"
    double at_s = 0;    // master time of the sample that violated the limit; NaN: clock not known yet
};

/// "at 3.021 s in state run: peak acceleration of the base 61 m/s^2 exceeds the limit of 60 m/s^2; ..."
std::string text(const RecordedTrip& trip);

}  // namespace shaker::recording
