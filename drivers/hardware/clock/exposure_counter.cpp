#include "drivers/hardware/clock/exposure_counter.hpp"

#include <algorithm>
#include <cstdlib>

namespace shaker::hardware {
namespace {
constexpr std::int64_t clock_jump_ns = 500'000'000;
}

std::int64_t ExposureCounter::periods(std::int64_t ns) const noexcept {
    if (period_ns_ <= 0) return 1;
    return std::max<std::int64_t>(1, (ns + period_ns_ / 2) / period_ns_);
}

/// Steps of the ids since the last picture; 1 when there are no ids.
std::int64_t ExposureCounter::id_step(const ExposureSign& sign) noexcept {
    constexpr std::uint64_t largest = 65535;
    if (!sign.id || !last_->sign.id) return 1;
    const std::uint64_t id = *sign.id, before = *last_->sign.id;
    if (id > largest || before > largest) wide_ = true;
    if (wide_) return id > before ? static_cast<std::int64_t>(id - before) : 1;
    if (id == 0 || before == 0) return 1;
    const std::uint64_t step = (id + largest - before) % largest;
    return static_cast<std::int64_t>(std::max<std::uint64_t>(step, 1));
}

ExposurePlace ExposureCounter::next(const ExposureSign& sign) noexcept {
    ExposurePlace place;
    if (!last_) {
        last_ = Last{sign, 0};
        reopened_ = false;
        return place;
    }
    const std::int64_t host_ns = (sign.arrived - last_->sign.arrived).count();
    const std::int64_t by_id = reopened_ ? 1 : id_step(sign);
    std::optional<std::int64_t> stamp_ns;
    if (sign.stamp && last_->sign.stamp) stamp_ns = sign.stamp->n - last_->sign.stamp->n;
    if (stamp_ns && std::abs(*stamp_ns - host_ns) > clock_jump_ns) {
        // A picture that only arrived late has the stamp expected for its id.
        const bool late = !reopened_ && std::abs(*stamp_ns - by_id * period_ns_) < period_ns_ / 2;
        place.clock_jumped = !late;
        if (!late) stamp_ns.reset();
    }
    const std::int64_t passed_ns = stamp_ns.value_or(host_ns);
    std::int64_t step = by_id;
    const bool pause = !reopened_ && pause_ns_ > 0 && by_id == 1 && stamp_ns.value_or(0) > pause_ns_;
    if (reopened_)
        step = periods(passed_ns);
    else if (stamp_ns && !pause)
        step = std::max(by_id, periods(passed_ns));
    place.tick = {last_->tick + step};
    place.missed = step - 1;
    place.gap = step > 1 || pause || place.clock_jumped || reopened_;
    reopened_ = false;
    last_ = Last{sign, place.tick.n};
    return place;
}

}  // namespace shaker::hardware
