#include "drivers/mixer/mixer.hpp"

#include <sstream>

namespace shaker {

std::map<std::string, std::string> settable_controls(const std::string& controls) {
    constexpr std::string_view between = " = ";
    std::map<std::string, std::string> found;
    std::istringstream in{controls};
    for (std::string line; std::getline(in, line);) {
        const std::size_t at = line.rfind(between);
        if (!line.starts_with("- ") && at != std::string::npos)
            found[line.substr(0, at)] = line.substr(at + between.size());
    }
    return found;
}

std::vector<std::string> mixer_changes(const std::string& then, const std::string& now) {
    const auto wanted = settable_controls(then), present = settable_controls(now);
    const auto kept = [](const std::string& controls, const std::string& name, const std::string& values) {
        return controls.find("- " + name + " = " + values + "\n") != std::string::npos;
    };
    std::vector<std::string> changes;
    for (const auto& [name, values] : wanted) {
        const auto found = present.find(name);
        if (found != present.end() && found->second != values)
            changes.push_back(name + " is " + found->second + " instead of " + values);
        if (found == present.end() && !kept(now, name, values)) changes.push_back(name + " is missing");
    }
    for (const auto& [name, values] : present)
        if (!wanted.contains(name) && !kept(then, name, values))
            changes.push_back(name + " is new: " + values);
    return changes;
}

}  // namespace shaker
