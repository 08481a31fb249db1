#pragma once
// State of a simulated bench: plant, sensors and queues, advanced by one DAC sample at a time.
#include <array>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <limits>
#include <mutex>
#include <vector>

#include "drivers/simulated/renderer.hpp"
#include "drivers/simulated/sensor.hpp"
#include "drivers/simulated/shaker_plant.hpp"
#include "drivers/simulated/world.hpp"
#include "drivers/time.hpp"

namespace shaker::simulated {

/// One picture between trigger and reader. Its poses are at Chebyshev times in the exposure: their mean is
/// exact for motion of third order in time.
struct Exposure {
    CameraTick tick;
    double start_s = 0;
    std::array<Pose, 3> poses{};
    std::size_t seen = 0;
    Quality quality{};
    bool lost = false;   // by a fault of the camera
    bool walker = true;  // visible
};

/// One sample of the DAC.
struct PlayedOutput {
    double volts = 0;
    bool trigger = false;
    bool enabled = false;  // the enable tone of the amplifier sounds
};

/// Members that are not const are guarded by `mutex`.
struct World::State {
    struct SimulatedView {
        CameraTruth truth;
        Renderer renderer;
        LastingFaults faults;
        FaultQueue losses, ends;
        CameraTick next{};
        bool expose = false;  // start an exposure with the next sample, without a trigger
        std::deque<Exposure> open{}, done{};
        std::vector<PoseTruth> poses{};
        bool gap = false;  // frames are missing before the next one
        double render_s = 0;
    };
    Scene scene;
    Pace pace;
    ShakerPlant plant;
    AccelerometerModel sensor;
    std::vector<SimulatedView> views{};
    std::deque<AccelBlock> blocks{};
    std::deque<std::array<std::int32_t, 3>> early{};  // samples of blocks that are held back
    std::size_t queue, kept;          // samples: written and not played; of these, not to be taken back
    std::deque<PlayedOutput> buffer;  // written and not played yet; shorter than `queue` after a take back
    std::int64_t n;                   // next sample to play; < 0 while the buffer fills
    DeviceCounts dac_counts{};
    FaultQueue plant_faults, underruns;
    LastingFaults sensor_faults, amplifier_faults;
    std::int64_t enabled_for = 0;  // samples for which the enable tone has sounded
    bool overflow = false;
    bool block_in_hand = false;  // the reader has taken a block and not asked for the next yet
    bool stopped = false;
    double truth_kept_s = std::numeric_limits<double>::infinity();
    mutable std::mutex mutex{};
    std::condition_variable moved{};    // there may be something to read
    std::condition_variable emptied{};  // all of it has been read
    /// Waits until `ready`, at most so long. On virtual time nobody waits, and a look at no time costs as
    /// much as a system call.
    template <class Ready>
    void wait_for(std::unique_lock<std::mutex>& lock, std::chrono::milliseconds wait, Ready ready) {
        if (wait.count() > 0) moved.wait_for(lock, wait, ready);
    }

    void notify_taken() {
        if (all_read()) emptied.notify_all();
    }

    State(const Scene& s, Pace p);
    [[nodiscard]] double now() const { return duration_s(n, scene.dac_rate_hz); }
    [[nodiscard]] double due(const SimulatedView& camera, const Exposure& e) const {
        return e.start_s + camera.truth.view.exposure_s + camera.truth.latency_s;
    }
    [[nodiscard]] bool accel_ready() const;
    [[nodiscard]] bool frame_ready(const SimulatedView& camera) const;
    [[nodiscard]] bool all_read() const;
    [[nodiscard]] std::int64_t next_written() const { return n + static_cast<std::int64_t>(buffer.size()); }
    void play(const PlayedOutput& out);
    std::int64_t take_back(std::int64_t most);
    std::int64_t run_empty(std::int64_t block);
    void step(const PlayedOutput& out);
    [[nodiscard]] bool amplifier_passes(const PlayedOutput& out);
    void cause_faults();
    void open_exposures(bool trigger);
    void expose(SimulatedView& camera, const PlantState& before);
    void forget_old(std::vector<PoseTruth>& poses) const;
    void stop() noexcept;
};

}  // namespace shaker::simulated
