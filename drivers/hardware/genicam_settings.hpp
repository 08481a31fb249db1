#pragma once
// What a rig file asks of a GenICam camera (GigE Vision or USB3 Vision).
#include <array>
#include <optional>
#include <string>

#include "drivers/hardware/pixel_format.hpp"
#include "drivers/settings_table.hpp"

namespace shaker {

/// Who starts an exposure.
enum class CameraTrigger {
    dac,       // a pulse on the camera's trigger line, sent by the DAC's second channel
    software,  // the driver, by a command once a period; for set-up only, its times scatter
    free,      // the camera's own clock
};

struct GenicamSettings {
    std::string id;                  // as `shakerd devices` lists it, its serial number, or an address
    std::array<int, 4> region_px{};  // x, y, width, height on the sensor; width 0: the whole sensor
    double exposure_s = 0.001;
    double frame_rate_hz = 100;  // of the trigger, or of the camera's own clock when it runs free
    std::string pixel_format = "Mono8";
    CameraTrigger trigger = CameraTrigger::dac;
    std::string trigger_source = "Line0";
    int packet_bytes = 0;        // on the wire; 0: the largest that gets through
    bool ptp = false;            // its clock follows the network's
    bool chunks = false;         // frame id and time stamp inside the picture
    std::optional<double> gain;  // in the camera's unit, mostly dB; none: as it is
    double give_up_s = 30;       // for how long a camera that went away is looked for
};

/// Reads and checks these keys: id (required), region_px, exposure_s, frame_rate_hz, pixel_format, trigger
/// ("dac", "software", "free"), trigger_source, packet_bytes, ptp, chunks, gain, give_up_s. Throws
/// InputError.
GenicamSettings read_genicam_settings(SettingsTable& table);

}  // namespace shaker
