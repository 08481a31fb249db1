#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <thread>

#include "daemon/manual/values.hpp"
#include "daemon/remote/ctl/outcome.hpp"
#include "daemon/remote/ctl/state_text.hpp"
#include "daemon/remote/ctl/table.hpp"
#include "drivers/errors.hpp"
#include "drivers/text/printable.hpp"

namespace shaker::ctl {

namespace {

using nlohmann::json;

constexpr std::chrono::seconds abort_patience{2}, clear_patience{2};
constexpr std::chrono::milliseconds state_turn{50};

void wait_for_rest(const Link& link) {
    state_when(link, Clock::time_point::max(), [](const json& state) {
        const std::string word = state_of(state);
        const bool finished = state.value(json::json_pointer{"/session/recording"}, json{}).is_null();
        return finished && (word == "idle" || word == "armed");
    });
}

json fields_of(const orders::Row& row, const Values& values) {
    json fields = json::object();
    for (const orders::Field& f : row.fields) {
        if (f.option.empty() || !values.has(f.option)) continue;
        json& to = fields[std::string{f.key}];
        if (f.kind == orders::Kind::quantity)
            to = values.number(f.option);
        else if (f.kind == orders::Kind::whole)
            to = values.whole(f.option);
        else if (f.kind == orders::Kind::flag)
            to = values.text(f.option) == "on";
        else
            to = values.text(f.option);
    }
    return fields;
}

void wait_for_campaign(const Link& link) {
    const json state = *state_when(link, Clock::time_point::max(), [](const json& s) {
        const json& campaign = s.at("campaign");
        if (campaign.is_object() && campaign.value("paused", false))
            throw Refused{"the campaign is paused: " + campaign.value("newest", std::string{})};
        return !campaign.is_object() || !campaign.value("active", false);
    });
    const json& campaign = state.at("campaign");
    print(fmt::format("{} of {} points have ended; folder {}\n", campaign.at("ended").get<int>(),
                      campaign.at("points").get<int>(), campaign.at("folder").get<std::string>()));
}

}  // namespace

void give_order(const orders::Row& row, const Values& values) {
    link_of(values).order(std::string{row.name}, fields_of(row, values));
    const bool drives = std::ranges::find(row.fields, "--gamma", &orders::Field::option) != row.fields.end();
    if (const std::string doubt = drives ? manual::doubtful_gamma(values) : ""; !doubt.empty())
        fmt::print(stderr, "shakerctl: {}\n", doubt);
}

void set_drive(const Values& values) {
    const orders::Row& row = orders::row("drive");
    if (fields_of(row, values).empty())
        throw InputError{"set: nothing to set; expected --gamma, --phi, --rho or --frequency"};
    give_order(row, values);
}

void start(const Values& values) {
    const Link link = link_of(values);
    give_order(orders::row("start"), values);
    if (!values.has("--wait")) return;
    bool driven = false;
    const json measured = *state_when(link, Clock::time_point::max(), [&](const json& state) {
        if (has_result(state)) return true;
        const std::string word = state_of(state);
        const bool silent = word == "idle" || word == "armed" || word == "finishing";
        if (driven && silent) throw Refused{"the drive was stopped before a measurement was complete"};
        driven = driven || !silent;
        return false;
    });
    print(drift_text(measured) + "\n");
}

void stop(const Values& values) {
    const Link link = link_of(values);
    link.order("stop", {});
    if (values.has("--wait")) wait_for_rest(link);
}

void abort(const Values& values) try {
    link_of(values).order("abort", {}, abort_patience);
    print("aborted\n");
} catch (const NotReached& e) {
    throw NotReached{std::string{"the daemon did not confirm the abort; use the emergency stop: "} +
                     e.what()};
}

void middle(const Values& values) {
    const Link link = link_of(values);
    link.order("middle", {});
    if (values.has("--wait")) wait_for_rest(link);
}

void targets(const Values& values) {
    const Link link = link_of(values);
    const int given = values.has("--camera") + values.has("--target") + values.has("--region");
    if (given == 3) {
        const json region = json::parse("[" + values.text("--region") + "]", nullptr, false);
        return link.order("targets", {{"targets",
                                       {{{"camera", values.text("--camera")},
                                         {"target", values.text("--target")},
                                         {"region_px", region.is_array() ? region : json{}}}}}});
    }
    if (given > 0)
        throw InputError{"targets: --camera, --target and --region belong together; one is missing"};
    const json state = link.get_json("/api/state");
    for (const json& camera : state.at("cameras")) {
        for (const json& target : camera.at("targets"))
            print(printable(fmt::format("{} {} region {} proposed {}\n", camera.at("name").get<std::string>(),
                                        target.at("name").get<std::string>(), target.at("region_px").dump(),
                                        target.at("proposed_px").dump()),
                            true));
        if (const json& why = camera.at("not_found"); why.is_string())
            print(printable(why.get<std::string>() + "\n", true));
    }
}

// Exit status 1 when a point does not fit.
void check_plan(const Link& link, const std::string& plan) {
    link.order("campaign/check", {{"plan", plan}});
    const json state = *state_when(link, Clock::time_point::max(), [](const json& s) {
        return !s.at("plan_check").at("under_way").get<bool>();
    });
    const json& check = state.at("plan_check");
    for (const json& misfit : check.at("misfits")) print(misfit.get<std::string>() + "\n");
    print(check.at("summary").get<std::string>() + "\n");
    const int points = check.at("points").get<int>(), misfits = points - check.at("fit").get<int>();
    if (misfits > 0) throw Refused{fmt::format("{} of {} points do not fit", misfits, points)};
}

void campaign(const Values& values) {
    const Link link = link_of(values);
    const std::string what = values.text("WHAT"), plan = values.text("--plan");
    const bool of_plan = what == "start" || what == "check";
    if (plan.empty() == of_plan)
        throw InputError{
            of_plan
                ? fmt::format("campaign {}: --plan is missing; \"shakerctl campaign plans\" lists the plans",
                              what)
                : fmt::format("campaign {}: --plan {} is of check and start only", what, plan)};
    if (what == "plans") {
        const json state = *state_when(link, Clock::time_point::max(), [](const json&) { return true; });
        for (const json& name : state.at("plans")) print(name.get<std::string>() + "\n");
        return;
    }
    if (what == "check") return check_plan(link, plan);
    if (what == "start")
        link.order("campaign", {{"plan", plan}});
    else
        link.order("campaign/" + what, {});
    if (values.has("--wait")) wait_for_campaign(link);
}

void scan(const Values& values) {
    const Link link = link_of(values);
    link.order("campaign", fields_of(orders::row("campaign"), values));
    if (values.has("--wait")) wait_for_campaign(link);
}

void clear(const Values& values) {
    const Link link = link_of(values);
    link.order("clear", {});
    // The output clears the trip a moment after the order was accepted.
    const Clock::time_point until = Clock::now() + clear_patience;
    while (state_of(link.get_json("/api/state")) == "tripped" && Clock::now() < until)
        std::this_thread::sleep_for(state_turn);
}

}  // namespace shaker::ctl
