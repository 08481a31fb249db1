#include "drivers/hardware/alsa_input/kind.hpp"

#include "drivers/hardware/alsa/kind.hpp"
#include "drivers/hardware/alsa_input/alsa_accelerometer.hpp"

namespace shaker::alsa_input {

hardware::OpenAccelerometer read_kind(SettingsTable& table) {
    return [settings = read_input_settings(table)](hardware::Notes& notes) {
        return open_alsa_accelerometer(settings, notes);
    };
}

std::vector<hardware::ListedDevice> list_kind(const hardware::Search& search) {
    return alsa::listed(alsa::Direction::capture, search);
}

}  // namespace shaker::alsa_input
