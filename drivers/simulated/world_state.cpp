#include "drivers/simulated/world_state.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace shaker::simulated {

namespace {
constexpr std::size_t queue_limit = 4096;
// Chebyshev times as shares of an exposure: their mean is exact for motion of third order in time.
constexpr std::array<double, 3> instants{0.14644660940672624, 0.5, 0.85355339059327376};

// Cubic interpolation at share u of a sample, from positions and velocities at its ends.
double hermite(double x0, double v0, double x1, double v1, double h, double u) {
    const double s = 1 - u;
    return x0 * s * s * (1 + 2 * u) + x1 * u * u * (3 - 2 * u) + h * u * s * (v0 * s - v1 * u);
}
}  // namespace

World::State::State(const Scene& s, Pace p)
    : scene{s},
      pace{p},
      plant{s},
      sensor{s},
      queue{static_cast<std::size_t>(std::lround(s.dac_buffer_s * s.dac_rate_hz))},
      kept{std::min(queue, static_cast<std::size_t>(std::lround(s.dac_kept_s * s.dac_rate_hz)))},
      buffer(queue),
      n{-static_cast<std::int64_t>(buffer.size())},
      plant_faults{s.faults, {FaultKind::amplifier_gain, FaultKind::walker_off, FaultKind::walker_on}},
      underruns{s.faults, {FaultKind::underrun}},
      sensor_faults{s.faults, {FaultKind::held_back, FaultKind::late}},
      amplifier_faults{s.faults, {FaultKind::amplifier_off}} {
    for (const CameraTruth& c : s.cameras) {
        const std::string& name = c.view.camera;
        views.push_back({.truth = c,
                         .renderer = Renderer{c, s.walker, s.seed + 1000 * (1 + views.size())},
                         .faults = {s.faults, {FaultKind::camera_stall, FaultKind::walker_hidden}, name},
                         .losses = {s.faults, {FaultKind::camera_lose}, name},
                         .ends = {s.faults, {FaultKind::camera_gone}, name}});
    }
}

bool World::State::accel_ready() const {
    const double late_s = sensor_faults.growth_at(FaultKind::late, now());
    return !blocks.empty() && blocks.front().arrived <= host_time(now() - late_s) &&
           !sensor_faults.at(FaultKind::held_back, now());
}

bool World::State::frame_ready(const SimulatedView& camera) const {
    return !camera.done.empty() && due(camera, camera.done.front()) <= now();
}

bool World::State::all_read() const {
    return !accel_ready() && !block_in_hand &&
           std::ranges::none_of(views, [&](const SimulatedView& e) { return frame_ready(e); });
}

void World::State::stop() noexcept {
    const std::scoped_lock lock{mutex};
    stopped = true;
    moved.notify_all();
    emptied.notify_all();
}

void World::State::play(const PlayedOutput& out) {
    buffer.push_back(out);
    if (buffer.size() <= queue) return;
    step(buffer.front());
    buffer.pop_front();
}

std::int64_t World::State::take_back(std::int64_t most) {
    const auto free = static_cast<std::int64_t>(buffer.size()) - static_cast<std::int64_t>(kept);
    const std::int64_t taken = std::clamp<std::int64_t>(free, 0, std::max<std::int64_t>(most, 0));
    buffer.resize(buffer.size() - static_cast<std::size_t>(taken));
    return taken;
}

// Handles an underrun that is due before the end of a block: plays silence for the block and for the lost
// time after it, whose length (samples) is returned; else 0.
std::int64_t World::State::run_empty(std::int64_t block) {
    std::int64_t lost = 0;
    while (const SceneFault* f = underruns.take(duration_s(next_written() + block - 1, scene.dac_rate_hz)))
        lost += std::llround(f->value);
    if (lost == 0) return 0;
    for (std::int64_t i = 0; i < block + lost; ++i) play({});
    dac_counts.lost += static_cast<std::uint64_t>(lost);
    ++dac_counts.incidents;
    return lost;
}

void World::State::cause_faults() {
    while (const SceneFault* f = plant_faults.take(now())) {
        if (f->what == FaultKind::amplifier_gain)
            plant.set_gain_factor(f->value);
        else
            plant.set_walker(f->what == FaultKind::walker_on);
    }
}

void World::State::open_exposures(bool trigger) {
    for (SimulatedView& camera : views) {
        if (!std::exchange(camera.expose, false) && !trigger) continue;
        const bool lost =
            camera.losses.take(now()) != nullptr || camera.faults.at(FaultKind::camera_stall, now());
        const bool walker = plant.has_walker() && !camera.faults.at(FaultKind::walker_hidden, now());
        camera.open.push_back({.tick = camera.next, .start_s = now(), .lost = lost, .walker = walker});
        ++camera.next.n;
    }
}

bool World::State::amplifier_passes(const PlayedOutput& out) {
    enabled_for = out.enabled ? enabled_for + 1 : 0;
    return duration_s(enabled_for, scene.dac_rate_hz) >= scene.enable_before_s &&
           !amplifier_faults.at(FaultKind::amplifier_off, now());
}

void World::State::step(const PlayedOutput& out) {
    cause_faults();
    open_exposures(out.trigger);
    const PlantState before = plant.state();
    const double limit = scene.dac_full_scale_v;
    plant.step(amplifier_passes(out) ? std::clamp(out.volts, -limit, limit) : 0);
    for (SimulatedView& camera : views) expose(camera, before);
    ++n;
    if (auto block = sensor.step(n, (plant.state().v - before.v) * scene.dac_rate_hz)) {
        if (overflow) block->quality = block->quality | Quality::gap;
        overflow = blocks.size() >= queue_limit;
        if (!overflow) blocks.push_back(*block);
        if (!overflow && sensor_faults.at(FaultKind::held_back, now()))
            early.insert(early.end(), block->counts.begin(), block->counts.begin() + block->size);
    }
}

// Half of them at a time, so that not every exposure moves the rest.
void World::State::forget_old(std::vector<PoseTruth>& poses) const {
    const auto time = [](const PoseTruth& p) { return seconds(p.time); };
    if (time(poses.front()) > now() - 2 * truth_kept_s) return;
    poses.erase(poses.begin(), std::ranges::lower_bound(poses, now() - truth_kept_s, {}, time));
}

// Records the poses for the times within the sample just played.
void World::State::expose(SimulatedView& camera, const PlantState& before) {
    const PlantState& after = plant.state();
    const double h = 1 / scene.dac_rate_hz, exposure_s = camera.truth.view.exposure_s;
    for (Exposure& e : camera.open) {
        for (; e.seen < instants.size(); ++e.seen) {
            const double u = (e.start_s + instants[e.seen] * exposure_s - now()) / h;
            if (u > 1) break;
            e.poses[e.seen] = {
                hermite(before.x, before.v, after.x, after.v, h, u),
                hermite(before.walker_x, before.walker_v, after.walker_x, after.walker_v, h, u)};
        }
    }
    while (!camera.open.empty() && camera.open.front().seen == instants.size()) {
        Exposure e = camera.open.front();
        camera.open.pop_front();
        camera.poses.push_back(
            {e.tick, master_time(e.start_s + 0.5 * exposure_s), e.poses[1].base, e.poses[1].walker});
        forget_old(camera.poses);
        if (std::exchange(camera.gap, e.lost || camera.done.size() >= queue_limit)) e.quality = Quality::gap;
        if (!camera.gap) camera.done.push_back(e);
    }
}

}  // namespace shaker::simulated
