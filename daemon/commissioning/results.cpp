#include "daemon/commissioning/results.hpp"

#include <spdlog/fmt/fmt.h>

#include "drivers/errors.hpp"

namespace shaker::commissioning {

namespace {

constexpr double longest_stop_s = 1;

}  // namespace

void Results::add(const std::string& name, const std::string& result) {
    person_.show(fmt::format("ok   {}: {}\n", name, result));
    items_.push_back({name, result});
}

void Results::add_stop(const std::string& name, const std::string& what, const SeenStop& stop,
                       const std::string& more) {
    const std::string seen = fmt::format("stopped {:.0f} ms after {}, ramp of {:.1f} ms", 1e3 * stop.after_s,
                                         what, 1e3 * stop.ramp_s);
    if (stop.after_s > longest_stop_s) throw DeviceError{name + ": " + seen};
    add(name, seen + more);
}

bool Results::agreed(const std::string& name, const std::string& question) {
    const std::string answer = person_.ask(question + " [y/n] ");
    person_.rethrow();
    if (answer == "y") {
        add(name, "confirmed by the operator");
        return true;
    }
    person_.show(fmt::format("BAD  {}: not confirmed; no record was written\n", name));
    return false;
}

}  // namespace shaker::commissioning
