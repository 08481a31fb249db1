#pragma once
// Targets that a picture shows: a start for the description of a view.
#include <string>
#include <vector>

#include "drivers/data.hpp"
#include "drivers/view.hpp"

namespace shaker::tracking {

struct Proposals {
    std::vector<Target> targets;       // each is accepted by a ViewTracker; lengths in px
    std::vector<std::string> refused;  // "a disc of 31 px at 204, 88: " and why it cannot be followed
};

/// Discs, dots (also in a row), rectangles, bars and codes across x that stand out from their surroundings,
/// the largest first. Their names are their kinds with a number.
Proposals proposed_targets(const ImageView& image);

}  // namespace shaker::tracking
