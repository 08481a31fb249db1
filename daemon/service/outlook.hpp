#pragma once
// How long a run takes and how far the walker goes: before it starts, and while it is under way.
#include <optional>

#include "daemon/run/sequence.hpp"
#include "daemon/service/bench_state.hpp"

namespace shaker::service {

/// True if cameras that were opened for `opened` can record `pictures`.
bool recordable(recorded::KeptPictures pictures, recorded::KeptPictures opened) noexcept;
/// What a run at the set-point of `state` takes. opened: pictures for which the cameras were opened.
OutlookState outlook(const BenchState& state, const std::optional<run::PredictedWalk>& walk,
                     recorded::KeptPictures opened);
/// Free space without the part that must stay free, bytes; NaN: not known.
double room_bytes(double free_bytes) noexcept;
/// The progress of the run under way.
ProgressState progress_of(const BenchState& state, const run::Sequence& sequence);

}  // namespace shaker::service
