#include "tests/support/run/virtual_run.hpp"

#include <cmath>
#include <utility>

#include "daemon/acquisition/steps.hpp"
#include "daemon/safety/preflight.hpp"
#include "drivers/simulated/shaker_plant.hpp"
#include "drivers/simulated/world.hpp"

namespace shaker::test {

namespace {

/// Passes on the samples of an accelerometer with changed properties.
class ToldAccelerometer final : public Accelerometer {
public:
    ToldAccelerometer(std::unique_ptr<Accelerometer> inner, const AccelerometerInfo& info)
        : inner_{std::move(inner)}, info_{info} {}
    [[nodiscard]] AccelerometerInfo info() const override { return info_; }
    bool read(AccelBlock& block, std::chrono::milliseconds wait) override {
        return inner_->read(block, wait);
    }
    [[nodiscard]] bool ended() const noexcept override { return inner_->ended(); }
    void stop() noexcept override { inner_->stop(); }

private:
    std::unique_ptr<Accelerometer> inner_;
    AccelerometerInfo info_;
};

}  // namespace

safety::Limits limits_of(const simulated::Scene& scene) {
    const simulated::ShakerTruth& s = scene.shaker;
    return safety::limits_of({.max_force_n = s.sheet.max_force_n,
                              .moving_mass_kg = s.moving_mass_kg,
                              .load_kg = s.base_mass_kg + scene.walker.mass_kg,
                              .stroke_m = 1e-3 * s.sheet.stroke_mm,
                              .max_velocity_mps = s.sheet.max_velocity_mps,
                              .max_acceleration_mps2 = s.sheet.max_acceleration_mps2,
                              .sensor_range_mps2 = scene.accelerometer.range_mps2,
                              .full_scale_V = scene.dac_full_scale_v});
}

VirtualRun run_virtually(const VirtualRunSettings& settings) {
    const simulated::Scene scene = simulated::parse_scene(settings.scene, "scene");
    simulated::World world{scene};
    Rig rig = world.rig();
    rig.cameras.clear();
    const DacInfo dac = rig.dac->info();
    AccelerometerInfo info = rig.accelerometer->info();
    if (settings.stated) settings.stated(info);
    rig.accelerometer = std::make_unique<ToldAccelerometer>(std::move(rig.accelerometer), info);
    safety::Limits limits = limits_of(scene);
    if (settings.limits) settings.limits(limits);
    limits.detectors = settings.detectors;
    const double f = settings.drive.frequency;
    acquisition::Collector collector{rig, nullptr, limits, f};
    acquisition::DriveOutput output{dac, f, 0, dac.block_frames, limits, info.rate_hz};
    // The data sheet does not contain the defects of this shaker.
    simulated::Scene sheet = simulated::paper_scene();
    sheet.shaker = scene.shaker;
    run::RunPlan plan{.controller = {.drive = settings.drive,
                                     .volts_limit = 0.95 * dac.full_scale_V,
                                     .identify = settings.identify,
                                     .sheet =
                                         [sheet](double hz) {
                                             const auto [re, im] =
                                                 simulated::ShakerPlant::response(sheet, hz);
                                             return std::complex<double>{re, im};
                                         }},
                      .line_hz = settings.line_hz,
                      .task = {.plan = {.periods = settings.periods}},
                      .limits = limits};
    VirtualRun run;
    run.dac_rate_hz = dac.rate_hz;
    plan.gravity = scene.gravity;
    run::Sequence sequence{plan, dac.rate_hz, info, [](const std::string&) {}};
    acquisition::Channels& channels = collector.channels();
    output.has_contact = rig.abort_input != nullptr;
    std::vector<acquisition::Loop> loops = collector.sensor_loops();
    while (!sequence.done()) {
        const double now_s = static_cast<double>(output.synthesiser.tick().n) / dac.rate_hz;
        if (now_s > settings.longest_s) break;
        if (rig.abort_input) abort_input_step(*rig.abort_input, {}, channels);
        output_step(output, *rig.dac, channels);
        for (std::size_t i = 0; i < output.volts.size(); ++i) {
            if (output.volts[i] == 0) continue;
            run.largest_V = std::max(run.largest_V, std::abs(output.volts[i]));
            run.silent_s = now_s + static_cast<double>(i) / dac.rate_hz;
        }
        while (loops[0].step(std::chrono::milliseconds{0})) {
        }
        if (now_s >= settings.stalls_at_s && now_s < settings.stalls_at_s + settings.stalls_for_s) continue;
        collector.collect();
        const run::RunState before = sequence.state();
        sequence.step(collector.streams(), channels);
        if (sequence.state() == run::RunState::tripped && before != run::RunState::tripped)
            run.tripped_in = before;
        run.entered_s.try_emplace(sequence.state(), now_s);
        if (settings.each) settings.each(sequence, channels, now_s);
    }
    for (const DriveChange& c : collector.streams().changes)
        if (c.stop > 0 && run.stop_began_s == 0)
            run.stop_began_s = static_cast<double>(c.first.n) / dac.rate_hz;
    run.ended = sequence.state();
    run.trip = sequence.trip();
    run.notes = sequence.notes();
    for (std::size_t i = 0; i < safety::causes; ++i)
        if (const auto n = channels.warnings[static_cast<safety::Cause>(i)]; n > 0)
            run.warnings[static_cast<safety::Cause>(i)] = n;
    return run;
}

}  // namespace shaker::test
