#include "daemon/bench/bench.hpp"

#include <spdlog/fmt/fmt.h>
#include <toml++/toml.h>

#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <numbers>
#include <optional>
#include <set>
#include <sstream>
#include <utility>

#include "calibration/accelerometer/response_file.hpp"
#include "calibration/accelerometer/sensor_file.hpp"
#include "calibration/camera/camera_file.hpp"
#include "drivers/errors.hpp"
#include "drivers/hardware/hardware_rig.hpp"
#include "drivers/simulated/shaker_plant.hpp"

namespace shaker::bench {

namespace {

constexpr Range on_earth{9.75, 9.85};  // m/s^2

std::function<std::complex<double>(double)> predicted_response(const simulated::Scene& sheet) {
    return [sheet](double frequency) {
        const auto [re, im] = simulated::ShakerPlant::response(sheet, frequency);
        return std::complex<double>{re, im};
    };
}

// Limits from the data sheets, overridden by the table [limits].
safety::Limits limits_for(const simulated::ShakerTruth& shaker, double walker_kg, const Rig& rig,
                          SettingsTable table) {
    const simulated::ShakerSheet& s = shaker.sheet;
    // An amplifier that holds the voltage sends at most this current through the coil's resistance.
    const double ohm = shaker.drive == simulated::DriveKind::current ? 1 : shaker.resistance_ohm;
    return safety::read_limits(std::move(table),
                               {.max_force_n = s.max_force_n,
                                .moving_mass_kg = shaker.moving_mass_kg,
                                .load_kg = shaker.base_mass_kg + walker_kg,
                                .stroke_m = 1e-3 * s.stroke_mm,
                                .max_velocity_mps = s.max_velocity_mps,
                                .max_acceleration_mps2 = s.max_acceleration_mps2,
                                .sensor_range_mps2 = rig.accelerometer->info().range_mps2,
                                .sensor_block_s = rig.accelerometer->info().block_s,
                                .full_scale_V = rig.dac->info().full_scale_V,
                                .max_coil_A = s.max_force_n / shaker.force_factor_npa / std::numbers::sqrt2,
                                .coil_A_per_V = std::abs(shaker.amplifier_gain) / ohm});
}

std::string content(const std::filesystem::path& file) {
    std::ifstream in{file, std::ios::binary};
    std::string text{std::istreambuf_iterator<char>{in}, {}};
    if (!in) throw InputError{file.string() + ": cannot be read: " + std::strerror(errno)};
    return text;
}

// The files that [accelerometer] names; empty: none.
struct SensorFiles {
    std::optional<calibration::CalibrationFile> gains{};
    std::filesystem::path response{};
};

SensorFiles named_sensor_files(SettingsTable& root) {
    SettingsTable table = root.table("accelerometer");
    SensorFiles files;
    if (table.has("calibration"))
        files.gains = calibration::read_calibration(table.folder() / table.text("calibration"));
    if (table.has("response")) files.response = table.folder() / table.text("response");
    return files;
}

// The files that the tables [[camera]] name, in the order of the cameras; empty: none.
std::vector<std::filesystem::path> named_cameras(std::vector<SettingsTable> tables) {
    std::vector<std::filesystem::path> files;
    for (SettingsTable& table : tables) {
        const std::string file = table.text("calibration", "");
        files.push_back(file.empty() ? std::filesystem::path{} : table.folder() / file);
    }
    return files;
}

void calibrate(Bench& open, const std::vector<std::filesystem::path>& cameras) {
    for (std::size_t k = 0; k < cameras.size(); ++k)
        if (!cameras[k].empty())
            open.rig.cameras.at(k) =
                calibration::with_calibration(std::move(open.rig.cameras.at(k)), cameras[k], open.granted);
}

void calibrate(Bench& open, const SensorFiles& by) {
    std::unique_ptr<Accelerometer>& device = open.rig.accelerometer;
    if (by.gains) device = calibration::with_calibration(std::move(device), *by.gains, open.granted);
    if (!by.response.empty())
        device = calibration::with_response(std::move(device), by.response, open.granted);
}

Bench open_simulated(const std::filesystem::path& scene, simulated::World::Pace pace,
                     const simulated::Scene& standard) {
    Bench open;
    SettingsTable root =
        scene.empty() ? SettingsTable::from_text("", "scene") : SettingsTable::from_file(scene);
    SettingsTable limits = root.table("limits");
    open.scene = simulated::read_scene(root, standard);
    open.world = std::make_unique<simulated::World>(open.scene, pace);
    open.rig = open.world->rig();
    calibrate(open, named_sensor_files(root));
    std::vector<SettingsTable> cameras;
    for (const simulated::CameraTruth& camera : open.scene.cameras)
        cameras.push_back(root.table(camera.view.camera));
    calibrate(open, named_cameras(std::move(cameras)));
    open.shaker = open.scene.shaker;
    open.gravity = open.scene.gravity;
    open.response = predicted_response(open.scene);
    open.limits = limits_for(open.shaker, open.scene.walker.mass_kg, open.rig, std::move(limits));
    open.rig_text = scene_text(open.scene) + "\n" + limits_text(open.limits);
    return open;
}

// The limits follow from these, so they must not be those of another shaker.
void require_data(SettingsTable& shaker) {
    if (shaker.has("model")) return;
    std::vector<const char*> needed{"max_force_n",           "stroke_mm",      "max_velocity_mps",
                                    "max_acceleration_mps2", "moving_mass_kg", "base_mass_kg",
                                    "force_factor_npa",      "amplifier_gain", "drive"};
    if (!shaker.is_text("drive") || shaker.text("drive") != "current") needed.push_back("resistance_ohm");
    std::erase_if(needed, [&](const char* key) { return shaker.has(key); });
    if (needed.empty()) return;
    shaker.fail(needed.front(),
                fmt::format("missing; expected the ratings of the shaker and the data of coil, amplifier and "
                            "masses, or the shaker's `model`. Missing keys: {}",
                            fmt::join(needed, ", ")));
}

// The record of the commissioning covers them.
std::vector<commissioned::Named> named_files(SettingsTable& root, const Rig& rig) {
    std::vector<commissioned::Named> all;
    SettingsTable dac = root.table("dac");
    if (const std::string name = dac.text("alsa_config", ""); !name.empty())
        all.push_back({"alsa_config", content(dac.folder() / name)});
    const AccelerometerInfo sensor = rig.accelerometer->info();
    if (!sensor.calibration.empty()) all.push_back({"calibration of accelerometer", sensor.calibration});
    if (!sensor.response.file.empty()) all.push_back({"response of accelerometer", sensor.response.file});
    for (const auto& camera : rig.cameras)
        if (const View& view = camera->view(); !view.calibration.empty())
            all.push_back({"calibration of camera " + view.camera, view.calibration});
    for (const MixerDevice& mixer : rig.mixers)
        all.push_back({commissioned::mixer_of + mixer.card, mixer.read()});
    return all;
}

Bench open_file(const std::filesystem::path& file) {
    if (!std::filesystem::is_regular_file(file))
        throw InputError{"--rig \"" + file.string() +
                         "\": no such file; expected a rig file (TOML), or sim: for the simulated bench"};
    Bench open;
    open.rig_text = content(file);
    SettingsTable root = SettingsTable::from_text(open.rig_text, file.string());
    for (const char* device : {"dac", "accelerometer", "shaker"})
        if (!root.has(device)) root.fail(device, std::string{"missing; expected a table ["} + device + "]");
    simulated::Scene sheet = simulated::paper_scene();
    SettingsTable shaker = root.table("shaker");
    require_data(shaker);
    sheet.shaker = open.shaker = simulated::read_shaker(std::move(shaker));
    open.real_time_required = root.choice("real_time", {"required", "wanted"}, 0) == 0;
    open.gravity = root.number("gravity_mps2", on_earth, paper_g);
    SettingsTable limits = root.table("limits");
    if (root.tables("camera").empty())
        root.fail("camera", "expected at least one [[camera]] that sees the base");
    const SensorFiles by = named_sensor_files(root);
    if (SettingsTable sensor = root.table("accelerometer"); !by.response.empty())
        for (const char* pass : {"high_pass_", "low_pass_"})
            for (const char* part : {"hz", "error_hz", "order", "damping", "above_hz"})
                if (const std::string key = std::string{pass} + part; sensor.has(key))
                    sensor.fail(key, "the file that `response` names has it; leave out one of both");
    const auto cameras = named_cameras(root.tables("camera"));
    hardware::HardwareRig bench = hardware::open_hardware_rig(root);
    open.rig = std::move(bench.rig);
    open.rig.name = file.string();
    open.granted = std::move(bench.granted);
    calibrate(open, by);
    calibrate(open, cameras);
    open.files = named_files(root, open.rig);
    open.not_commissioned = commissioned::missing_record(file, open.rig_text, open.files);
    open.response = predicted_response(sheet);
    open.limits = limits_for(open.shaker, 0, open.rig, std::move(limits));
    return open;
}

// The record of its commissioning.
std::optional<commissioned::Record> recorded(const Bench& bench) {
    return bench.world ? std::nullopt : commissioned::read_record(bench.rig.name);
}

std::string text_of(const toml::node& node) {
    std::ostringstream out;
    out.imbue(std::locale::classic());
    node.visit([&](const auto& value) { out << value; });
    return out.str();
}

}  // namespace

NewLimits limits_now(const Bench& bench, const std::string& name, const std::filesystem::path& scene) {
    const std::filesystem::path file = bench.world ? scene : std::filesystem::path{name};
    if (file.empty()) return {bench.limits, {}};
    const std::string text = content(file);
    if (!bench.world)
        if (const std::string why = commissioned::missing_record(file, text, bench.files); !why.empty())
            throw InputError{why};
    SettingsTable root = SettingsTable::from_text(text, file.string()), limits = root.table("limits");
    const std::string seen = bench.world ? scene_text(simulated::read_scene(root)) : text;
    NewLimits now{
        limits_for(bench.shaker, bench.world ? bench.scene.walker.mass_kg : 0, bench.rig, std::move(limits)),
        changed_settings(bench.rig_text, seen)};
    if (bench.halved) now.limits = safety::halved(now.limits);
    std::erase(now.ignored, "limits");
    return now;
}

Bench open_bench(const std::string& name, const std::filesystem::path& scene, simulated::World::Pace pace,
                 const simulated::Scene& standard) {
    if (name == "sim:") return open_simulated(scene, pace, standard);
    if (!scene.empty())
        throw InputError{"--scene \"" + scene.string() +
                         "\": only the simulated bench (--rig sim:) has a scene"};
    return open_file(name);
}

commissioned::MixerChange mixers_changed(const Bench& bench) {
    std::vector<commissioned::Named> now;
    commissioned::MixerChange unread;
    for (const MixerDevice& mixer : bench.rig.mixers) try {
            now.push_back({commissioned::mixer_of + mixer.card, mixer.read()});
        } catch (const DeviceError& e) {
            unread.why += (unread.controls++ > 0 ? "; " : "") + std::string{e.what()};
        }
    commissioned::MixerChange change = commissioned::mixers_changed(bench.files, now);
    if (unread.controls > 0) change.why += (change.controls > 0 ? "; " : "") + unread.why;
    change.controls += unread.controls;
    return change;
}

std::string mixers_off_record(const Bench& bench) try {
    const auto record = recorded(bench);
    return record ? commissioned::mixers_changed(record->files, bench.files).why : "";
} catch (const InputError&) {
    return {};  // the reason is in Bench::not_commissioned
}

std::vector<std::string> restore_mixers(Bench& bench) {
    const auto record = recorded(bench);
    std::vector<std::string> set;
    int known = 0;
    for (const MixerDevice& mixer : bench.rig.mixers) {
        if (!record) break;
        const std::string what = commissioned::mixer_of + mixer.card;
        const auto then = std::ranges::find(record->files, what, &commissioned::Named::what);
        if (then == record->files.end()) continue;
        ++known;
        for (const std::string& name : mixer.restore(then->text)) set.push_back(what + ": " + name);
        const auto now = std::ranges::find(bench.files, what, &commissioned::Named::what);
        if (now != bench.files.end()) now->text = mixer.read();
    }
    if (known == 0)
        throw InputError{"--restore-mixer: " + (bench.rig.mixers.empty()
                                                    ? "this bench has no mixer"
                                                    : "no record of a commissioning has a mixer of " +
                                                          bench.rig.name + "; nothing was set")};
    bench.not_commissioned = commissioned::missing_record(bench.rig.name, bench.rig_text, bench.files);
    return set;
}

std::vector<std::string> changed_settings(std::string_view before, std::string_view after) try {
    const toml::table then = toml::parse(before), now = toml::parse(after);
    std::set<std::string> changed;
    for (const auto& [from, to] : {std::pair{&then, &now}, {&now, &then}})
        for (const auto& [key, node] : *from) {
            const toml::node* other = to->get(key);
            if (other == nullptr || text_of(node) != text_of(*other)) changed.emplace(key.str());
        }
    return {changed.begin(), changed.end()};
} catch (const toml::parse_error& e) {
    throw InputError{std::string{e.description()}};
}

}  // namespace shaker::bench
