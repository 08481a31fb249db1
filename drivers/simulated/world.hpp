#pragma once
// The simulated bench as a Rig: DAC samples in, accelerometer blocks and frames out, on virtual time.
#include <memory>
#include <vector>

#include "drivers/devices.hpp"
#include "drivers/simulated/scene.hpp"
#include "drivers/simulated/truth.hpp"

namespace shaker {

/// One virtual bench; it outlives the devices it hands out. Everything is deterministic: same scene, same
/// samples in, same bytes out, whatever thread calls. Virtual time moves only when the DAC is written.
class World {
public:
    /// lockstep: sensors are read in the thread that writes the DAC, so write() never waits; what is not read
    /// is dropped when a sensor's queue is full, and marked. paced: write() waits until every sensor's reader
    /// has taken what is due, and the accelerometer's has done with it and asks for more, as threads need it:
    /// nobody is late in virtual time because a computer was; stop() of any device ends the waiting.
    enum class Pace { lockstep, paced };
    explicit World(const Scene& scene, Pace pace = Pace::lockstep);
    ~World();
    World(const World&) = delete;
    World& operator=(const World&) = delete;
    /// The devices: one DAC, one accelerometer, the scene's cameras.
    Rig rig();
    /// The next sample that is played starts an exposure of camera `index`, as a camera has that runs by its
    /// own clock.
    void expose_next(std::size_t index);
    /// Truth of the exposures of camera `index` so far, in order of their ticks.
    [[nodiscard]] std::vector<PoseTruth> truth(std::size_t index) const;
    /// From now on what is older than so many seconds may be forgotten. Without it all is kept.
    void keep_truth_for(double seconds);
    /// CPU time spent on rendering so far, s.
    [[nodiscard]] double render_seconds() const;

    struct State;

private:
    std::unique_ptr<State> state_;
};

}  // namespace shaker
