#include "daemon/remote/ctl/orders.hpp"

#include <nlohmann/json.hpp>

#include "daemon/remote/ctl/looks.hpp"
#include "daemon/remote/ctl/state_text.hpp"
#include "daemon/remote/ctl/terminal.hpp"
#include "daemon/remote/ctl/trouble.hpp"
#include "drivers/errors.hpp"

namespace shaker::ctl {

namespace {

using nlohmann::json;

constexpr std::chrono::seconds abort_patience{2};

}  // namespace

void set_drive(const Given& given) {
    json drive = json::object();
    const auto take = [&](const char* option, const char* key) {
        if (given.has(option)) drive[key] = given.number(option);
    };
    take("--gamma", "gamma_mps2");
    take("--phi", "phi_rad");
    take("--rho", "rho");
    take("--frequency", "frequency_hz");
    if (drive.empty())
        throw InputError{"set: nothing to set; --gamma, --phi, --rho or --frequency was expected"};
    link_of(given).order("drive", drive);
}

void identify(const Given& given) { link_of(given).order("identify", {}); }

void start(const Given& given) {
    json fields = json::object();
    if (given.has("--periods")) fields["periods"] = static_cast<int>(given.number("--periods"));
    if (given.has("--settle")) fields["settle_periods"] = static_cast<int>(given.number("--settle"));
    const Link link = link_of(given);
    link.order("start", fields);
    if (!given.has("--wait")) return;
    bool driven = false;
    const json measured = *state_when(link, Clock::time_point::max(), [&](const json& state) {
        const std::string word = state_of(state);
        const bool silent = word == "idle" || word == "armed";
        if (driven && silent) throw Refused{"the drive was stopped before a measurement was complete"};
        driven = driven || !silent;
        return has_result(state);
    });
    print(drift_text(measured) + "\n");
}

void stop(const Given& given) {
    const Link link = link_of(given);
    link.order("stop", {});
    if (!given.has("--wait")) return;
    state_when(link, Clock::time_point::max(), [](const json& state) {
        const std::string word = state_of(state);
        return word == "idle" || word == "armed";
    });
}

void abort(const Given& given) try {
    link_of(given).order("abort", {}, abort_patience);
    print("aborted\n");
} catch (const NotReached& e) {
    throw NotReached{std::string{"it is not known that the drive was stopped; use the emergency stop: "} +
                     e.what()};
}

void clear(const Given& given) { link_of(given).order("clear", {}); }

void remark(const Given& given) { link_of(given).order("remark", {{"text", given.text("TEXT")}}); }

void record(const Given& given) {
    json fields{{"on", given.text("SWITCH") == "on"}};
    if (given.has("--name")) fields["name"] = given.text("--name");
    if (given.has("--frames")) fields["frames"] = given.text("--frames");
    link_of(given).order("record", fields);
}

}  // namespace shaker::ctl
