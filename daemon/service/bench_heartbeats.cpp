#include "daemon/service/bench_heartbeats.hpp"

#include <utility>

namespace shaker::service {

void BenchHeartbeats::follow(const acquisition::Channels& channels, const run::Recordings& recordings) {
    const std::int64_t gathered = channels.gathered;
    if (std::exchange(gathered_, gathered) != gathered) output_.beat();
    const bool finishing = recordings.finishing();
    const std::uint64_t progress = recordings.progress();
    const bool moved = std::exchange(progress_, progress) != progress;
    const bool began = !std::exchange(finishing_, finishing);
    if (!finishing)
        recorder_.rest();
    else if (moved || began)
        recorder_.beat();
}

}  // namespace shaker::service
