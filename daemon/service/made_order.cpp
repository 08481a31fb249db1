#include "daemon/service/made_order.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <string>
#include <utility>

#include "daemon/campaign/lead/plans.hpp"
#include "daemon/orders/rows.hpp"
#include "drivers/errors.hpp"

namespace shaker::service {

namespace {

using orders::Values;
using Settings = PendingOrders::Settings;

constexpr orders::Row settings_files{
    .name = "", .summary = "", .when = {.driven = false, .not_in_campaign = "the settings cannot change"}};

// One for each alternative, in their order.
constexpr std::array<std::string_view, std::variant_size_v<OrderWhat>> names{"drive",
                                                                             "start",
                                                                             "identify",
                                                                             "middle",
                                                                             "reset-walker",
                                                                             "campaign",
                                                                             "campaign/check",
                                                                             "campaign/pause",
                                                                             "stop",
                                                                             "clear",
                                                                             "record",
                                                                             "remark",
                                                                             "loop",
                                                                             "limit",
                                                                             "mu",
                                                                             "targets",
                                                                             ""};
static_assert(std::ranges::all_of(names, [](std::string_view name) {
    return orders::place_of(name) < orders::table.size() || name.empty();
}));
static_assert(orders::of::limits.size() == safety::level_rows.size() + 1);
static_assert(std::ranges::equal(safety::level_rows,
                                 std::span{orders::of::limits}.first<safety::level_rows.size()>(), {},
                                 [](const safety::LevelRow& row) { return std::string_view{row.name}; }));
static_assert(orders::of::pictures == recorded::kept_pictures_words);

Drive drive_of(const Values& v, const Drive& otherwise) {
    PointSettings point{.drive = otherwise};
    for (const PointField& field : std::span{point_fields}.first<drive_fields>())
        field.set(point, v.number(field.key, field.in(point)));
    return point.drive;
}

OrderWhat start_of(const Values& v, const Settings& now) {
    service::Begin begin{now.run.plan};
    for (const MeasurementField& field : measurement_fields)
        begin.plan.*field.member = v.whole(field.key, field.lasts ? begin.plan.*field.member : 0);
    if (std::ranges::any_of(orders::of::drive, [&](const orders::Field& f) { return v.has(f.key); }))
        begin.drive = drive_of(v, now.drive);
    return begin;
}

/// The name of a plan, or the text of a scan.
std::pair<std::string, std::string> plan_of(const Values& v, const Settings& now) {
    if (v.has("plan") == v.has("scan"))
        throw InputError{"campaign: expected either plan, the name of a plan, or scan, \"phi\" or \"gamma\""};
    if (v.has("plan")) {
        for (const orders::Field& field : v.row().fields)
            if (field.key != "plan" && v.has(field.key))
                throw InputError{fmt::format("{}: unknown key; expected plan", field.key)};
        return {v.text("plan"), ""};
    }
    const PointField& field = point_field(v.text("scan"));
    campaign::Scan scan{.phi = field.name == "phi",
                        .from = v.quantity("from", field.dimension, field.allowed),
                        .to = v.quantity("to", field.dimension, field.allowed),
                        .steps = v.whole("steps", 0),
                        .rest = now.drive,
                        .periods = v.whole("periods", now.run.plan.periods),
                        .repeats = v.whole("repeats", 1)};
    return {"scan", campaign::text_of(scan)};
}

OrderWhat limit_of(const Values& v, const Settings& /*now*/) {
    const std::string limit = v.text("limit");
    const bool warn = v.text("level", "abort") == "warn";
    const auto row = std::ranges::find(safety::level_rows, limit, &safety::LevelRow::name);
    if (row == safety::level_rows.end()) {
        if (warn) throw InputError{"level: limit edge has no level warn; expected abort"};
        return LowerLimit{{}, 1e3 * v.quantity("value", Dimension::length, {0, 1})};
    }
    const std::string_view unit{row->unit};
    const Dimension dimension = unit == "mps2"  ? Dimension::acceleration
                                : unit == "mps" ? Dimension::velocity
                                : unit == "m"   ? Dimension::length
                                                : Dimension::ratio;
    return LowerLimit{{row->level, warn ? &safety::Level::warn : &safety::Level::abort},
                      v.quantity("value", dimension, {0, std::numeric_limits<double>::infinity()})};
}

/// {"name": null} alone ends the recording.
OrderWhat record_of(const Values& v, const Settings& now) {
    Record record{
        .on = v.flag("on", !v.is_nothing("name")), .name = v.text("name"), .pictures = now.record.pictures};
    if (v.has("frames")) record.pictures = *recorded::kept_pictures_named(v.text("frames"));
    return record;
}

template <class Order>
OrderWhat plain(const Values& /*v*/, const Settings& /*now*/) {
    return Order{};
}

template <class Order>
OrderWhat of_plan(const Values& v, const Settings& now) {
    auto [name, text] = plan_of(v, now);
    return Order{std::move(name), std::move(text)};
}

template <campaign::Word word>
OrderWhat campaign_word(const Values& /*v*/, const Settings& /*now*/) {
    return TellCampaign{word};
}

struct Maker {
    std::string_view name;
    OrderWhat (*make)(const Values& v, const Settings& now);
};

constexpr std::array makers{
    Maker{"drive",
          [](const Values& v, const Settings& now) -> OrderWhat { return SetDrive{drive_of(v, now.drive)}; }},
    Maker{"start", start_of},
    Maker{"stop", plain<End>},
    Maker{"identify", plain<Identify>},
    Maker{"middle", plain<BringToMiddle>},
    Maker{"reset-walker", plain<PutWalkerBack>},
    Maker{"clear", plain<ClearTrip>},
    Maker{"campaign", of_plan<MeasurePlan>},
    Maker{"campaign/check", of_plan<CheckPlan>},
    Maker{"campaign/pause", campaign_word<campaign::Word::pause>},
    Maker{"campaign/resume", campaign_word<campaign::Word::resume>},
    Maker{"campaign/skip", campaign_word<campaign::Word::skip>},
    Maker{"campaign/repeat", campaign_word<campaign::Word::repeat>},
    Maker{"campaign/stop", campaign_word<campaign::Word::stop>},
    Maker{"mu",
          [](const Values& v, const Settings&) -> OrderWhat {
              const double mu = v.number("mu", NAN), sigma = v.number("sigma", 0);
              require_allowed("sigma", sigma, {0, mu});
              return GiveMu{{mu, sigma}};
          }},
    Maker{"remark", [](const Values& v, const Settings&) -> OrderWhat { return Remark{v.text("text")}; }},
    Maker{"loop",
          [](const Values& v, const Settings&) -> OrderWhat { return CloseLoop{v.flag("closed", false)}; }},
    Maker{"record", record_of},
    Maker{"limit", limit_of},
};
static_assert(std::ranges::all_of(orders::table, [](const orders::Row& row) {
    return row.name == "targets" || std::ranges::find(makers, row.name, &Maker::name) != makers.end();
}));

}  // namespace

const orders::Row& row_of(const OrderWhat& what) {
    const std::string_view name = names.at(what.index());
    return name.empty() ? settings_files : orders::row(name);
}

OrderWhat made(const Values& values, const Settings& now) {
    values.require_complete();
    return std::ranges::find(makers, values.row().name, &Maker::name)->make(values, now);
}

}  // namespace shaker::service
