#include "daemon/remote/web/actions.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

#include "daemon/campaign/lead/plans.hpp"
#include "daemon/remote/web/order_fields.hpp"
#include "drivers/errors.hpp"
#include "drivers/point_fields.hpp"

namespace shaker::web {

namespace {

using nlohmann::json;
using service::OrderWhat, service::PendingOrders;

constexpr int bad_request = 400, not_found = 404, conflict = 409, gateway_timeout = 504;
const Answer well{200, R"({"ok":true})"};

constexpr std::array<std::string_view, drive_fields> drive_keys{"frequency_hz", "gamma_mps2", "rho",
                                                                "phi_rad"};
constexpr auto start_keys = [] {
    std::array<std::string_view, measurement_fields.size() + drive_fields> keys{};
    const auto end = std::ranges::transform(measurement_fields, keys.begin(), &MeasurementField::key).out;
    std::ranges::copy(drive_keys, end);
    return keys;
}();
constexpr std::array<std::string_view, 1> plan_keys{"plan"};
constexpr std::array<std::string_view, 7> campaign_keys{"plan",  "scan",    "from",   "to",
                                                        "steps", "periods", "repeats"};
constexpr std::array<std::string_view, 2> mu_keys{"mu", "sigma"};
constexpr std::array<std::string_view, 1> targets_keys{"targets"};
constexpr std::array<std::string_view, 3> target_keys{"camera", "target", "region_px"};
constexpr std::array<std::string_view, 1> remark_keys{"text"};
constexpr std::array<std::string_view, 1> loop_keys{"closed"};
constexpr std::array<std::string_view, 3> record_keys{"on", "name", "frames"};

Drive drive_of(const json& body, const Drive& otherwise) {
    PointSettings point{.drive = otherwise};
    for (const std::string_view key : drive_keys) {
        const PointField& field = *std::ranges::find(point_fields, key, &PointField::key);
        field.set(point, quantity_at(body, key, field.dimension, field.allowed, field.in(point)));
    }
    return point.drive;
}

OrderWhat set_drive_of(const json& body, const PendingOrders& pending_orders) {
    return service::SetDrive{drive_of(body, pending_orders.drive())};
}

OrderWhat begin_of(const json& body, const PendingOrders& pending_orders) {
    MeasurementPlan plan = pending_orders.settings().run.plan;
    for (const MeasurementField& field : measurement_fields)
        plan.*field.member = whole_at(body, field.key, field.lasts ? plan.*field.member : 0, field.allowed);
    service::Begin begin{plan};
    if (std::ranges::any_of(drive_keys, [&](std::string_view key) { return body.contains(key); }))
        begin.drive = drive_of(body, pending_orders.drive());
    return begin;
}

OrderWhat mu_of(const json& body, const PendingOrders& /*pending_orders*/) {
    if (!body.contains("mu")) throw InputError{"mu: missing; expected the friction coefficient as a number"};
    const double mu = quantity_at(body, "mu", Dimension::ratio, allowed_friction, NAN);
    return service::GiveMu{{mu, quantity_at(body, "sigma", Dimension::ratio, {0, mu}, 0)}};
}

/// {"targets": [{"camera", "target", "region_px": [x, y, width, height]}, ...]}
OrderWhat targets_of(const json& body, const PendingOrders& /*pending_orders*/) {
    if (!body.contains("targets") || !body["targets"].is_array())
        throw InputError{"targets: expected a list of objects with camera, target and region_px"};
    service::MoveTargets order;
    for (const json& given : body["targets"]) {
        const bool named = given.is_object() && given.contains("camera") && given["camera"].is_string() &&
                           given.contains("target") && given["target"].is_string();
        if (!named)
            throw InputError{fmt::format(
                "targets: expected an object with the names camera and target, got {}", given.dump())};
        require_known(given, target_keys);
        const json region = given.value("region_px", json{});
        if (!region.is_array() || region.size() != 4 ||
            !std::ranges::all_of(region, [](const json& x) { return x.is_number(); }))
            throw InputError{
                fmt::format("region_px: expected four numbers x, y, width, height, got {}", region.dump())};
        order.targets.push_back({given["camera"].get<std::string>(), given["target"].get<std::string>(),
                                 region.get<std::array<double, 4>>()});
    }
    return order;
}

OrderWhat remark_of(const json& body, const PendingOrders& /*pending_orders*/) {
    if (!body.contains("text") || !body["text"].is_string())
        throw InputError{"text: expected the remark as a string"};
    return service::Remark{body["text"].get<std::string>()};
}

OrderWhat loop_of(const json& body, const PendingOrders& /*pending_orders*/) {
    if (!body.contains("closed") || !body["closed"].is_boolean())
        throw InputError{"closed: expected true or false"};
    return service::CloseLoop{body["closed"].get<bool>()};
}

/// {"name": null} alone ends the recording.
OrderWhat record_of(const json& body, const PendingOrders& pending_orders) {
    const bool no_name = body.contains("name") && body["name"].is_null();
    service::Record record{.on = flag_at(body, "on").value_or(!no_name),
                           .name = no_name ? "" : text_at(body, "name").value_or(""),
                           .pictures = pending_orders.settings().record.pictures};
    if (body.contains("frames")) {
        const auto kept = recorded::kept_pictures_named(
            body["frames"].is_string() ? body["frames"].get<std::string>() : std::string{});
        if (!kept)
            throw InputError{fmt::format("frames: expected \"{}\", got {}",
                                         fmt::join(recorded::kept_pictures_words, "\", \""),
                                         body["frames"].dump())};
        record.pictures = *kept;
    }
    return record;
}

/// {"plan": NAME}, or a scan: {"scan": "phi" or "gamma", "from", "to", "steps", "periods", "repeats"}, where
/// the set-point gives the other parameters.
service::MeasurePlan plan_of(const json& body, const PendingOrders& pending_orders) {
    if (body.contains("plan") == body.contains("scan"))
        throw InputError{"campaign: expected either plan, the name of a plan, or scan, \"phi\" or \"gamma\""};
    if (body.contains("plan")) {
        require_known(body, plan_keys);
        return service::MeasurePlan{*text_at(body, "plan")};
    }
    const std::string of = *text_at(body, "scan");
    campaign::Scan scan{.phi = of == "phi", .rest = pending_orders.drive()};
    if (!scan.phi && of != "gamma")
        throw InputError{fmt::format("scan: {}; expected \"phi\" or \"gamma\"", body["scan"].dump())};
    const PointField& field = point_field(of);
    for (const auto& [key, value] : {std::pair{"from", &scan.from}, {"to", &scan.to}}) {
        *value = quantity_at(body, key, field.dimension, field.allowed, NAN);
        if (std::isnan(*value))
            throw InputError{
                fmt::format("{}: missing; expected a number in SI units, or a text with a unit", key)};
    }
    scan.steps = whole_at(body, "steps", 0, {1, 1000});
    scan.periods = whole_at(body, "periods", pending_orders.settings().run.plan.periods,
                            measurement_fields.front().allowed);
    scan.repeats = whole_at(body, "repeats", 1, {1, 1000});
    return service::MeasurePlan{"scan", campaign::text_of(scan)};
}

OrderWhat campaign_of(const json& body, const PendingOrders& pending_orders) {
    return plan_of(body, pending_orders);
}

OrderWhat check_of(const json& body, const PendingOrders& pending_orders) {
    const service::MeasurePlan asked = plan_of(body, pending_orders);
    return service::CheckPlan{asked.name, asked.text};
}

template <class Order>
OrderWhat plain(const json& /*body*/, const PendingOrders& /*pending_orders*/) {
    return Order{};
}

template <campaign::Word word>
OrderWhat campaign_word(const json& /*body*/, const PendingOrders& /*pending_orders*/) {
    return service::TellCampaign{word};
}

/// An action that gives an order. All others are in Actions::act().
struct Action {
    std::string_view name;
    Keys keys;  // of its body
    OrderWhat (*order)(const json& body, const PendingOrders& pending_orders);
};

constexpr std::array<Action, 19> actions{{
    {"drive", drive_keys, set_drive_of},
    {"start", start_keys, begin_of},
    {"stop", {}, plain<service::End>},
    {"identify", {}, plain<service::Identify>},
    {"middle", {}, plain<service::BringToMiddle>},
    {"reset-walker", {}, plain<service::PutWalkerBack>},
    {"clear", {}, plain<service::ClearTrip>},
    {"campaign", campaign_keys, campaign_of},
    {"campaign/check", campaign_keys, check_of},
    {"campaign/pause", {}, campaign_word<campaign::Word::pause>},
    {"campaign/resume", {}, campaign_word<campaign::Word::resume>},
    {"campaign/skip", {}, campaign_word<campaign::Word::skip>},
    {"campaign/repeat", {}, campaign_word<campaign::Word::repeat>},
    {"campaign/stop", {}, campaign_word<campaign::Word::stop>},
    {"mu", mu_keys, mu_of},
    {"targets", targets_keys, targets_of},
    {"remark", remark_keys, remark_of},
    {"loop", loop_keys, loop_of},
    {"record", record_keys, record_of},
}};

}  // namespace

Answer refusal(int status, const std::string& why) {
    return {status, json{{"error", why}}.dump(-1, ' ', false, json::error_handler_t::replace)};
}

void Actions::abort(const std::string& who, Done done) {
    access::Aborts::Receipt receipt = aborts_.give(who);
    if (done) unanswered_.push_back({std::move(receipt), std::move(done)});
}

void Actions::update() {
    using access::Aborts;
    for (auto u = unanswered_.begin(); u != unanswered_.end();) {
        const Aborts::Answer answer = u->receipt();
        if (answer == Aborts::Answer::none) {
            ++u;
            continue;
        }
        const Done done = std::move(u->done);
        u = unanswered_.erase(u);
        done(answer == Aborts::Answer::obeyed ? well : refusal(gateway_timeout, Aborts::silent_text));
    }
}

void Actions::act(const std::string& name, const std::string& body, const std::string& who,
                  const Done& done) {
    if (name == "abort") return abort(who, done);
    const auto held = [&] { return refusal(conflict, access::held_text(lock_.owner())); };
    try {
        if (name == "control/release" || name == "control/request") {
            require_no_fields(body);
            if (name == "control/request") return done(lock_.request(who) ? well : held());
            lock_.release(who);
            return done(well);
        }
        const auto* action = std::ranges::find(actions, name, &Action::name);
        if (action == actions.end()) return done(refusal(not_found, "there is no action \"" + name + "\""));
        const OrderWhat order = action->order(fields_of(body, action->keys), pending_orders_);
        if (!lock_.allows(who)) return done(held());
        pending_orders_.order(order, who, [done](const std::string& refused) {
            done(refused.empty() ? well : refusal(conflict, refused));
        });
    } catch (const InputError& e) {
        done(refusal(bad_request, e.what()));
    }
}

}  // namespace shaker::web
