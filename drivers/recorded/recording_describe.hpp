#pragma once
// Writes devices and views as attributes of a recording's groups, and reads them.
#include "drivers/devices.hpp"
#include "drivers/recorded/h5/h5.hpp"

namespace shaker::recorded {

void describe(hid_t group, const DacInfo& dac);
void describe(hid_t group, const AccelerometerInfo& accelerometer);
void describe(hid_t group, const View& view);

/// Reads the descriptions; paths are under `entry`. InputError that names a missing value or one out of
/// range.
DacInfo read_dac(hid_t entry, const std::string& path);
AccelerometerInfo read_accelerometer(hid_t entry, const std::string& path);
View read_view(hid_t entry, const std::string& camera);
/// An integer attribute in min..max.
int whole_attribute(hid_t at, const std::string& path, const std::string& name, int min, int max);
/// The attribute "order", which must be below `count`.
std::size_t place_of(hid_t entry, const std::string& path, std::size_t count);

}  // namespace shaker::recorded
