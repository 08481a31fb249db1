#pragma once
// ConverterMemory: mapped file shared by a mock converter's owner and the PCM plug-in. Clock, faults, stream
// pointers and samples. Lock-free: either side may die at any instruction and the other continues.
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace shaker::mock {

/// One sample of the channels, left-justified codes of 32 bits. Valid for count `index` only.
struct ConverterSlot {
    static constexpr std::int64_t none = -1;
    std::atomic<std::int64_t> index;
    std::atomic<std::int32_t> first, second, third;

    void put(std::int64_t play, std::int32_t a, std::int32_t b, std::int32_t c) noexcept {
        index.store(none, std::memory_order_release);
        first.store(a, std::memory_order_release);
        second.store(b, std::memory_order_release);
        third.store(c, std::memory_order_release);
        index.store(play, std::memory_order_release);
    }
};

/// Two counts. Timeline: samples of the converter's clock; never halts. Play count: the timeline minus the
/// samples of halts; positions of streams use it.
struct ConverterMemory {
    static constexpr std::uint64_t version = 0x73686b6d6f636b03;
    static constexpr std::size_t slots_held = std::size_t{1} << 18U;
    static constexpr std::size_t staged_held = std::size_t{1} << 18U;
    static constexpr std::size_t stalls_held = 256, starts_held = 4096;

    enum class Phase : std::uint64_t { idle = 0, running = 1, ran_dry = 2 };
    struct Stall {
        std::atomic<std::int64_t> from, until;  // timeline
    };

    std::atomic<std::uint64_t> ready;  // == version when everything else is initialised
    double rate_hz, ppm;
    std::int64_t epoch_ns;  // CLOCK_MONOTONIC of timeline sample 0

    // Faults: written by the owner.
    std::atomic<bool> underrun, unplugged;
    std::array<Stall, stalls_held> stalls;
    std::atomic<std::size_t> stall_count;

    // The stream: written by the plug-in, except running -> ran_dry, which either side may set.
    std::atomic<std::uint64_t> state;                           // 4 * (number of changes) + phase
    std::atomic<std::int64_t> start;                            // play count of the stream's frame 0
    std::atomic<std::int64_t> written;                          // frames since `start`: application pointer
    std::atomic<std::int64_t> plays_on;                         // frames after it at which the stream stops
    std::atomic<std::int64_t> buffer_frames;                    // ring size
    std::atomic<bool> silences;                                 // played frames are replaced by zeros
    std::array<std::atomic<std::int64_t>, starts_held> starts;  // play count at which each stream started
    std::atomic<std::uint64_t> start_count, underrun_count;

    std::array<ConverterSlot, slots_held> slots;
    // A write becomes visible at once, like a system call of a kernel PCM, even if its process dies: frames
    // are stored in `staged`, `commit` makes them valid, then they are copied to `slots`.
    std::array<ConverterSlot, staged_held> staged;
    std::atomic<std::uint64_t> commit;  // play count of the first << 20 | number of frames; 0: none

    /// Timeline samples per nanosecond.
    [[nodiscard]] double samples_per_ns() const noexcept { return 1e-9 * rate_hz * (1 + 1e-6 * ppm); }
    /// Number of timeline samples that have ended at this time; the next one is being output.
    [[nodiscard]] std::int64_t due(std::int64_t monotonic_ns) const noexcept {
        return static_cast<std::int64_t>(
            std::floor(samples_per_ns() * static_cast<double>(monotonic_ns - epoch_ns)));
    }
    /// Play count at a sample of the timeline.
    [[nodiscard]] std::int64_t play_count(std::int64_t timeline) const noexcept {
        std::int64_t count = timeline;
        const std::size_t n = stall_count.load(std::memory_order_acquire);
        for (std::size_t i = 0; i < n; ++i) {
            const std::int64_t from = stalls[i].from, until = stalls[i].until;
            if (timeline > from) count -= (timeline < until ? timeline : until) - from;
        }
        return count;
    }
    [[nodiscard]] ConverterSlot& slot(std::int64_t play) noexcept {
        return slots[static_cast<std::size_t>(play) % slots_held];
    }
    void put(std::int64_t play, std::int32_t first, std::int32_t second, std::int32_t third) noexcept {
        slot(play).put(play, first, second, third);
    }
    [[nodiscard]] ConverterSlot& stage(std::int64_t play) noexcept {
        return staged[static_cast<std::size_t>(play) % staged_held];
    }
    /// Makes the staged frames [from, until) valid.
    void publish(std::int64_t from, std::int64_t until) noexcept {
        if (from >= until) return;
        commit = static_cast<std::uint64_t>(from) << 20U | static_cast<std::uint64_t>(until - from);
        for (std::int64_t play = from; play < until; ++play) {
            const ConverterSlot& s = stage(play);
            put(play, s.first, s.second, s.third);
        }
        commit = 0;
    }
    /// Slot of the sample for `play`; its index shows whether it is valid.
    [[nodiscard]] ConverterSlot& heard(std::int64_t play) noexcept {
        const std::uint64_t last = commit;
        const auto from = static_cast<std::int64_t>(last >> 20U);
        const auto until = from + static_cast<std::int64_t>(last & 0xfffffU);
        ConverterSlot& in_flight = stage(play);
        return play >= from && play < until && in_flight.index == play ? in_flight : slot(play);
    }
    /// Erases the samples written for [from, until).
    void erase(std::int64_t from, std::int64_t until) noexcept {
        commit = 0;
        for (std::int64_t play = from; play < until; ++play) slot(play).index.store(ConverterSlot::none);
    }

    [[nodiscard]] static Phase phase(std::uint64_t state) noexcept { return static_cast<Phase>(state % 4); }
    [[nodiscard]] static std::uint64_t changed(std::uint64_t state, Phase to) noexcept {
        return 4 * (state / 4 + 1) + static_cast<std::uint64_t>(to);
    }
    /// Play count at which the stream stops without new data.
    [[nodiscard]] std::int64_t dry_at() const noexcept { return start + written + plays_on; }
    /// The client is gone with all its descriptors: the stream ends before `play`.
    void close(std::int64_t play) noexcept {
        state = changed(state, Phase::idle);
        erase(play, std::max(dry_at(), play) + buffer_frames);
    }
    /// True if the stream whose state was `seen` has no data for `play`. Counted once, by the side that
    /// detects it first.
    bool dry(std::uint64_t seen, std::int64_t play) noexcept {
        if (phase(seen) == Phase::idle || play < dry_at()) return false;
        if (phase(seen) == Phase::ran_dry) return true;
        if (!state.compare_exchange_strong(seen, changed(seen, Phase::ran_dry))) return dry(seen, play);
        ++underrun_count;
        return true;
    }
};
static_assert(std::atomic<std::int64_t>::is_always_lock_free && std::atomic<bool>::is_always_lock_free);

}  // namespace shaker::mock
