#pragma once
// Settings of a GenICam camera (GigE Vision or USB3 Vision) in a rig file.
#include <array>
#include <optional>
#include <string>

#include "drivers/hardware/genicam/pixel_format.hpp"
#include "drivers/settings_table.hpp"

namespace shaker::genicam {

/// Source of the exposure trigger.
enum class CameraTrigger {
    dac,       // pulses of the DAC's second channel on the camera's trigger line
    software,  // one command per period from the driver; for set-up only, its times have jitter
    free,      // the camera's own clock
};

struct GenicamSettings {
    std::string id;                  // as listed by `shakerd devices`, serial number, or address
    std::array<int, 4> region_px{};  // x, y, width, height on the sensor; width 0: the whole sensor
    double exposure_s = 0.001;
    double frame_rate_hz = 100;  // of the trigger, or of the camera's clock when it runs free
    std::string pixel_format = "Mono8";
    CameraTrigger trigger = CameraTrigger::dac;
    std::string trigger_source = "Line0";
    int packet_bytes = 0;        // in transfer; 0: the largest that gets through
    bool ptp = false;            // synchronise its clock to the network's
    bool chunks = false;         // frame id and time stamp inside the picture
    std::optional<double> gain;  // in the camera's unit, usually dB; empty: unchanged
    double give_up_s = 30;       // s, time to search for a camera that disappeared
};

/// Reads and checks these keys: id (required), region_px, exposure_s, frame_rate_hz, pixel_format, trigger
/// ("dac", "software", "free"), trigger_source, packet_bytes, ptp, chunks, gain, give_up_s. Throws
/// InputError.
GenicamSettings read_genicam_settings(SettingsTable& table);

}  // namespace shaker::genicam
