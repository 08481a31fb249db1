#include "drivers/simulated/world.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>
#include <optional>
#include <utility>

#include "drivers/errors.hpp"
#include "drivers/frame_pool.hpp"
#include "drivers/realtime.hpp"
#include "drivers/simulated/true_view.hpp"
#include "drivers/simulated/world_state.hpp"

namespace shaker::simulated {

namespace {

// Mean position of the walker between two times; NaN if one is outside the exposures.
double mean_position(const std::vector<PoseTruth>& poses, double from_s, double to_s) {
    auto next =
        std::ranges::lower_bound(poses, from_s, {}, [](const PoseTruth& p) { return seconds(p.time); });
    if (next == poses.begin()) return NAN;
    const auto at = [&](double t) {
        const auto before = std::prev(next);
        return std::lerp(before->walker, next->walker,
                         (t - seconds(before->time)) / (seconds(next->time) - seconds(before->time)));
    };
    double sum = 0;
    for (double t = from_s; t < to_s; ++next) {
        if (next == poses.end()) return NAN;
        const double end = std::min(seconds(next->time), to_s);
        sum += (end - t) * at((t + end) / 2);
        t = end;
        if (end == to_s) break;
    }
    return sum / (to_s - from_s);
}

constexpr int pool_frames = 256;         // per camera
constexpr double camera_epoch_s = 1000;  // a camera's clock when the DAC begins

class SimulatedDac final : public Dac {
public:
    explicit SimulatedDac(World::State& s) : s_{s} {}
    [[nodiscard]] DacInfo info() const override {
        return {.name = "simulated DAC",
                .rate_hz = s_.scene.dac_rate_hz,
                .full_scale_V = s_.scene.dac_full_scale_v,
                .queue_frames = static_cast<std::int64_t>(s_.queue),
                .kept_frames = static_cast<std::int64_t>(s_.kept),
                .enable_before_s = s_.scene.enable_before_s};
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
        // The first sample of the block while the queue is full; the same sample while it fills up again.
        const std::int64_t first = s_.n + static_cast<std::int64_t>(s_.queue);
        PlayTime played{DacTick{first}, host_time(duration_s(first, s_.scene.dac_rate_hz))};
        if (s_.stopped) return played;  // plays nothing more, so that ended() of the sensors is final
        played.lost = s_.run_empty(static_cast<std::int64_t>(volts.size()));
        for (std::size_t i = 0; i < volts.size() && played.lost == 0; ++i)
            s_.play({volts[i], trigger[i] > 0.5, enabled_});
        s_.moved.notify_all();
        if (s_.pace == World::Pace::paced) s_.emptied.wait(lock, [&] { return s_.stopped || s_.all_read(); });
        return played;
    }
    std::int64_t take_back(std::int64_t most) noexcept override {
        const std::scoped_lock lock{s_.mutex};
        return s_.take_back(most);
    }
    void enable(bool on) noexcept override { enabled_ = on; }
    void stop() noexcept override { s_.stop(); }

private:
    World::State& s_;
    bool enabled_ = false;
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
        if (std::exchange(s_.block_in_hand, false)) s_.notify_taken();
        s_.wait_for(lock, wait, [&] { return s_.stopped || s_.accel_ready(); });
        if (!s_.accel_ready()) return false;
        s_.block_in_hand = true;
        block = s_.blocks.front();
        s_.blocks.pop_front();
        counts_.taken += static_cast<std::uint64_t>(block.size);
        counts_.lost += static_cast<std::uint64_t>(block.first.n - next_);
        next_ = block.first.n + block.size;
        return true;
    }
    std::size_t read_early(std::span<std::array<std::int32_t, 3>> counts) noexcept override {
        const std::scoped_lock lock{s_.mutex};
        const std::size_t n = std::min(counts.size(), s_.early.size());
        const auto end = s_.early.begin() + static_cast<std::ptrdiff_t>(n);
        std::copy(s_.early.begin(), end, counts.begin());
        s_.early.erase(s_.early.begin(), end);
        return n;
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
        : s_{s},
          camera_{s.views[index]},
          layout_{layout_of(camera_.truth, s.scene.walker)},
          noise_seed_{s.scene.seed + 1000 * index},
          boards_{camera_.truth} {
        if (!camera_.truth.view.positions)
            pool_.emplace(pool_frames, camera_.truth.width, camera_.truth.height, 1);
    }
    [[nodiscard]] const View& view() const override { return camera_.truth.view; }
    [[nodiscard]] DeviceCounts counts() const noexcept override {
        const std::scoped_lock lock{s_.mutex};
        return counts_;
    }
    FramePtr read(std::chrono::milliseconds wait) override {
        Exposure e;
        {
            std::unique_lock lock{s_.mutex};
            if (camera_.ends.take(s_.now()) != nullptr) {
                s_.notify_taken();
                throw DeviceError{"camera \"" + camera_.truth.view.camera + "\": it does not answer"};
            }
            s_.wait_for(lock, wait, [&] { return s_.stopped || s_.frame_ready(camera_); });
            if (!s_.frame_ready(camera_)) return nullptr;
            e = camera_.done.front();
            camera_.done.pop_front();
            s_.notify_taken();
        }
        const bool positions = camera_.truth.view.positions;
        const double before = positions ? 0 : thread_time_s();
        const std::shared_ptr<Frame> frame = positions ? std::make_shared<Frame>() : pool_->acquire();
        if (frame == nullptr) {  // readers hold all buffers: this exposure is lost
            lost_ = true;
            return nullptr;
        }
        if (std::exchange(lost_, false)) e.quality = e.quality | Quality::gap;
        frame->tick = e.tick;
        frame->arrived = host_time(s_.due(camera_, e));
        set_time(*frame, e);
        frame->quality = e.quality;
        if (positions)
            see(*frame, e);
        else if (boards_.any())
            show_board(*frame, e);
        else
            camera_.renderer.render(e.poses, e.tick, frame->pixels, e.walker);
        const std::scoped_lock lock{s_.mutex};
        if (!positions) camera_.render_s += thread_time_s() - before;
        ++counts_.taken;
        counts_.lost += static_cast<std::uint64_t>(e.tick.n - next_);
        next_ = e.tick.n + 1;
        return frame;
    }
    [[nodiscard]] bool ended() const noexcept override {
        const std::scoped_lock lock{s_.mutex};
        return s_.stopped && !s_.frame_ready(camera_);
    }
    void stop() noexcept override { s_.stop(); }

private:
    // As a real camera does, or exactly.
    void set_time(Frame& frame, const Exposure& e) const {
        const CameraTruth& truth = camera_.truth;
        if (truth.own_clock == 0) {
            frame.mid_exposure = master_time(e.start_s + 0.5 * truth.view.exposure_s);
            return;
        }
        const double clock_s = camera_epoch_s + (1 + 1e-6 * truth.clock_ppm) * e.start_s;
        frame.stamp = CameraStamp{std::llround(1e9 * clock_s)};
    }

    void see(Frame& frame, const Exposure& e) const {
        frame.width = camera_.truth.width;
        frame.height = camera_.truth.height;
        frame.sightings = sightings(camera_.truth, layout_, e.poses, e.tick, e.walker, noise_seed_);
    }

    void show_board(Frame& frame, const Exposure& e) const {
        const CameraTruth& truth = camera_.truth;
        const optics::BoardLight light{
            .psf_px = truth.psf_px, .noise_dn = truth.noise_dn, .gradient = truth.light_gradient};
        const auto picture =
            optics::board_picture(optics::Board{}, true_view(truth), boards_.at(e.start_s), truth.width,
                                  truth.height, light, noise_seed_ + static_cast<std::uint64_t>(e.tick.n));
        std::memcpy(frame.pixels.data(), picture.data(), picture.size());
    }

    World::State& s_;
    World::State::SimulatedView& camera_;
    PictureLayout layout_;
    std::uint64_t noise_seed_;  // each camera has its own
    ShownBoards boards_;
    std::optional<FramePool> pool_;  // of a camera that gives pixels
    bool lost_ = false;
    DeviceCounts counts_;
    std::int64_t next_ = 0;
};

// A contact that opens and closes between two readings was open, as the edges of a GPIO line tell.
class SimulatedContact final : public AbortInput {
public:
    explicit SimulatedContact(World::State& s) : s_{s}, open_{s.scene.faults, {FaultKind::contact_open}} {}
    [[nodiscard]] Contact read(std::chrono::milliseconds wait) noexcept override {
        std::unique_lock lock{s_.mutex};
        const auto opened = [&] { return open_.between(FaultKind::contact_open, read_s_, s_.now()); };
        s_.wait_for(lock, wait, [&] { return s_.stopped || opened(); });
        const bool was_open = opened();
        read_s_ = s_.now();
        return was_open ? Contact::open : Contact::closed;
    }

private:
    World::State& s_;
    LastingFaults open_;
    double read_s_ = 0;  // true time of the last reading
};

}  // namespace

double drift_velocity(const std::vector<PoseTruth>& poses, double from_s, double to_s, double frequency_hz) {
    const double periods = std::max(2.0, std::round((to_s - from_s) * frequency_hz)),
                 period_s = (to_s - from_s) / periods;
    double moment = 0;
    for (double k = 0; k < periods; ++k)
        moment += (k - (periods - 1) / 2) *
                  mean_position(poses, from_s + k * period_s, from_s + (k + 1) * period_s);
    return 12 * moment / (periods * (periods * periods - 1) * period_s);
}

World::World(const Scene& scene, Pace pace) : state_{std::make_unique<State>(scene, pace)} {}
World::~World() = default;

Rig World::rig() {
    Rig rig;
    rig.name = "sim:";
    rig.dac = std::make_unique<SimulatedDac>(*state_);
    rig.accelerometer = std::make_unique<SimulatedAccelerometer>(*state_);
    for (std::size_t i = 0; i < state_->views.size(); ++i)
        rig.cameras.push_back(std::make_unique<SimulatedCamera>(*state_, i));
    if (std::ranges::any_of(state_->scene.faults,
                            [](const SceneFault& f) { return f.what == FaultKind::contact_open; }))
        rig.abort_input = std::make_unique<SimulatedContact>(*state_);
    return rig;
}

void World::expose_next(std::size_t index) {
    const std::scoped_lock lock{state_->mutex};
    state_->views.at(index).expose = true;
}

std::vector<PoseTruth> World::truth(std::size_t index) const {
    const std::scoped_lock lock{state_->mutex};
    return state_->views.at(index).poses;
}

void World::keep_truth_for(double seconds) {
    const std::scoped_lock lock{state_->mutex};
    state_->truth_kept_s = seconds;
}

void World::put_walker_back() {
    const std::scoped_lock lock{state_->mutex};
    state_->plant.put_walker_back();
}

double World::render_seconds() const {
    const std::scoped_lock lock{state_->mutex};
    double sum = 0;
    for (const State::SimulatedView& view : state_->views) sum += view.render_s;
    return sum;
}

}  // namespace shaker::simulated
