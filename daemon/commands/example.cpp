#include <spdlog/fmt/fmt.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "calibration/camera/camera_scale.hpp"
#include "daemon/commands/table.hpp"
#include "daemon/manual/values.hpp"
#include "drivers/errors.hpp"
#include "drivers/footage/movie_writer.hpp"
#include "drivers/simulated/shaker_plant.hpp"
#include "drivers/simulated/world.hpp"
#include "drivers/synthesiser.hpp"
#include "drivers/time.hpp"
#include "drivers/trigger_train.hpp"
#include "drivers/view_settings.hpp"

namespace shaker::commands {

namespace {

constexpr Drive drive{};  // 20 Hz, 1 g, rho 0.5, phi 0
constexpr double frame_rate_hz = 200;
constexpr int ramp_periods = 10, settle_periods = 20, periods = 24;
constexpr double from_s = (ramp_periods + settle_periods) / drive.frequency;
constexpr double to_s = from_s + periods / drive.frequency;
constexpr double spare_s = 0.1;  // duration of accelerations before and after the pictures

simulated::Scene example_scene() {
    simulated::Scene scene = simulated::paper_scene();
    for (simulated::CameraTruth& camera : scene.cameras) camera.view.frame_rate_hz = frame_rate_hz;
    return scene;
}

// Voltage for this motion of the base by the data sheet.
Harmonics<Voltage> volts_for(const simulated::Scene& scene) {
    Harmonics<Voltage> volts;
    const Harmonics<Acceleration> target = harmonics(drive);
    for (int q = 1; q <= target.order(); ++q) {
        const auto [re, im] = simulated::ShakerPlant::response(scene, q * drive.frequency);
        volts.at(q) = target.at(q) / std::complex<double>{re, im};
    }
    return volts;
}

struct Footage {
    std::string accelerations = "t_s,ax_mps2,ay_mps2,az_mps2\n";
    std::vector<FramePtr> first;  // first picture of each camera
    std::vector<footage::MovieWriter> movies;
};

void take(Rig& rig, const std::filesystem::path& folder, Footage& to) {
    const AccelerometerInfo info = rig.accelerometer->info();
    for (AccelBlock b; rig.accelerometer->read(b, {});)
        for (int i = 0; i < b.size; ++i) {
            const double t_s = info.first_sample_s + counted_s(AccelTick{b.first.n + i}, info.rate_hz);
            if (t_s < from_s - spare_s) continue;
            const auto a = info.acceleration(b.counts[static_cast<std::size_t>(i)]);
            to.accelerations += fmt::format("{:.6f},{:.6f},{:.6f},{:.6f}\n", t_s, a[0], a[1], a[2]);
        }
    for (std::size_t k = 0; k < rig.cameras.size(); ++k)
        while (const FramePtr frame = rig.cameras[k]->read({})) {
            const double t_s = seconds(frame->mid_exposure.value());
            if (t_s < from_s || t_s > to_s) continue;
            if (to.movies.size() == k) {
                to.first.push_back(frame);
                to.movies.emplace_back(folder / (rig.cameras[k]->view().camera + ".mkv"), frame->width,
                                       frame->height, frame_rate_hz);
            }
            to.movies.at(k).write(frame->view());
        }
}

void play(const simulated::Scene& scene, Rig& rig, const std::filesystem::path& folder, Footage& to) {
    const DacInfo dac = rig.dac->info();
    Synthesiser synthesiser{dac.rate_hz, drive.frequency, dac.full_scale_V};
    synthesiser.set({.volts = volts_for(scene), .frequency = drive.frequency, .ramp_periods = ramp_periods});
    TriggerTrain train{dac.rate_hz, frame_rate_hz};
    std::vector<double> volts(dac.block_frames), trigger(dac.block_frames);
    while (static_cast<double>(synthesiser.tick().n) < (to_s + spare_s) * dac.rate_hz) {
        synthesiser.fill(volts);
        train.fill(trigger);
        rig.dac->write(volts, trigger);
        take(rig, folder, to);
    }
}

// The view with its regions moved from the positions at rest to those in the first picture.
View seen_at(View view, const simulated::PoseTruth& pose, double walker_start_m) {
    for (Target& target : view.targets) {
        const double moved_m = target.name == "walker" ? pose.walker - walker_start_m : pose.base;
        const double moved_px = 1e3 * moved_m / calibration::mm_per_px_at(view, target.offset_mm);
        for (std::size_t k = 0; k < 2; ++k)
            target.roi_px[k] += static_cast<int>(std::lround(moved_px * view.along[k]));
    }
    return view;
}

void write_text(const std::filesystem::path& file, const std::string& text) {
    std::ofstream out{file, std::ios::binary};
    out << text;
    out.close();
    if (!out) throw DeviceError{file.string() + ": cannot be written"};
}

std::string session_head() {
    return fmt::format(
        "# An example, written by \"shakerd example\" from the simulated bench. \"shakerd reduce\" of this "
        "file gives\n# the drift velocity v_D of truth.json within its error.\n"
        "title = \"example: disc on a base, two views, accelerometer with its own clock\"\n\n"
        "[drive]\nfrequency_hz = {}\ngamma_mps2 = {}\nrho = {}\nphi_rad = {}\n\n"
        "[accelerometer]\nfile = \"accelerations.csv\"\ntime = \"t_s\"\n"
        "axes = [\"ax_mps2\", \"ay_mps2\", \"az_mps2\"]\nclock_uncertainty_s = 0.02\n",
        drive.frequency, drive.gamma, drive.rho, drive.phi);
}

// Writes session.toml, top.mkv, side.mkv, accelerations.csv and truth.json into a folder, which is created
// if needed: the simulated bench at 1 g, phi 0 and 20 Hz, 24 periods of the settled walker at 200 pictures
// per second. The accelerations have their own clock. All files are identical each time, except that the
// movies depend on the codec. Throws InputError when one of the files exists, DeviceError when one cannot be
// written.
void write_example_session(const std::filesystem::path& folder) {
    std::filesystem::create_directories(folder);
    for (const char* name : {"session.toml", "top.mkv", "side.mkv", "accelerations.csv", "truth.json"})
        if (std::filesystem::exists(folder / name))
            throw InputError{(folder / name).string() + ": exists already; files are never overwritten"};
    const simulated::Scene scene = example_scene();
    simulated::World world{scene};
    Rig rig = world.rig();
    Footage footage;
    play(scene, rig, folder, footage);
    std::string session = session_head();
    for (std::size_t k = 0; k < rig.cameras.size(); ++k) {
        const std::vector<simulated::PoseTruth> truth = world.truth(k);
        const Frame& first = *footage.first.at(k);
        const auto at = std::ranges::find(truth, first.tick, &simulated::PoseTruth::tick);
        const View view = seen_at(rig.cameras[k]->view(), *at, 1e-3 * scene.walker.start_mm);
        session += fmt::format("\n[[camera]]\nfile = \"{}.mkv\"\nfirst_exposure_s = {:.9f}\n{}", view.camera,
                               seconds(*first.mid_exposure), view_text(view));
    }
    write_text(folder / "accelerations.csv", footage.accelerations);
    const double v_D = drift_velocity(world.truth(0), from_s + 0.01, to_s - 0.04, drive.frequency);
    write_text(
        folder / "truth.json",
        nlohmann::json{{"v_D_mps", v_D}, {"mu", scene.walker.mu_k}, {"gravity_mps2", scene.gravity}}.dump(2) +
            "\n");
    write_text(folder / "session.toml", session);
}

constexpr std::array example_arguments{
    manual::Argument{.name = "FOLDER", .help = "Folder of the new files", .kind = manual::Kind::folder}};

int act_on_example(const manual::Values& values) {
    const std::filesystem::path folder = values.text("FOLDER");
    write_example_session(folder);
    std::puts((folder / "session.toml").string().c_str());
    return manual::exit_ok;
}

}  // namespace

manual::Command example_row() {
    return {.name = "example",
            .summary = "Write a small session of footage from the simulated bench",
            .details =
                "The session holds two movies, accelerations as CSV, session.toml and the truth. Files "
                "that exist are never replaced.",
            .arguments = example_arguments,
            .example = "shakerd example lab; shakerd reduce lab/session.toml",
            .exit_statuses = {manual::exit_device},
            .act = act_on_example};
}

}  // namespace shaker::commands
