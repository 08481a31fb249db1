#include "daemon/service/live_feed.hpp"

#include <algorithm>

namespace shaker::service {

void LiveSeries::add(double t_s, std::span<const float> values) {
    const std::scoped_lock lock{mutex_};
    if (t_s_.size() < most_) {
        t_s_.push_back(t_s);
        values_.insert(values_.end(), values.begin(), values.end());
    } else {
        const std::size_t at = count_ % most_;
        t_s_[at] = t_s;
        std::ranges::copy(values, values_.begin() + static_cast<std::ptrdiff_t>(at * channels_));
    }
    ++count_;
}

LiveSeries::Part LiveSeries::since(std::uint64_t from) const {
    const std::scoped_lock lock{mutex_};
    const std::uint64_t oldest = count_ - std::min<std::uint64_t>(count_, most_);
    Part part;
    part.gap = from < oldest;
    part.first = std::clamp(from, oldest, count_);
    for (std::uint64_t k = part.first; k < count_; ++k) {
        const std::size_t at = k % most_;
        part.t_s.push_back(t_s_[at]);
        for (std::size_t c = 0; c < channels_; ++c) part.values.push_back(values_[at * channels_ + c]);
    }
    return part;
}

}  // namespace shaker::service
