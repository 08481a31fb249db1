#pragma once
// World: the simulated bench as a Rig on virtual time. DAC samples in, accelerometer blocks and frames out.
#include <memory>
#include <vector>

#include "drivers/devices.hpp"
#include "drivers/simulated/scene.hpp"
#include "drivers/time.hpp"

namespace shaker::simulated {

/// True positions of base and walker in the middle of one exposure, m on the shaker's axis.
struct PoseTruth {
    CameraTick tick;
    MasterTime time;
    double base = 0;
    double walker = 0;
};

/// What v_D means, without errors: the slope of the straight line through the walker's mean positions in the
/// periods between two times (s), m/s; NaN if a time is outside the exposures. A correction of the drive
/// moves the walker within its period and changes its drift. The way between two instants has both: the first
/// is no drift, and a drift that changes has another mean than slope. At least 2 periods; a part of a period
/// is shared among them.
double drift_velocity(const std::vector<PoseTruth>& poses, double from_s, double to_s, double frequency_hz);

/// One virtual bench; must outlive the devices it returns. Deterministic: equal scene and samples give equal
/// bytes, in any threads. Virtual time advances only when the DAC is written.
class World {
public:
    /// lockstep: sensors are read in the thread that writes the DAC, so write() never waits; when the queue
    /// of a sensor is full, data are dropped and marked. paced, for threads: write() waits until the reader
    /// of every sensor has taken the data that are due, and the accelerometer's reader asks for the next
    /// block. No reader is late in virtual time because the computer is slow. stop() of any device ends the
    /// wait.
    enum class Pace { lockstep, paced };
    explicit World(const Scene& scene, Pace pace = Pace::lockstep);
    ~World();
    World(const World&) = delete;
    World& operator=(const World&) = delete;
    /// The devices: one DAC, one accelerometer, the scene's cameras.
    Rig rig();
    /// Starts an exposure of camera `index` with the next sample played, as a camera that runs on its own
    /// clock does.
    void expose_next(std::size_t index);
    /// True positions at the exposures of camera `index`, in order of their ticks.
    [[nodiscard]] std::vector<PoseTruth> truth(std::size_t index) const;
    /// Discards truth older than this from now on. Default: all is kept.
    void keep_truth_for(double seconds);
    /// Puts the walker at rest in the middle of its base, also one that was taken off.
    void put_walker_back();
    /// CPU time spent on rendering so far, s.
    [[nodiscard]] double render_seconds() const;

    struct State;

private:
    std::unique_ptr<State> state_;
};

}  // namespace shaker::simulated
