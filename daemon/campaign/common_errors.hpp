#pragma once
// Errors of v_D that a campaign states: by what its measurements together show of their walker.
#include <vector>

#include "daemon/recording/tables/measured_tables.hpp"

namespace shaker::campaign {

/// Gives v_D, D and efficiency of each measurement the error that follows from its own periods and from those
/// of the others at its frequency (reduction::common_sigmas()). What the stated error has beyond the scatter
/// of the periods, as a disagreement of views, stays in it. As they are: a measurement of which no others are
/// known, one without 3 whole periods, and one whose walker was still settling.
void state_common_errors(const std::vector<recording::MeasuredResult*>& measured);

}  // namespace shaker::campaign
