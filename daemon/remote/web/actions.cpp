#include "daemon/remote/web/actions.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>

#include "daemon/campaign/lead/plans.hpp"
#include "daemon/run/run_settings.hpp"
#include "drivers/errors.hpp"

namespace shaker::web {

namespace {

using nlohmann::json;

constexpr int bad_request = 400, not_found = 404, conflict = 409, gateway_timeout = 504;
const Answer well{200, R"({"ok":true})"};

double number_at(const json& body, std::string_view key, double otherwise) {
    if (!body.contains(key) || body[key].is_null()) return otherwise;
    if (!body[key].is_number())
        throw InputError{fmt::format("{}: expected a number, got {}", key, body[key].dump())};
    return body[key].get<double>();
}

service::OrderWhat drive_of(const json& body, Drive d) {
    d.frequency = number_at(body, "frequency_hz", d.frequency);
    d.gamma = number_at(body, "gamma_mps2", d.gamma);
    d.rho = number_at(body, "rho", d.rho);
    d.phi = number_at(body, "phi_rad", d.phi);
    return service::SetDrive{d};
}

int whole_at(const json& body, std::string_view key, int otherwise, Range allowed) {
    const double number = number_at(body, key, otherwise);
    if (!(number >= allowed.min && number <= allowed.max) || number != std::floor(number))
        throw InputError{fmt::format("{}: {} is out of range; expected an integer from {} to {}", key, number,
                                     allowed.min, allowed.max)};
    return static_cast<int>(number);
}

service::OrderWhat begin_of(const json& body, const service::PendingOrders& pending_orders) {
    MeasurementPlan plan = pending_orders.settings().run.plan;
    for (const MeasurementField& field : measurement_fields)
        plan.*field.member = whole_at(body, field.key, field.lasts ? plan.*field.member : 0, field.allowed);
    return service::Begin{plan};
}

service::OrderWhat mu_of(const json& body) {
    if (!body.contains("mu")) throw InputError{"mu: missing; expected the friction coefficient as a number"};
    return service::GiveMu{{number_at(body, "mu", NAN), number_at(body, "sigma", 0)}};
}

/// {"targets": [{"camera", "target", "region_px": [x, y, width, height]}, ...]}
service::OrderWhat targets_of(const json& body) {
    if (!body.contains("targets") || !body["targets"].is_array())
        throw InputError{"targets: expected a list of objects with camera, target and region_px"};
    service::MoveTargets order;
    for (const json& given : body["targets"]) {
        const bool named = given.is_object() && given.contains("camera") && given["camera"].is_string() &&
                           given.contains("target") && given["target"].is_string();
        if (!named)
            throw InputError{fmt::format(
                "targets: expected an object with the names camera and target, got {}", given.dump())};
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

service::OrderWhat remark_of(const json& body) {
    if (!body.contains("text") || !body["text"].is_string())
        throw InputError{"text: expected the remark as a string"};
    return service::Remark{body["text"].get<std::string>()};
}

service::OrderWhat loop_of(const json& body) {
    if (!body.contains("closed") || !body["closed"].is_boolean())
        throw InputError{"closed: expected true or false"};
    return service::CloseLoop{body["closed"].get<bool>()};
}

service::OrderWhat record_of(const json& body, recorded::KeptPictures pictures) {
    service::Record record{.on = true, .name = {}, .pictures = pictures};
    if (body.contains("on")) {
        if (!body["on"].is_boolean())
            throw InputError{fmt::format("on: expected true or false, got {}", body["on"].dump())};
        record.on = body["on"].get<bool>();
    }
    if (body.contains("name") && !body["name"].is_null()) {
        if (!body["name"].is_string())
            throw InputError{fmt::format("name: expected a string, got {}", body["name"].dump())};
        record.name = body["name"].get<std::string>();
    } else if (body.contains("name") && !body.contains("on")) {
        record.on = false;  // {"name": null} ends it
    }
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
service::MeasurePlan campaign_of(const json& body, const service::PendingOrders& pending_orders) {
    const auto text = [&](const char* key) {
        if (!body[key].is_string())
            throw InputError{fmt::format("{}: expected a string, got {}", key, body[key].dump())};
        return body[key].get<std::string>();
    };
    if (body.contains("plan") == body.contains("scan"))
        throw InputError{"campaign: expected either plan, the name of a plan, or scan, \"phi\" or \"gamma\""};
    if (body.contains("plan")) return service::MeasurePlan{text("plan")};
    campaign::Scan scan{.phi = text("scan") == "phi", .rest = pending_orders.drive()};
    if (!scan.phi && text("scan") != "gamma")
        throw InputError{fmt::format("scan: {}; expected \"phi\" or \"gamma\"", body["scan"].dump())};
    for (const auto& [key, value] : {std::pair{"from", &scan.from}, {"to", &scan.to}}) {
        *value = number_at(body, key, NAN);
        if (std::isnan(*value))
            throw InputError{fmt::format("{}: missing; expected a number in SI units", key)};
    }
    scan.steps = whole_at(body, "steps", 0, {1, 1000});
    scan.periods = whole_at(body, "periods", pending_orders.settings().run.plan.periods,
                            measurement_fields.front().allowed);
    scan.repeats = whole_at(body, "repeats", 1, {1, 1000});
    return service::MeasurePlan{"scan", campaign::text_of(scan)};
}

std::optional<service::OrderWhat> campaign_word(std::string_view name) {
    const auto word = std::ranges::find(campaign::word_names, name);
    if (word == campaign::word_names.end()) return std::nullopt;
    return service::TellCampaign{static_cast<campaign::Word>(word - campaign::word_names.begin())};
}

std::optional<service::OrderWhat> order_of(const std::string& name, const json& body,
                                           const service::PendingOrders& pending_orders) {
    if (name == "drive") return drive_of(body, pending_orders.drive());
    if (name == "start") return begin_of(body, pending_orders);
    if (name == "stop") return service::End{};
    if (name == "identify") return service::Identify{};
    if (name == "middle") return service::BringToMiddle{};
    if (name == "reset-walker") return service::PutWalkerBack{};
    if (name == "campaign") return campaign_of(body, pending_orders);
    if (name == "campaign/check") {
        const service::MeasurePlan asked = campaign_of(body, pending_orders);
        return service::CheckPlan{asked.name, asked.text};
    }
    if (constexpr std::string_view word = "campaign/"; name.starts_with(word))
        return campaign_word(std::string_view{name}.substr(word.size()));
    if (name == "mu") return mu_of(body);
    if (name == "targets") return targets_of(body);
    if (name == "clear") return service::ClearTrip{};
    if (name == "remark") return remark_of(body);
    if (name == "loop") return loop_of(body);
    if (name == "record") return record_of(body, pending_orders.settings().record.pictures);
    return std::nullopt;
}

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
    if (name == "control/release") {
        lock_.release(who);
        return done(well);
    }
    const auto held = [&] { return refusal(conflict, access::held_text(lock_.owner())); };
    if (name == "control/request") return done(lock_.request(who) ? well : held());
    try {
        const json fields = body.empty() ? json::object() : json::parse(body);
        if (!fields.is_object()) throw InputError{"expected a JSON object of settings"};
        const auto order = order_of(name, fields, pending_orders_);
        if (!order) return done(refusal(not_found, "there is no action \"" + name + "\""));
        if (!lock_.allows(who)) return done(held());
        pending_orders_.order(*order, who, [done](const std::string& refused) {
            done(refused.empty() ? well : refusal(conflict, refused));
        });
    } catch (const json::exception& e) {
        done(refusal(bad_request, std::string{"not JSON: "} + e.what()));
    } catch (const InputError& e) {
        done(refusal(bad_request, e.what()));
    }
}

}  // namespace shaker::web
