#include "drivers/walker/mu_history.hpp"

#include <algorithm>
#include <cmath>

namespace shaker::walker {

MuHistory::MuHistory(const MuChange& change, double period)
    : change_{change},
      period_{period},
      renewal_{std::sqrt((1 - change.memory) * (1 + change.memory))},
      random_{change.seed} {}

double MuHistory::next() {
    if (change_.none()) return 1;
    if (change_.jitter > 0) {
        const double n = normal_(random_);
        z_ = k_ == 0 ? n : change_.memory * z_ + renewal_ * n;
    }
    const double relaxed = 1 + change_.relaxation * std::exp(-k_ * period_ / change_.relaxation_s);
    k_ += 1;
    return relaxed * std::max(0.1, 1 + change_.jitter * z_);
}

}  // namespace shaker::walker
