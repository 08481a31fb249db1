#pragma once
// Plan: what clients, devices, disk and computer do in one simulated run of the daemon. Drawn from a seed.
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "drivers/simulated/faults.hpp"

namespace shaker::orders {

/// Actions of a client, in the order of `action_names`.
enum class Action : std::uint8_t {
    drive,
    start,
    identify,
    stop,
    abort,
    clear,
    remark,
    record,
    unrecord,
    loop,
    lower_drive,
    lower_motion,
    reload,
    read,        // READ? by SCPI: waits for the next measurement
    disconnect,  // in the middle of a command
    nonsense,
    ask,        // a query by SCPI
    recover,    // another program recovers the file that is being recorded
    same_name,  // another program makes a file of the name that the open recording will get
    middle,     // brings the walker to the middle of the picture
    mu,         // gives the friction coefficient, also a wrong one
    campaign,   // starts one of three points
    word,       // pauses, resumes, skips, repeats or ends it
};
inline constexpr std::array action_names{
    "drive",    "start",   "identify",    "stop",         "abort",  "clear",    "remark",     "record",
    "unrecord", "loop",    "lower_drive", "lower_motion", "reload", "read",     "disconnect", "nonsense",
    "ask",      "recover", "same_name",   "middle",       "mu",     "campaign", "word"};
inline constexpr std::size_t actions = action_names.size();

/// Faults of disk and computer. Their numbers follow those of a scene's faults.
inline constexpr std::size_t scene_faults = static_cast<std::size_t>(simulated::FaultKind::amplifier_off) + 1;
enum class Trouble : std::uint8_t {
    disk_full = scene_faults,
    disk_error,
    slow_sensor,   // the thread of the accelerometer stands still
    slow_cameras,  // the threads of the cameras
    slow_service,  // the thread that obeys orders
    slow_output,   // the output waits in the DAC while the others run, which then wait for it
    killed,        // the program is killed and started again
};
inline constexpr std::size_t troubles = static_cast<std::size_t>(Trouble::killed) + 1;
const char* name_of_trouble(std::size_t trouble) noexcept;

struct Move {
    double at_s = 0;  // virtual time
    int client = 0;   // 0 and 1 speak SCPI, 2 HTTP
    Action action{};
    double value = 0;  // 0..1; its meaning depends on the action
    bool operator==(const Move&) const = default;
};
struct Fault {
    double at_s = 0;
    std::size_t trouble = 0;
    double for_s = 0;
    double value = 0;  // 0..1
    bool operator==(const Fault&) const = default;
};

struct Plan {
    std::uint64_t seed = 0;
    double length_s = 10;
    double frequency_hz = 20;
    bool identifies = false;  // measures the response first
    double buffer_s = 0;      // of the DAC
    double kept_s = 0;        // part of it that a hard stop cannot take back
    bool at_edge = false;     // the walker starts near the edge of the picture, and its friction is known
    double enable_s = 0;      // enable output of the amplifier: time from its tone to the drive; 0: none
    std::vector<Move> moves{};
    std::vector<Fault> faults{};
    [[nodiscard]] std::size_t size() const noexcept { return moves.size() + faults.size(); }
    bool operator==(const Plan&) const = default;
};

/// The plan of a seed. Every hundredth seed is a minute long, one with a campaign 40 s, the others 10 to 14
/// s.
Plan plan_of(std::uint64_t seed);
/// The scene of a plan, from `from_s` on: cameras give positions, devices fail as planned.
std::string scene_of(const Plan& plan, double from_s);

/// The drive needs sensors with a high rate.
inline bool fast(const Plan& plan) noexcept { return plan.frequency_hz > 100; }

/// A gamma of the paper's range, m/s^2; less below 10 Hz, where the stroke limits it. value: 0..1.
double gamma_for(double value, double frequency_hz);

/// Direction of that scene's shaker in the axes of its accelerometer.
std::array<double, 3> shaker_axis();

}  // namespace shaker::orders
