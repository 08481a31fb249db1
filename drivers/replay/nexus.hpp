#pragma once
// What readers of NeXus files look for beyond a recording's own groups: the application definition, the
// default plot, and what was set and measured as sensors.
#include "drivers/replay/h5.hpp"
#include "drivers/replay/session_layout.hpp"

namespace shaker {

/// entry/definition and entry@default, which is "cycle" where there is such a group.
void define_entry(hid_t entry, const std::vector<GroupLayout>& groups);
/// process/program with its version, and the settings with their SHA-256 as config_sha256.
void describe_program(hid_t process, const std::string& config);
/// An NXsensor for each of gamma, phi, rho, frequency and for what they cause, under instrument/environment;
/// their values are links to the results. Nothing where there is no place for results.
void link_sensors(hid_t entry);
/// One of a group's attributes; the axis of an NXdata as a list, beside the dimension that it belongs to.
void set_plot_attribute(hid_t group, const std::string& key, const std::string& text);

}  // namespace shaker
