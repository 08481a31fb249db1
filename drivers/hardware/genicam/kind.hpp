#pragma once
// The row of this folder in a table of kinds, and the devices that are connected.
#include <vector>

#include "drivers/hardware/kind/device_kind.hpp"

namespace shaker::genicam {

hardware::OpenCamera read_kind(SettingsTable& table, View& view);
/// Searches every network and USB port; takes a second or more. Opens each camera briefly, which does not
/// disturb one that another program controls. Not from two threads at once.
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
