#pragma once
// The row of this folder in a table of kinds, and the devices that are connected.
#include <string>
#include <vector>

#include "drivers/hardware/kind/device_kind.hpp"
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

hardware::OpenCamera read_kind(SettingsTable& table, View& view);
std::vector<hardware::ListedDevice> list_kind(const hardware::Search& search);

inline constexpr hardware::CameraKind genicam_kind{
    .name = "genicam",
    .heading = "[[camera]] GenICam",
    .key = "genicam_cameras",
    .read = read_kind,
    .list = list_kind,
    .search = {},
    .advice = {
        .silent = "does the trigger line reach it, and is its trigger input the one named in the rig file?",
        .rate_off = "is its frame rate limited by exposure or network?"}};

}  // namespace shaker::genicam
