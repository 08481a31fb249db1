// Plant: cost of one DAC sample of the simulated shaker with a walker on it
#include <numbers>

#include "drivers/simulated/shaker_plant.hpp"
#include "tests/bench/table.hpp"
#include "tests/support/control/bench_drive.hpp"
#include "tests/support/cost.hpp"

namespace shaker {
namespace {

constexpr long samples = 240000;  // 5 s

void add(bench::Table& table, const std::string& name, const simulated::Scene& scene, double gamma) {
    const Harmonics<Voltage> drive = test::volts_for(scene, {.gamma = gamma});
    const auto volts = test::samples(drive, 20, scene.dac_rate_hz, 0, samples);
    long events = 0;
    double x = 0;
    const double ns = bench::median_cost_ns(5, [&] {
        simulated::ShakerPlant plant{scene};
        for (const double v : volts) plant.step(v);
        events = plant.events();
        x = plant.state().walker_x;
    });
    table.add({{"plant", name},
               {"cost", ns / samples, "ns/sample"},
               {"contact changes", static_cast<double>(events) / (samples / scene.dac_rate_hz), "1/s"},
               {"walker", 1e3 * x, "mm", 12}});
}

}  // namespace
}  // namespace shaker

int main(int argc, char** argv) {
    using namespace shaker;
    bench::Table table;
    simulated::Scene scene = simulated::paper_scene();
    add(table, "B&K 4809, walker sticks", scene, 0.12 * 9.8);
    add(table, "B&K 4809, walker slips", scene, 9.8);
    simulated::Scene current = scene;
    current.shaker.drive = simulated::DriveKind::current;
    add(table, "the same, current drive", current, 9.8);
    simulated::Scene rubbing = scene;
    rubbing.shaker.static_friction_n = rubbing.shaker.kinetic_friction_n = 0.3;
    add(table, "the same, slide rubs", rubbing, 9.8);
    simulated::Scene bent = scene;
    bent.shaker.cubic_stiffness_npm3 = 4e10;
    bent.shaker.force_factor_falloff_pm2 = 1e4;
    add(table, "the same, cubic stiffness, Bl(x)", bent, 9.8);
    table.print(argc, argv);
}
