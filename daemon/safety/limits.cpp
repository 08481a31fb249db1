#include "daemon/safety/limits.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <numbers>
#include <utility>

#include "drivers/errors.hpp"

namespace shaker::safety {

namespace {

constexpr double warn_share = 0.8;  // of the abort level
constexpr Range positive{1e-9, 1e9};

Level level(double abort) { return {warn_share * abort, abort}; }
Level rms_of_sine(const Level& peak) { return level(peak.abort / std::numbers::sqrt2); }

struct NumberKey {
    double Limits::*value;
    const char* key;
    Range allowed;
};
constexpr std::array<NumberKey, 10> number_keys{{{&Limits::coil_A_per_V, "coil_A_per_V", {0, 1e6}},
                                                 {&Limits::coil_time_s, "coil_time_s", {1, 1e5}},
                                                 {&Limits::force_n, "force_n", positive},
                                                 {&Limits::sensor_range_mps2, "sensor_range_mps2", positive},
                                                 {&Limits::edge_mm, "edge_mm", {-1e4, 1e4}},
                                                 {&Limits::soft_stop_s, "soft_stop_s", {0.02, 0.2}},
                                                 {&Limits::hard_stop_s, "hard_stop_s", {0.001, 0.02}},
                                                 {&Limits::missing_s, "missing_s", {0.001, 10}},
                                                 {&Limits::camera_missing_s, "camera_missing_s", {0.01, 1e4}},
                                                 {&Limits::watchdog_s, "watchdog_s", {0.01, 60}}}};

constexpr double blocks_missing = 1.75;
constexpr int most_frames = 100000;

void read_level(SettingsTable& table, const LevelRow& row, Limits& limits) {
    Level& now = limits.*row.level;
    const std::string warn = row.file_key(&Level::warn), abort = row.file_key(&Level::abort);
    if (table.has(abort)) now = level(table.number(abort, positive) / row.per_si);
    if (!table.has(warn)) return;
    now.warn = table.number(warn, positive) / row.per_si;
    if (now.warn > now.abort)
        table.fail(warn, fmt::format("{} exceeds {}, which is {}", to_text(now.warn * row.per_si), abort,
                                     to_text(now.abort * row.per_si)));
}

}  // namespace

std::string LevelRow::key(double Level::*end, const char* in) const {
    return fmt::format("{}_{}{}{}", name, end == &Level::warn ? "warn" : "abort", *in == 0 ? "" : "_", in);
}

Limits limits_of(const DataSheet& sheet, double margin) {
    Limits l;
    const double mass = sheet.moving_mass_kg + sheet.load_kg;
    const double by_force = mass > 0 ? sheet.max_force_n / mass : INFINITY;
    l.acceleration =
        level(margin * std::min({sheet.max_acceleration_mps2, by_force, sheet.sensor_range_mps2}));
    l.acceleration_rms = rms_of_sine(l.acceleration);
    l.coil_A = level(margin * sheet.max_coil_A);
    l.coil_A_per_V = sheet.coil_A_per_V;
    l.velocity = level(margin * sheet.max_velocity_mps);
    l.displacement = level(margin * sheet.stroke_m / 2);
    l.drive = {warn_share * sheet.full_scale_V, sheet.full_scale_V};
    l.force_n = margin * sheet.max_force_n;
    l.sensor_range_mps2 = sheet.sensor_range_mps2;
    l.missing_s = std::max(l.missing_s, blocks_missing * sheet.sensor_block_s);
    return l;
}

Limits read_limits(SettingsTable table, const DataSheet& sheet) {
    Limits l = limits_of(sheet, table.number("margin", {0.1, 1}, standard_margin));
    for (const LevelRow& row : level_rows) {
        if (row.level == &Limits::acceleration_rms) l.acceleration_rms = rms_of_sine(l.acceleration);
        read_level(table, row, l);
    }
    for (const NumberKey& k : number_keys) l.*k.value = table.number(k.key, k.allowed, l.*k.value);
    l.tracking_lost_frames = table.integer("tracking_lost_frames", 1, most_frames, l.tracking_lost_frames);
    table.finish();
    return l;
}

std::pair<std::string, double> file_name(LimitKey key) {
    if (key.level == nullptr) return {"edge_mm", 1};
    const auto row = std::ranges::find(level_rows, key.level, &LevelRow::level);
    return {row->file_key(key.end), row->per_si};
}

void lower(Limits& limits, LimitKey key, double value) {
    const bool edge = key.level == nullptr;
    double& limit = edge ? limits.edge_mm : (limits.*key.level).*key.end;
    if (!(edge ? value >= limit : value <= limit)) {
        const auto [name, unit] = file_name(key);
        throw InputError{fmt::format(
            "limit {} {}: at {} the present {} is allowed; only the settings file can loosen limits", name,
            to_text(unit * value), edge ? "least" : "most", to_text(unit * limit))};
    }
    limit = value;
    if (!edge) (limits.*key.level).warn = std::min((limits.*key.level).warn, (limits.*key.level).abort);
}

Limits with_changes(Limits now, const Limits& was, const Limits& is) {
    const auto take = [&](auto key) {
        if (was.*key != is.*key) now.*key = is.*key;
    };
    for (const LevelRow& row : level_rows) take(row.level);
    for (const NumberKey& k : number_keys) take(k.value);
    take(&Limits::tracking_lost_frames);
    return now;
}

std::string limits_text(const Limits& limits) {
    std::string out = "[limits]\n";
    const auto line = [&](const std::string& key, double value) {
        if (std::isfinite(value)) out += fmt::format("{} = {}\n", key, value);
    };
    for (const LevelRow& row : level_rows)
        for (const auto end : {&Level::warn, &Level::abort})
            line(row.file_key(end), (limits.*row.level).*end * row.per_si);
    for (const NumberKey& k : number_keys) line(k.key, limits.*k.value);
    return out + fmt::format("tracking_lost_frames = {}\n", limits.tracking_lost_frames);
}

Limits halved(Limits limits) {
    for (const auto level : {&Limits::acceleration, &Limits::acceleration_rms, &Limits::velocity,
                             &Limits::displacement, &Limits::drive, &Limits::coil_A}) {
        Level& l = limits.*level;
        l = {l.warn / 2, l.abort / 2};
    }
    limits.force_n /= 2;
    return limits;
}

}  // namespace shaker::safety
