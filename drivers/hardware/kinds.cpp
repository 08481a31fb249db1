#include "drivers/hardware/kinds.hpp"

namespace shaker::hardware {

std::vector<ListedKind> list_devices(const Search& search, const Kinds& kinds) {
    std::vector<ListedKind> all;
    const auto add = [&](const auto& table) {
        for (const auto& kind : table) all.push_back({kind.heading, kind.key, kind.list(search)});
    };
    add(kinds.dacs);
    add(kinds.accelerometers);
    add(kinds.cameras);
    return all;
}

std::vector<NamedAccess> access_of(SettingsTable& root, const Kinds& kinds) {
    SettingsTable dac = root.table("dac"), accelerometer = root.table("accelerometer");
    std::vector<NamedAccess> all{
        {"[dac]", read_kind(dac, kinds.dacs, true).access(dac)},
        {"[accelerometer]", read_kind(accelerometer, kinds.accelerometers, true).access(accelerometer)}};
    for (SettingsTable& camera : root.tables("camera"))
        all.push_back({"[[camera]] " + camera.text("name", ""),
                       read_kind(camera, kinds.cameras, false).access(camera)});
    if (root.has("abort")) all.push_back({"[abort]", {{.device_class = "char-gpiochip"}}});
    return all;
}

}  // namespace shaker::hardware
