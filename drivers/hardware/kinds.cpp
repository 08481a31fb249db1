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

}  // namespace shaker::hardware
