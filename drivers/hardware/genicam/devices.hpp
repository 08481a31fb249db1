#pragma once
// Lists the GenICam cameras.
#include <string>
#include <vector>

#include "drivers/quantity.hpp"

namespace shaker::genicam {

struct GenicamDevice {
    std::string id;       // stable: vendor, model, serial number
    std::string address;  // IP or USB address; may change
    std::string vendor;
    std::string model;
    std::string serial;
    std::string protocol;  // "GigEVision", "USB3Vision"
    // Read from the camera:
    int sensor_width = 0;  // pixels
    int sensor_height = 0;
    std::vector<std::string> pixel_formats;
    Range rate_hz{0, 0};
    std::vector<std::string> trigger_sources;
    std::string trouble;  // why the fields above could not be read; empty: they are valid
};

/// Searches every network and USB port; takes a second or more. Opens each camera briefly, which does not
/// disturb one that another program controls. Not from two threads at once.
std::vector<GenicamDevice> list_genicam_devices();

}  // namespace shaker::genicam
