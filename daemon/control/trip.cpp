#include "daemon/control/trip.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>

namespace shaker {

namespace {

struct Words {
    const char* name;
    const char* unit;
    double shown;  // of the unit below, in one of `unit`
    const char* shown_unit;
    const char* what;  // {0} value, {1} limit, {2} harmonic, in the unit shown
    const char* action;
};

constexpr std::array<Words, causes> words{{
    {"acceleration", "m/s^2", 1, "m/s^2", "the base reached {0} of {1} allowed",
     "look for a loose fixture or a changed amplifier gain"},
    {"velocity", "m/s", 1, "m/s", "the base reached {0} of {1} allowed",
     "look for a loose fixture or a changed amplifier gain"},
    {"displacement", "m", 1e3, "mm", "the base went {0} from its middle of {1} allowed",
     "lower gamma or raise the frequency"},
    {"transverse", "", 100, "%", "sideways the base moves {0} of its motion along the axis, {1} are allowed",
     "look at the guide, the alignment of the shaker and the sensor's mounting"},
    {"drive", "V", 1, "V", "{0} were asked of the DAC, {1} are allowed",
     "lower gamma; if it used to do, the amplifier's gain has fallen"},
    {"sensor_open", "", 100, "%", "the accelerometer shows {0} of what it must, {1} is the least",
     "look at its cable and its mounting, then at the amplifier"},
    {"sensor_frozen", "samples", 1, "samples", "the accelerometer told the same for {0}, {1} are allowed",
     "restart the accelerometer"},
    {"sensor_saturated", "samples", 1, "samples",
     "the accelerometer stood at the end of its range for {0} in a row, {1} are allowed",
     "choose a larger range or lower gamma"},
    {"sensor_not_finite", "", 1, "", "the accelerometer's scale makes no number of its counts",
     "look at its scale and offset"},
    {"sensor_missing", "s", 1e3, "ms", "the accelerometer was silent for {0} of {1} allowed",
     "look at its cable and the load of the computer"},
    {"residual", "m/s^2", 1, "m/s^2", "the base is {0} rms away from its predicted motion, {1} are allowed",
     "look for a loose fixture, a changed amplifier gain or a hand on the table; then identify anew"},
    {"loop_divergence", "", 100, "%", "the loop is {0} of the target away, {1} are allowed",
     "identify the shaker anew"},
    {"harmonic_band", "dB", 1, "dB", "harmonic {2} is {0} from its target, {1} are allowed",
     "identify the shaker anew"},
    {"gain_limit", "", 1, "",
     "between drive and motion lies {0} times what is known of the shaker, {1} is the limit",
     "look at the amplifier's gain, full_scale_V and the masses; identify anew"},
    {"polarity", "", 100, "%", "the base moves against its prediction: {0} of it, {1} is the least",
     "look at the wiring of the amplifier and the sensor's direction"},
    {"gravity", "", 100, "%", "gravity is {0} of what it was or must be, 60 % to {1} are allowed",
     "look at the sensor's mounting, its axes, its power and its scale"},
    {"walker_edge", "mm", 1, "mm", "the walker is {0} from the edge, {1} are the least", "bring it back"},
    {"tracking_lost", "frames", 1, "frames", "the walker was not found in {0} in a row, {1} are allowed",
     "look at the light and at the walker"},
    {"camera_missing", "s", 1e3, "ms", "a camera was silent for {0} of {1} allowed",
     "look at its cable and the load of the computer"},
    {"underrun", "samples", 1, "samples", "the DAC ran empty for {0}, {1} are allowed",
     "look at the load of the computer, or make buffer_frames larger"},
    {"watchdog", "s", 1e3, "ms", "the control stood still for {0} of {1} allowed",
     "look at the load of the computer"},
    {"clock", "ppm", 1, "ppm", "a clock changed its rate by {0}, {1} are allowed",
     "look at the sample rates of the devices"},
    {"recorder", "s", 1, "s", "nothing could be recorded for {0}, {1} are allowed",
     "look at the disk: its room, its speed, its health"},
    {"operator_stop", "", 1, "", "the operator asked for it", ""},
}};

const Words& of(Cause cause) noexcept { return words[static_cast<std::size_t>(cause) % causes]; }

}  // namespace

const char* name(Cause cause) noexcept { return of(cause).name; }

std::optional<Cause> cause_named(std::string_view word) noexcept {
    const auto at = std::ranges::find(words, word, &Words::name);
    if (at == words.end()) return std::nullopt;
    return static_cast<Cause>(at - words.begin());
}

const char* unit_of(Cause cause) noexcept { return of(cause).unit; }

std::string text(const Trip& trip) {
    const Words& w = of(trip.cause);
    const auto figure = [&](double v) {
        const char* space = *w.shown_unit != 0 ? " " : "";
        return fmt::format("{:.4g}{}{}", w.shown * v, space, w.shown_unit);
    };
    std::string line = fmt::format("{} stop, {}: ", trip.stop == StopKind::hard ? "hard" : "soft", w.name);
    line += fmt::format(fmt::runtime(w.what), figure(trip.value), figure(trip.limit), trip.harmonic);
    line += fmt::format(" ({} sample {})", trip.on_dac_clock ? "DAC" : "accelerometer", trip.tick);
    if (*w.action != 0) line += fmt::format("; {}", w.action);
    return line;
}

std::vector<std::string> notes_on(const Warnings& warnings) {
    std::vector<std::string> notes;
    for (std::size_t i = 0; i < causes; ++i) {
        const auto cause = static_cast<Cause>(i);
        if (const std::uint64_t n = warnings[cause]; n > 0)
            notes.push_back(fmt::format("{} warnings: {}{}{}", n, name(cause),
                                        *of(cause).action != 0 ? "; " : "", of(cause).action));
    }
    return notes;
}

}  // namespace shaker
