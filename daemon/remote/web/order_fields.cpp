#include "daemon/remote/web/order_fields.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "daemon/service/made_order.hpp"
#include "drivers/errors.hpp"

namespace shaker::web {

namespace {

using nlohmann::json;
using orders::Field;

constexpr orders::Row no_fields{.name = "", .summary = ""};

orders::Values values_of(const orders::Row& row, const json& object) {
    orders::Values values{row};
    for (const auto& [key, value] : object.items()) {
        if (values.field(key).kind == orders::Kind::regions) continue;
        if (value.is_null())
            values.add_nothing(key);
        else if (value.is_boolean())
            values.add_flag(key, value.get<bool>());
        else if (value.is_number())
            values.add_number(key, value.get<double>());
        else if (value.is_string())
            values.add_text(key, value.get<std::string>());
        else
            values.refuse(key, value.dump());
    }
    return values;
}

/// {"targets": [{"camera", "target", "region_px": [x, y, width, height]}, ...]}
service::MoveTargets targets_of(const json& object) {
    static constexpr std::array keys{Field{.key = "camera"}, Field{.key = "target"},
                                     Field{.key = "region_px", .kind = orders::Kind::regions}};
    static constexpr orders::Row target{.name = "targets", .summary = "", .fields = keys};
    if (!object.contains("targets") || !object["targets"].is_array())
        throw InputError{"targets: expected a list of objects with camera, target and region_px"};
    service::MoveTargets order;
    for (const json& given : object["targets"]) {
        if (!given.is_object())
            throw InputError{fmt::format(
                "targets: expected an object with the names camera and target, got {}", given.dump())};
        const orders::Values names = values_of(target, given);
        if (!names.has("camera") || !names.has("target"))
            throw InputError{fmt::format(
                "targets: expected an object with the names camera and target, got {}", given.dump())};
        const json region = given.value("region_px", json{});
        if (!region.is_array() || region.size() != 4 ||
            !std::ranges::all_of(region, [](const json& x) { return x.is_number(); }))
            throw InputError{
                fmt::format("region_px: expected four numbers x, y, width, height, got {}", region.dump())};
        order.targets.push_back(
            {names.text("camera"), names.text("target"), region.get<std::array<double, 4>>()});
    }
    return order;
}

json field_json(const Field& field) {
    static constexpr std::array kinds{"quantity", "whole", "word", "flag", "text", "free", "regions"};
    json out{{"key", field.key},
             {"kind", kinds.at(static_cast<std::size_t>(field.kind))},
             {"needed", field.needed},
             {"help", field.help},
             {"otherwise", field.otherwise}};
    if (field.kind == orders::Kind::quantity || field.kind == orders::Kind::whole)
        out.update({{"least", field.allowed.min}, {"most", field.allowed.max}});
    if (!field.words.empty()) out["words"] = field.words;
    return out;
}

}  // namespace

json object_of(const std::string& body) {
    try {
        json fields = body.empty() ? json::object() : json::parse(body);
        if (!fields.is_object()) throw InputError{"expected a JSON object of settings"};
        return fields;
    } catch (const json::exception& e) {
        throw InputError{std::string{"not JSON: "} + e.what()};
    }
}

void require_no_fields(const std::string& body) { static_cast<void>(values_of(no_fields, object_of(body))); }

service::OrderWhat order_of(const orders::Row& row, const std::string& body,
                            const service::PendingOrders::Settings& now) {
    const json object = object_of(body);
    const orders::Values values = values_of(row, object);
    if (row.name == "targets") return targets_of(object);
    return service::made(values, now);
}

std::string orders_json() {
    json all = json::array();
    for (const orders::Row& row : orders::rows()) {
        json fields = json::array();
        for (const Field& field : row.fields) fields.push_back(field_json(field));
        all.push_back({{"name", row.name},
                       {"summary", row.summary},
                       {"details", row.details},
                       {"fields", fields},
                       {"scpi", row.scpi},
                       {"at_rest", row.when.at_rest},
                       {"driven", row.when.driven},
                       {"tripped", row.when.tripped},
                       {"in_campaign", row.when.not_in_campaign.empty()}});
    }
    return all.dump();
}

}  // namespace shaker::web
