#pragma once
// Items that readers of NeXus files expect: application definition, default plot, and sensors for settings
// and results.
#include "drivers/recorded/h5/h5.hpp"
#include "drivers/recorded/recording_file.hpp"

namespace shaker::recorded {

/// Writes entry/definition and entry@default, which is "cycle" if that group exists.
void define_entry(hid_t entry, const std::vector<GroupLayout>& groups);
/// Writes process/program with its version, and the settings with their SHA-256 as config_sha256.
void describe_program(hid_t process, const std::string& config);
/// Creates an NXsensor under instrument/environment for each of gamma, phi, rho, frequency and for the
/// measured quantities; their values are links to the results. Does nothing if there are no places for
/// results.
void link_sensors(hid_t entry);
/// Sets an attribute of a group. The axis of an NXdata is a list and has its dimension beside it.
void set_plot_attribute(hid_t group, const std::string& key, const std::string& text);

}  // namespace shaker::recorded
