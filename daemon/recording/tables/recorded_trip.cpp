#include "daemon/recording/tables/recorded_trip.hpp"

#include <spdlog/fmt/fmt.h>

#include <cmath>

namespace shaker::recording {

std::string text(const RecordedTrip& trip) {
    const std::string when = std::isfinite(trip.at_s) ? fmt::format("at {:.3f} s ", trip.at_s) : "";
    return fmt::format("{}in state {}: {}", when, trip.state, text(trip.trip));
}

}  // namespace shaker::recording
