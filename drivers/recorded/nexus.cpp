#include "drivers/recorded/nexus.hpp"

#include <algorithm>
#include <array>

#include "drivers/text/sha256.hpp"

namespace shaker::recorded {

namespace {

struct Sensor {
    const char* name;
    const char* result;
};
constexpr std::array<Sensor, 4> controllers{
    {{"gamma", "gamma"}, {"phi", "phi"}, {"rho", "rho"}, {"frequency", "frequency"}}};
constexpr std::array<Sensor, 3> measured{
    {{"v_drift", "v_D"}, {"drift_per_period", "D"}, {"efficiency", "efficiency"}}};

void link(hid_t group, const std::string& name, const std::string& to) {
    h5::check(H5Lcreate_soft(to.c_str(), group, name.c_str(), H5P_DEFAULT, H5P_DEFAULT), name);
}

void text_with(hid_t group, const std::string& name, const std::string& text, const std::string& key,
               const std::string& attribute) {
    h5::write_text(group, name, text);
    const h5::Handle set{H5Dopen2(group, name.c_str(), H5P_DEFAULT), name};
    h5::set_attribute(set.get(), key, attribute);
}

template <std::size_t N>
void link_all(hid_t entry, hid_t environment, const std::array<Sensor, N>& sensors, const std::string& list,
              const std::string& control, const std::string& description) {
    std::vector<std::string> names;
    for (const Sensor& s : sensors) {
        names.emplace_back(s.name);
        const h5::Handle group = h5::make_group(environment, s.name, "NXsensor");
        const std::string result = std::string{"/entry/results/"} + s.result;
        link(group.get(), "value", result);
        link(group.get(), "value_errors", result + "_errors");
        if (h5::exists(entry, "start_time")) link(group.get(), "value_timestamp", "/entry/start_time");
        text_with(group.get(), "run_control", control, "description", description);
    }
    h5::write_texts(environment, list, names);
}

}  // namespace

void define_entry(hid_t entry, const std::vector<GroupLayout>& groups) {
    text_with(entry, "definition", "NXsensor_scan", "version", "v2024.02");
    if (std::ranges::find(groups, "cycle", &GroupLayout::path) != groups.end())
        h5::set_attribute(entry, "default", std::string{"cycle"});
}

void describe_program(hid_t process, const std::string& config) {
    text_with(process, "program", "shakerd", "version", SHAKER_VERSION);
    h5::write_text(process, "config_text", config);
    h5::write_text(process, "config_sha256", text::sha256(config));
}

void link_sensors(hid_t entry) {
    if (!h5::exists(entry, "results")) return;
    const h5::Handle instrument = h5::make_group(entry, "instrument", "NXinstrument");
    const h5::Handle environment = h5::make_group(instrument.get(), "environment", "NXenvironment");
    link_all(entry, environment.get(), controllers, "independent_controllers", "held",
             "one setting per recording; the value is from the measured acceleration of the base");
    link_all(entry, environment.get(), measured, "measurement_sensors", "measured",
             "from all measured periods of the recording");
}

void set_plot_attribute(hid_t group, const std::string& key, const std::string& text) {
    if (key != "axes") {
        h5::set_attribute(group, key, text);
        return;
    }
    h5::set_attribute(group, key, std::vector<std::string>{text});
    h5::set_attribute(group, text + "_indices", std::int64_t{0});
}

}  // namespace shaker::recorded
