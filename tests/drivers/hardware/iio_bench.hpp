#pragma once
// The driver with a mock iiod that receives the pattern at 4 kHz.
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "drivers/hardware/iio/iio_accelerometer.hpp"
#include "tests/support/devices/iiod_pattern.hpp"

namespace shaker::test {

inline iio::IioSettings settings_for(const mock::Iiod& iiod) {
    iio::IioSettings s;
    s.uri = "ip:127.0.0.1:" + std::to_string(iiod.port());
    s.kernel_buffers = 64;  // 1 s at 4 kHz: stalls of this machine lose nothing
    return s;
}

/// Reads samples and compares each tick with the sample's number.
class Reading {
public:
    explicit Reading(Accelerometer& device) : device_{device} {}

    /// Reads until a sample with at least this number arrives; false after 200 waits of 50 ms.
    bool until(std::int64_t number) {
        int waits = 0;
        while (last_ < number && waits < 200) waits += step(std::chrono::milliseconds{50}) ? 0 : 1;
        return last_ >= number;
    }
    bool step(std::chrono::milliseconds wait) {
        AccelBlock block;
        if (!device_.read(block, wait)) return false;
        check(block);
        blocks.push_back(block);
        return true;
    }
    /// Number of the sample at tick 0.
    [[nodiscard]] std::int64_t first() const { return first_.value_or(-1); }
    [[nodiscard]] std::int64_t last() const { return last_; }
    [[nodiscard]] std::size_t samples() const { return samples_; }
    /// Number of ticks missing between blocks.
    [[nodiscard]] std::int64_t missing() const {
        return last_ - first() + 1 - static_cast<std::int64_t>(samples_);
    }

    std::vector<AccelBlock> blocks;
    std::int64_t wrong = 0;     // samples with a tick unequal to their number, or not in the pattern
    std::int64_t gaps = 0;      // blocks marked as coming after a gap
    std::int64_t unmarked = 0;  // blocks after a gap without a mark
    std::int64_t off_by = 0;    // the largest |tick - number|
    std::int64_t ragged = 0;    // short blocks without a gap after them

private:
    void check(const AccelBlock& block) {
        if (!first_) first_ = numbered(block.counts[0]) - block.first.n;
        const bool gap = has(block.quality, Quality::gap);
        gaps += gap ? 1 : 0;
        if (!blocks.empty()) {
            const AccelBlock& before = blocks.back();
            const bool follows = block.first.n == before.first.n + before.size;
            if (!follows && !gap) ++unmarked;
            if (before.size < AccelBlock::capacity && !gap) ++ragged;
        }
        for (int i = 0; i < block.size; ++i) {
            const std::int64_t n = numbered(block.counts[static_cast<std::size_t>(i)]);
            const std::int64_t off = block.first.n + i + *first_ - n;
            if (n < 0 || off != 0) ++wrong;
            off_by = std::max(off_by, off < 0 ? -off : off);
            last_ = std::max(last_, n);
        }
        samples_ += static_cast<std::size_t>(block.size);
    }

    Accelerometer& device_;
    std::optional<std::int64_t> first_;
    std::int64_t last_ = -1;
    std::size_t samples_ = 0;
};

/// Mock, feeder and driver. With the default settings, pauses of the machine of some seconds cause no loss
/// and no broken connection.
struct IioBench {
    explicit IioBench(const mock::IiodDescription& description = {.fifo = 65536}) : iiod{description} {}

    void open(iio::IioStamps stamps = iio::IioStamps::host, double timeout_s = 10, double give_up_s = 30) {
        iio::IioSettings s = settings_for(iiod);
        s.stamps = stamps;
        s.timeout_s = timeout_s;
        s.give_up_s = give_up_s;
        device = open_iio_accelerometer(s, &notes);
        reading.emplace(*device);
    }
    /// Reads samples for `seconds`.
    bool read_for(double seconds) {
        return reading->until(feeder.pushed() + static_cast<std::int64_t>(seconds * 4000));
    }

    mock::Iiod iiod;
    PatternFeeder feeder{iiod, 4000};
    std::unique_ptr<Accelerometer> device;
    std::vector<std::string> notes;
    std::optional<Reading> reading;
};

}  // namespace shaker::test
