#pragma once
// Devices and views as attributes of a recording's groups.
#include "drivers/devices.hpp"
#include "drivers/replay/h5.hpp"

namespace shaker {

void describe(hid_t group, const DacInfo& dac);
void describe(hid_t group, const AccelerometerInfo& accelerometer);
void describe(hid_t group, const View& view);

/// As they were described; paths are under `entry`. InputError naming what is missing or out of range.
DacInfo read_dac(hid_t entry, const std::string& path);
AccelerometerInfo read_accelerometer(hid_t entry, const std::string& path);
View read_view(hid_t entry, const std::string& camera);
/// An attribute that is a whole number in min..max.
int whole_attribute(hid_t at, const std::string& path, const std::string& name, int min, int max);
/// The attribute "order" of one of `count` things.
std::size_t place_of(hid_t entry, const std::string& path, std::size_t count);

}  // namespace shaker
