#include "daemon/safety/trip.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>

namespace shaker::safety {

namespace {

struct Words {
    const char* name;
    const char* unit;
    double shown;  // units shown per unit of Trip::value
    const char* shown_unit;
    const char* what;  // {0} value, {1} limit, {2} harmonic, in the shown unit
    const char* action;
};

constexpr std::array<Words, causes> words{{
    {"acceleration", "m/s^2", 1, "m/s^2", "peak acceleration of the base {0} exceeds the limit of {1}",
     "check for a loose fixture or a changed amplifier gain"},
    {"velocity", "m/s", 1, "m/s", "peak velocity of the base {0} exceeds the limit of {1}",
     "check for a loose fixture or a changed amplifier gain"},
    {"displacement", "m", 1e3, "mm", "the base is {0} from its mean position (limit {1})",
     "lower gamma or raise the frequency"},
    {"transverse", "", 100, "%", "motion across the shaker's axis is {0} of the motion along it (limit {1})",
     "check the guide, the alignment of the shaker and the sensor's mounting"},
    {"drive", "V", 1, "V", "drive peak {0} exceeds the limit of {1}",
     "lower gamma; if this drive was possible before, check the amplifier's gain"},
    {"sensor_open", "", 100, "%", "the accelerometer shows {0} of the expected motion (at least {1})",
     "check its cable and mounting, then the amplifier"},
    {"sensor_frozen", "samples", 1, "samples",
     "the accelerometer's reading did not change for {0} (limit {1})", "restart the accelerometer"},
    {"sensor_saturated", "samples", 1, "samples",
     "the accelerometer was at the end of its range for {0} in a row (limit {1})",
     "choose a larger range or lower gamma"},
    {"sensor_not_finite", "", 1, "",
     "the acceleration computed from the accelerometer's counts is not finite",
     "check its scale and offset in the rig file"},
    {"sensor_missing", "s", 1e3, "ms", "no accelerometer sample could be checked for {0} (limit {1})",
     "check its cable, its time stamps and the load of the computer"},
    {"residual", "m/s^2", 1, "m/s^2", "measured and predicted acceleration differ by {0} rms (limit {1})",
     "check for a loose fixture, a changed amplifier gain or a hand on the table; then identify again"},
    {"loop_divergence", "", 100, "%", "the control error is {0} of the target (limit {1})",
     "identify the shaker again"},
    {"harmonic_band", "dB", 1, "dB", "harmonic {2} is {0} from its target (limit {1})",
     "identify the shaker again"},
    {"gain_limit", "", 1, "", "the shaker's gain is {0} times the expected gain (limit {1})",
     "check the amplifier's gain, full_scale_V and the masses; then identify again"},
    {"polarity", "", 100, "%",
     "the base moves against the predicted direction: {0} of the prediction (at least {1})",
     "check the wiring of the amplifier and the sensor's direction"},
    {"gravity", "", 100, "%",
     "gravity reads {0} of its reference value (at most {1}, and as far below 100 %)",
     "check the sensor's mounting, its axes, its power and its scale"},
    {"walker_edge", "mm", 1, "mm", "the walker is {0} from the edge of the picture (at least {1})",
     "clear the trip, then bring it back to the middle"},
    {"tracking_lost", "frames", 1, "frames", "the walker was not found in {0} in a row (limit {1})",
     "check the light and the walker"},
    {"camera_missing", "s", 1e3, "ms", "no camera sent a picture of the walker for {0} (limit {1})",
     "check the cameras, their trigger and cables, and the load of the computer"},
    {"underrun", "samples", 1, "samples", "the DAC ran empty for {0} (limit {1})",
     "check the load of the computer, or increase buffer_frames"},
    {"watchdog", "s", 1e3, "ms", "no progress of the control for {0} (limit {1})",
     "check the load of the computer"},
    {"clock", "ppm", 1, "ppm", "the rate of a clock changed by {0} (limit {1})",
     "check the sample rates of the devices"},
    {"recorder", "s", 1, "s", "nothing could be recorded for {0} (limit {1})",
     "check the disk: free space, speed, health"},
    {"acceleration_rms", "m/s^2", 1, "m/s^2", "acceleration of the base {0} rms exceeds the limit of {1}",
     "check for clipping, a loose fixture or a changed amplifier gain"},
    {"coil_heat", "A", 1, "A", "the coil is as hot as after a long drive with {0} rms (limit {1})",
     "let the shaker cool, then lower gamma or drive for a shorter time"},
    {"operator_stop", "", 1, "", "stopped by the operator", ""},
    {"abort_input", "", 1, "", "the contact of the abort input is open or cannot be read",
     "close it (its button, its cable), then clear the trip"},
    {"base_motion", "", 1, "",
     "a camera sees the base move {0} times as far as the accelerometer says (limit {1})",
     "one of the two is wrong: check mm_per_px of the camera and the sensor's scale, and calibrate them"},
    {"mixer", "", 1, "", "{0} controls of a sound card's mixer have changed",
     "set them back (the log names them), and keep other programs from the card"},
}};

const Words& of(Cause cause) noexcept { return words[static_cast<std::size_t>(cause) % causes]; }

}  // namespace

bool contradicts_prediction(const Trip& trip) noexcept {
    return trip.stop == StopKind::soft && (trip.cause == Cause::residual ||
                                           trip.cause == Cause::sensor_open || trip.cause == Cause::polarity);
}

bool misses_target(const Trip& trip) noexcept {
    return trip.stop == StopKind::soft &&
           (trip.cause == Cause::loop_divergence || trip.cause == Cause::harmonic_band);
}

const char* name(Cause cause) noexcept { return of(cause).name; }

std::optional<Cause> cause_named(std::string_view word) noexcept {
    const auto at = std::ranges::find(words, word, &Words::name);
    if (at == words.end()) return std::nullopt;
    return static_cast<Cause>(at - words.begin());
}

const char* unit_of(Cause cause) noexcept { return of(cause).unit; }

std::string finding(const Trip& trip) {
    const Words& w = of(trip.cause);
    const auto figure = [&](double v) {
        const char* space = *w.shown_unit != 0 ? " " : "";
        return fmt::format("{:.4g}{}{}", w.shown * v, space, w.shown_unit);
    };
    return fmt::format(fmt::runtime(w.what), figure(trip.value), figure(trip.limit), trip.harmonic);
}

const char* advice(Cause cause) noexcept { return of(cause).action; }

std::string text(const Trip& trip) {
    const Words& w = of(trip.cause);
    return fmt::format("{}{}{} ({}: {} stop at {} sample {})", finding(trip), *w.action != 0 ? "; " : "",
                       w.action, w.name, trip.stop == StopKind::hard ? "hard" : "soft",
                       trip.on_dac_clock ? "DAC" : "accelerometer", trip.tick);
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

}  // namespace shaker::safety
