#include <spdlog/fmt/chrono.h>
#include <spdlog/fmt/fmt.h>

#include <ctime>
#include <nlohmann/json.hpp>
#include <thread>

#include "daemon/remote/ctl/outcome.hpp"
#include "daemon/remote/ctl/state_text.hpp"
#include "daemon/remote/ctl/table.hpp"
#include "drivers/text/printable.hpp"

namespace shaker::ctl {

namespace {

using nlohmann::json;

constexpr std::chrono::seconds line_every{1};
constexpr std::chrono::milliseconds look_again{
    50};  // interval between attempts to connect to a starting daemon

// ASCII only, so that it contains no control sequence for the terminal.
std::string line_of(const json& j) { return j.dump(-1, ' ', true, json::error_handler_t::replace) + "\n"; }

Clock::time_point after(const Values& values, const char* option) {
    if (!values.has(option)) return Clock::time_point::max();
    return Clock::now() +
           std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>{values.number(option)});
}

std::string time_of_day() { return fmt::format("{:%H:%M:%S}", fmt::localtime(std::time(nullptr))); }

}  // namespace

std::optional<json> state_when(const Link& link, Clock::time_point until,
                               const std::function<bool(const json&)>& wanted) {
    LiveMessages messages{link};
    while (auto message = messages.next(until)) {
        if ((*message)["type"] != "state") continue;
        if (wanted(*message)) return message;
        if (state_of(*message) == "tripped") throw Refused{"the drive was stopped: " + trip_of(*message)};
    }
    return std::nullopt;
}

void status(const Values& values) {
    const json state = link_of(values).get_json("/api/state");
    print(values.has("--json") ? line_of(state) : state_text(state));
}

void watch(const Values& values) {
    const bool whole = values.has("--json");
    const Clock::time_point until = after(values, "--seconds");
    LiveMessages messages{link_of(values)};
    Clock::time_point line_due{};
    while (const auto message = messages.next(until)) {
        if (nobody_reads()) return;
        if (whole) {
            print(line_of(*message));
        } else if ((*message)["type"] == "event") {
            print(event_text(*message) + "\n");
        } else if (const auto now = Clock::now(); (*message)["type"] == "state" && now >= line_due) {
            line_due = now + line_every;
            print(time_of_day() + "  " + state_line(*message) + "\n");
        }
    }
}

void fetch(const Values& values) {
    const Link link = link_of(values);
    const std::string what = values.text("WHAT");
    if (what == "metrics") return print(printable(link.get("/metrics"), true));
    if (what == "result") return print(line_of(link.get_json("/api/result")));
    const json state = link.get_json("/api/state");
    print(line_of(what == "points" ? state.value("points", json::array()) : state));
}

void wait_for(const Values& values) {
    const std::string word = values.text("STATE");
    const auto there = [&](const json& state) { return state_of(state) == word; };
    const Clock::time_point until = after(values, "--timeout"), come = Clock::now() + patience;
    for (;; std::this_thread::sleep_for(look_again)) {
        try {
            if (state_when(link_of(values), until, there)) return;
            break;
        } catch (const NobodyListens&) {  // the daemon may still be starting
            if (Clock::now() >= come) throw;
            if (Clock::now() >= until) break;
        }
    }
    throw TimedOut{fmt::format("the bench was not {} within {}", word, values.text("--timeout"))};
}

}  // namespace shaker::ctl
