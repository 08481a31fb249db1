#include "daemon/recording/replay_overrides.hpp"

#include <spdlog/fmt/fmt.h>
#include <spdlog/fmt/ranges.h>

#include <cmath>
#include <map>

#include "daemon/recording/tables/process_table.hpp"
#include "drivers/drive.hpp"
#include "drivers/errors.hpp"
#include "drivers/quantity.hpp"

namespace shaker::recording {

namespace {

struct Setting {
    double* value;
    Range range;
};

std::map<std::string, Setting> settings_of(ReplayOverrides& s) {
    constexpr double long_s = 1e7;
    AccelerometerInfo& a = s.header.accelerometer;
    std::map<std::string, Setting> all{
        {"from_s", {&s.from_s, {-long_s, long_s}}},
        {"to_s", {&s.to_s, {-long_s, long_s}}},
        {"frequency_hz", {&s.header.frequency_hz, drive_limits.frequency}},
        {"accelerometer.first_sample_s", {&a.first_sample_s, {-long_s, long_s}}},
        {"accelerometer.clock_uncertainty_s", {&a.clock_uncertainty_s, {0, 10}}},
    };
    for (std::size_t k = 0; k < 3; ++k) {
        const char axis = "xyz"[k];
        all[fmt::format("accelerometer.offset_counts_{}", axis)] = {&a.offset_counts[k], {-1e9, 1e9}};
        all[fmt::format("accelerometer.mps2_per_count_{}", axis)] = {&a.mps2_per_count[k], {-1e3, 1e3}};
        all[fmt::format("accelerometer.shaker_axis_{}", axis)] = {&a.shaker_axis[k], {-1, 1}};
    }
    for (View& view : s.header.views) {
        all[view.camera + ".mm_per_px"] = {&view.mm_per_px, {1e-6, 1e4}};
        all[view.camera + ".scale_error"] = {&view.scale_error, {0, 1}};
        all[view.camera + ".distance_mm"] = {&view.distance_mm, {0, 1e7}};
        all[view.camera + ".trigger_delay_s"] = {&view.trigger_delay_s, {-1, 1}};
        for (Target& t : view.targets)
            all[fmt::format("{}.{}.offset_mm", view.camera, t.name)] = {&t.offset_mm, {-1e5, 1e5}};
    }
    return all;
}

}  // namespace

ReplayOverrides replay_settings(const recorded::RecordingReader& file, const std::vector<std::string>& set) {
    const MeasuredPart part = read_reduced_part(file);
    ReplayOverrides s{file.header(), part.from_s, part.to_s, false};
    const std::map<std::string, Setting> all = settings_of(s);
    for (const std::string& text : set) {
        const std::size_t equals = text.find('=');
        if (equals == std::string::npos) throw InputError{"--set " + text + ": expected key=value"};
        const std::string key = text.substr(0, equals);
        const auto setting = all.find(key);
        if (setting == all.end()) {
            std::vector<std::string> keys;
            keys.reserve(all.size());
            for (const auto& [name, unused] : all) keys.push_back(name);
            throw InputError{
                fmt::format("--set {}: unknown key; expected one of {}", key, fmt::join(keys, ", "))};
        }
        *setting->second.value =
            parse_quantity("--set " + key, text.substr(equals + 1), Dimension::ratio, setting->second.range);
        s.changed = true;
    }
    return s;
}

}  // namespace shaker::recording
