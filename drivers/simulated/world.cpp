#include "drivers/simulated/world.hpp"

#include <algorithm>
#include <condition_variable>
#include <ctime>
#include <deque>
#include <mutex>
#include <utility>

#include "drivers/errors.hpp"
#include "drivers/frame_pool.hpp"
#include "drivers/simulated/renderer.hpp"
#include "drivers/simulated/sensor.hpp"
#include "drivers/simulated/shaker_plant.hpp"

namespace shaker {

namespace {
constexpr std::size_t queue_limit = 4096;
constexpr int pool_frames = 256;  // of each camera
// Chebyshev's instants in an exposure, as a share of it: their plain mean is exact for motion of third order
// in time.
constexpr std::array<double, 3> instants{0.14644660940672624, 0.5, 0.85355339059327376};

double cpu_seconds() {
    timespec t{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

struct Exposure {
    CameraTick tick;
    double start_s = 0;
    std::array<Pose, 3> poses{};
    std::size_t seen = 0;
    Quality quality{};
    bool lost = false;   // by a fault of the camera
    bool walker = true;  // is to be seen
};

struct Output {
    double volts = 0;
    bool trigger = false;
};

// Value at share u of a sample from positions and velocities at its ends.
double hermite(double x0, double v0, double x1, double v1, double h, double u) {
    const double s = 1 - u;
    return x0 * s * s * (1 + 2 * u) + x1 * u * u * (3 - 2 * u) + h * u * s * (v0 * s - v1 * u);
}
}  // namespace

struct World::State {
    struct Eye {
        CameraTruth truth;
        Renderer renderer;
        LastingFaults faults;
        FaultQueue losses;
        CameraTick next{};
        bool expose = false;  // with the next sample, without a trigger
        std::deque<Exposure> open{}, done{};
        std::vector<PoseTruth> poses{};
        bool gap = false;  // frames are missing before the next one
        double render_s = 0;
    };
    Scene scene;
    Pace pace;
    ShakerPlant plant;
    AccelerometerModel sensor;
    std::vector<Eye> eyes{};
    std::deque<AccelBlock> blocks{};
    std::deque<Output> buffer;  // written and not heard yet
    std::int64_t n;             // sample to be heard next; below 0 while the buffer fills
    DeviceCounts dac_counts{};
    FaultQueue plant_faults, underruns;
    bool overflow = false;
    bool stopped = false;
    mutable std::mutex mutex{};
    std::condition_variable moved{};

    explicit State(const Scene& s, Pace p)
        : scene{s},
          pace{p},
          plant{s},
          sensor{s},
          buffer(static_cast<std::size_t>(std::lround(s.dac_buffer_s * s.dac_rate_hz))),
          n{-static_cast<std::int64_t>(buffer.size())},
          plant_faults{s.faults, {FaultKind::amplifier_gain, FaultKind::walker_off, FaultKind::walker_on}},
          underruns{s.faults, {FaultKind::underrun}} {
        for (const CameraTruth& c : s.cameras) {
            const std::string& name = c.view.camera;
            eyes.push_back({.truth = c,
                            .renderer = Renderer{c, s.walker, s.seed + 1000 * (1 + eyes.size())},
                            .faults = {s.faults, {FaultKind::camera_stall, FaultKind::walker_hidden}, name},
                            .losses = {s.faults, {FaultKind::camera_lose}, name}});
        }
    }
    [[nodiscard]] double now() const { return static_cast<double>(n) / scene.dac_rate_hz; }
    [[nodiscard]] double due(const Eye& eye, const Exposure& e) const {
        return e.start_s + eye.truth.view.exposure_s + eye.truth.latency_s;
    }
    [[nodiscard]] bool accel_ready() const {
        return !blocks.empty() && blocks.front().arrived <= host_time(now());
    }
    [[nodiscard]] bool frame_ready(const Eye& eye) const {
        return !eye.done.empty() && due(eye, eye.done.front()) <= now();
    }
    [[nodiscard]] bool all_read() const {
        return !accel_ready() && std::ranges::none_of(eyes, [&](const Eye& e) { return frame_ready(e); });
    }
    [[nodiscard]] std::int64_t next_written() const { return n + static_cast<std::int64_t>(buffer.size()); }
    void play(const Output& out);
    std::int64_t run_empty(std::int64_t block);
    void step(const Output& out);
    void cause_faults();
    void open_exposures(bool trigger);
    void expose(Eye& eye, const PlantState& before);
    void stop() noexcept {
        const std::scoped_lock lock{mutex};
        stopped = true;
        moved.notify_all();
    }
};

void World::State::play(const Output& out) {
    buffer.push_back(out);
    step(buffer.front());
    buffer.pop_front();
}

// When the DAC runs empty before the end of a block that is now due: plays silence for the block and for the
// time lost behind it, which is returned (samples); else 0.
std::int64_t World::State::run_empty(std::int64_t block) {
    std::int64_t lost = 0;
    while (const SceneFault* f =
               underruns.take(static_cast<double>(next_written() + block - 1) / scene.dac_rate_hz))
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
    for (Eye& eye : eyes) {
        if (!std::exchange(eye.expose, false) && !trigger) continue;
        const bool lost = eye.losses.take(now()) != nullptr || eye.faults.at(FaultKind::camera_stall, now());
        const bool walker = plant.has_walker() && !eye.faults.at(FaultKind::walker_hidden, now());
        eye.open.push_back({.tick = eye.next, .start_s = now(), .lost = lost, .walker = walker});
        ++eye.next.n;
    }
}

void World::State::step(const Output& out) {
    cause_faults();
    open_exposures(out.trigger);
    const PlantState before = plant.state();
    const double limit = scene.dac_full_scale_v;
    plant.step(std::clamp(out.volts, -limit, limit));
    for (Eye& eye : eyes) expose(eye, before);
    ++n;
    if (auto block = sensor.step(n, plant.state().a)) {
        if (overflow) block->quality = block->quality | Quality::gap;
        overflow = blocks.size() >= queue_limit;
        if (!overflow) blocks.push_back(*block);
    }
}

// Takes the poses of the instants that fall into the sample just played.
void World::State::expose(Eye& eye, const PlantState& before) {
    const PlantState& after = plant.state();
    const double h = 1 / scene.dac_rate_hz, exposure_s = eye.truth.view.exposure_s;
    for (Exposure& e : eye.open) {
        for (; e.seen < instants.size(); ++e.seen) {
            const double u = (e.start_s + instants[e.seen] * exposure_s - now()) / h;
            if (u > 1) break;
            e.poses[e.seen] = {
                hermite(before.x, before.v, after.x, after.v, h, u),
                hermite(before.walker_x, before.walker_v, after.walker_x, after.walker_v, h, u)};
        }
    }
    while (!eye.open.empty() && eye.open.front().seen == instants.size()) {
        Exposure e = eye.open.front();
        eye.open.pop_front();
        eye.poses.push_back(
            {e.tick, master_time(e.start_s + 0.5 * exposure_s), e.poses[1].base, e.poses[1].walker});
        if (std::exchange(eye.gap, e.lost || eye.done.size() >= queue_limit)) e.quality = Quality::gap;
        if (!eye.gap) eye.done.push_back(e);
    }
}

namespace {

class SimulatedDac final : public Dac {
public:
    explicit SimulatedDac(World::State& s) : s_{s} {}
    [[nodiscard]] DacInfo info() const override {
        return {.name = "simulated DAC",
                .rate_hz = s_.scene.dac_rate_hz,
                .full_scale_V = s_.scene.dac_full_scale_v};
    }
    [[nodiscard]] DeviceCounts counts() const noexcept override {
        const std::scoped_lock lock{s_.mutex};
        DeviceCounts counts = s_.dac_counts;
        counts.taken = static_cast<std::uint64_t>(std::max<std::int64_t>(s_.n, 0)) - counts.lost;
        return counts;
    }
    PlayTime write(std::span<const double> volts, std::span<const double> trigger) override {
        if (volts.size() != trigger.size()) throw DeviceError{"simulated DAC: channels of different length"};
        std::unique_lock lock{s_.mutex};
        const std::int64_t first = s_.next_written();
        PlayTime played{DacTick{first}, host_time(static_cast<double>(first) / s_.scene.dac_rate_hz)};
        played.lost = s_.run_empty(static_cast<std::int64_t>(volts.size()));
        for (std::size_t i = 0; i < volts.size() && played.lost == 0; ++i)
            s_.play({volts[i], trigger[i] > 0.5});
        s_.moved.notify_all();
        if (s_.pace == World::Pace::paced) s_.moved.wait(lock, [&] { return s_.stopped || s_.all_read(); });
        return played;
    }
    void stop() noexcept override { s_.stop(); }

private:
    World::State& s_;
};

class SimulatedAccelerometer final : public Accelerometer {
public:
    explicit SimulatedAccelerometer(World::State& s) : s_{s} {}
    [[nodiscard]] AccelerometerInfo info() const override { return s_.sensor.info(); }
    [[nodiscard]] DeviceCounts counts() const noexcept override {
        const std::scoped_lock lock{s_.mutex};
        return counts_;
    }
    bool read(AccelBlock& block, std::chrono::milliseconds wait) override {
        std::unique_lock lock{s_.mutex};
        s_.moved.wait_for(lock, wait, [&] { return s_.stopped || s_.accel_ready(); });
        if (!s_.accel_ready()) return false;
        block = s_.blocks.front();
        s_.blocks.pop_front();
        counts_.taken += static_cast<std::uint64_t>(block.size);
        counts_.lost += static_cast<std::uint64_t>(block.first.n - next_);
        next_ = block.first.n + block.size;
        s_.moved.notify_all();
        return true;
    }
    [[nodiscard]] bool ended() const noexcept override {
        const std::scoped_lock lock{s_.mutex};
        return s_.stopped && !s_.accel_ready();
    }
    void stop() noexcept override { s_.stop(); }

private:
    World::State& s_;
    DeviceCounts counts_;
    std::int64_t next_ = 0;
};

class SimulatedCamera final : public Camera {
public:
    SimulatedCamera(World::State& s, std::size_t index)
        : s_{s}, eye_{s.eyes[index]}, pool_{pool_frames, eye_.truth.width, eye_.truth.height, 1} {}
    [[nodiscard]] const View& view() const override { return eye_.truth.view; }
    [[nodiscard]] DeviceCounts counts() const noexcept override {
        const std::scoped_lock lock{s_.mutex};
        return counts_;
    }
    FramePtr read(std::chrono::milliseconds wait) override {
        Exposure e;
        {
            std::unique_lock lock{s_.mutex};
            s_.moved.wait_for(lock, wait, [&] { return s_.stopped || s_.frame_ready(eye_); });
            if (!s_.frame_ready(eye_)) return nullptr;
            e = eye_.done.front();
            eye_.done.pop_front();
            s_.moved.notify_all();
        }
        const double before = cpu_seconds();
        const std::shared_ptr<Frame> frame = pool_.acquire();
        if (frame == nullptr) {  // all buffers are with readers: this exposure is lost
            lost_ = true;
            return nullptr;
        }
        if (std::exchange(lost_, false)) e.quality = e.quality | Quality::gap;
        frame->tick = e.tick;
        frame->arrived = host_time(s_.due(eye_, e));
        frame->mid_exposure = master_time(e.start_s + 0.5 * eye_.truth.view.exposure_s);
        frame->quality = e.quality;
        eye_.renderer.render(e.poses, e.tick, frame->pixels, e.walker);
        const std::scoped_lock lock{s_.mutex};
        eye_.render_s += cpu_seconds() - before;
        ++counts_.taken;
        counts_.lost += static_cast<std::uint64_t>(e.tick.n - next_);
        next_ = e.tick.n + 1;
        return frame;
    }
    [[nodiscard]] bool ended() const noexcept override {
        const std::scoped_lock lock{s_.mutex};
        return s_.stopped && !s_.frame_ready(eye_);
    }
    void stop() noexcept override { s_.stop(); }

private:
    World::State& s_;
    World::State::Eye& eye_;
    FramePool pool_;
    bool lost_ = false;
    DeviceCounts counts_;
    std::int64_t next_ = 0;
};

}  // namespace

World::World(const Scene& scene, Pace pace) : state_{std::make_unique<State>(scene, pace)} {}
World::~World() = default;

Rig World::rig() {
    Rig rig;
    rig.name = "sim:";
    rig.dac = std::make_unique<SimulatedDac>(*state_);
    rig.accelerometer = std::make_unique<SimulatedAccelerometer>(*state_);
    for (std::size_t i = 0; i < state_->eyes.size(); ++i)
        rig.cameras.push_back(std::make_unique<SimulatedCamera>(*state_, i));
    return rig;
}

void World::expose_next(std::size_t index) {
    const std::scoped_lock lock{state_->mutex};
    state_->eyes.at(index).expose = true;
}

std::vector<PoseTruth> World::truth(std::size_t index) const {
    const std::scoped_lock lock{state_->mutex};
    return state_->eyes.at(index).poses;
}

double World::render_seconds() const {
    const std::scoped_lock lock{state_->mutex};
    double sum = 0;
    for (const State::Eye& eye : state_->eyes) sum += eye.render_s;
    return sum;
}

}  // namespace shaker
