#include "daemon/remote/web/state_json.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

#include "daemon/catalogue/row_text.hpp"
#include "daemon/remote/web/picture_figures.hpp"
#include "daemon/service/published.hpp"

namespace shaker::web {

namespace {

using nlohmann::json;

constexpr auto value_of = []<class T>(T value) -> json {
    if constexpr (std::is_same_v<T, std::monostate>)
        return nullptr;
    else
        return value;
};

json session(const service::BenchState& s, const Viewer& viewer) {
    json trip = nullptr;
    if (s.trip)
        trip = {{"cause", name(s.trip->cause)},
                {"text", text(*s.trip)},
                {"finding", finding(*s.trip)},
                {"advice", safety::advice(s.trip->cause)},
                {"value", s.trip->value},
                {"limit", s.trip->limit},
                {"t_s", s.trip_s},
                {"age_s", s.now_s - s.trip_s},
                {"pictures", s.trip_pictures.size()},
                {"recording", s.trip_file.empty() ? json(nullptr) : json(s.trip_file)}};
    return {{"state", word_of(s)},
            {"rig", s.facts ? s.facts->rig : ""},
            {"simulated", s.facts && s.facts->simulated},
            {"recording", s.recording.name.empty() ? json(nullptr) : json(s.recording.name)},
            {"frames", name(s.pictures)},
            {"record_name", s.record_name.empty() ? json(nullptr) : json(s.record_name)},
            {"controller", viewer.controller.empty() ? json(nullptr) : json(viewer.controller)},
            {"you_control", viewer.controls},
            {"trip", trip},
            {"program", "shakerd"},
            {"version", SHAKER_VERSION},
            {"daemon", viewer.daemon}};
}

json harmonics(const service::BenchState& s) {
    json all = json::array();
    for (int n = 1; s.base && n <= s.base->controlled; ++n) {
        const service::HarmonicState& h = s.base->harmonics.at(static_cast<std::size_t>(n - 1));
        const bool asked = std::abs(h.target) > 0;
        all.push_back({{"n", n},
                       {"target_mps2", std::abs(h.target)},
                       {"measured_mps2", std::abs(h.measured)},
                       {"phase_error_rad", asked ? json(std::arg(h.measured / h.target)) : json(nullptr)},
                       {"sigma_mps2", h.sigma}});
    }
    return all;
}

// The measurement of a result; "current": it was made at the present set-point.
json origin(const service::BenchState& s) {
    const service::ResultOrigin& o = s.result_origin;
    return {{"number", o.number},
            {"from_s", o.from_s},
            {"to_s", o.to_s},
            {"drive", catalogue::asked_json(o.asked)},
            {"current", service::same(o.asked, s.wanted)}};
}

json result(const service::BenchState& s) {
    json all = s.result ? origin(s) : json::object();
    const reduction::Reduction* r = s.result.get();
    for (const auto& [q, member] : catalogue::listed_quantities)
        all[std::string{q.name}.append(q.suffix)] =
            r ? catalogue::json_of(q.of(*r), q.systematic ? q.systematic(*r) : NAN) : json(nullptr);
    all["bench_alarm"] = r && r->gain_ratio.alarm;
    all["stick"] = json::array();
    if (r)
        for (const reduction::StickInterval& k : r->stick) all["stick"].push_back({k.from, k.to});
    all["mu"] = catalogue::json_of(s.mu);
    all["mu_refused"] = s.fitted_mu.refused ? s.fitted_mu.note : "";
    all["friction"] = json::array();
    for (const law::FrictionAt& at : s.friction.at)
        all["friction"].push_back({at.v_R, at.mu.value, at.mu.sigma});
    all["steady"] = r && s.measuring;
    return all;
}

json points(const service::BenchState& s) {
    json list = json::array();
    for (std::size_t i = 0; i < s.points.size(); ++i) {
        const reduction::DrivenPoint& p = s.points[i];
        list.push_back({{"gamma_mps2", p.gamma.value},
                        {"phi_rad", p.phi.value},
                        {"v_D_mps", p.v_D.value},
                        {"sigma_mps", p.v_D.sigma},
                        {"closed_form_mps", s.closed_form.at(i)}});
    }
    return list;
}

json outlook(const service::BenchState& s) {
    const service::OutlookState& o = s.outlook;
    json recorded = json::object();
    for (std::size_t i = 0; i < o.sizes.size(); ++i)
        if (const service::OutlookState::Size& size = o.sizes.at(i); std::isfinite(size.bytes_per_s))
            recorded[std::string{recorded::kept_pictures_words.at(i)}] = {{"bytes_per_s", size.bytes_per_s},
                                                                          {"first_bytes", size.first_bytes}};
    return {{"before_periods", o.before},
            {"walking_periods", o.walking},
            {"walk_mps", o.walk ? catalogue::json_of(o.walk->v_D) : json(nullptr)},
            {"walk_from", o.walk ? json(o.walk->from) : json(nullptr)},
            {"way_m", o.way_m},
            {"recorded", std::move(recorded)}};
}

json progress(const service::BenchState& s) {
    if (!s.progress) return nullptr;
    const service::ProgressState& p = *s.progress;
    return {{"measurement", p.measurement},
            {"measurements", p.measurements},
            {"periods_done", std::floor(p.periods_done)},
            {"left_s", p.left_s},
            {"waits_for", p.waits_for.empty() ? json(nullptr) : json(p.waits_for)},
            {"walk_mps", p.walk_mps},
            {"periods_left", std::floor(p.periods_left)}};
}

json campaign(const service::BenchState& s) {
    if (!s.campaign) return nullptr;
    const service::CampaignState& c = *s.campaign;
    return {{"name", c.name},   {"title", c.title},   {"folder", c.folder},    {"doing", c.doing},
            {"point", c.point}, {"newest", c.newest}, {"known_mu", c.known_mu}};
}

json plan_check(const service::BenchState& s) {
    if (!s.plan_check) return nullptr;
    const service::PlanCheckState& c = *s.plan_check;
    return {{"plan", c.name},       {"under_way", c.under_way}, {"points", c.points},
            {"fit", c.fit},         {"bench_s", c.bench_s},     {"bytes", c.bytes},
            {"summary", c.summary}, {"misfits", c.misfits}};
}

json gauges(const service::BenchState& s) {
    json list = json::array();
    for (const service::GaugeState& g : s.gauges)
        list.push_back({{"quantity", g.quantity},
                        {"unit", g.unit},
                        {"limit", g.limit},
                        {"set_point", g.set_point},
                        {"live", g.live}});
    return list;
}

json losses(const service::BenchState& s) {
    json list = json::array();
    for (const DeviceReport& d : s.devices) {
        std::string stream = d.device;
        if (const auto quote = stream.find('"'); stream.starts_with("camera ") && quote != std::string::npos)
            stream = "camera:" + stream.substr(quote + 1, stream.size() - quote - 2);
        list.push_back({{"stream", stream}, {"got", d.counts.taken}, {"lost", d.counts.lost}});
    }
    return list;
}

// The region of a target where the target is now.
json proposed(const service::BenchState& s, std::size_t camera, std::size_t target) {
    if (camera >= s.pictures_now.size() || target >= s.pictures_now[camera].regions_now.size())
        return nullptr;
    const auto& region = s.pictures_now[camera].regions_now[target];
    return region ? json(*region) : json(nullptr);
}

// Each camera's geometry and targets, exposure and focus.
json cameras(const service::BenchState& s) {
    const service::PictureState none;
    json list = json::array();
    for (std::size_t i = 0; s.facts && i < s.facts->views.size(); ++i) {
        const View& v = s.facts->views[i];
        const service::PictureState& picture = i < s.pictures_now.size() ? s.pictures_now[i] : none;
        const FramePtr& frame = picture.frame;
        const PictureFigures seen = frame ? figures_of(*frame) : PictureFigures{NAN, NAN};
        json targets = json::array();
        for (std::size_t k = 0; k < v.targets.size(); ++k)
            targets.push_back({{"name", v.targets[k].name},
                               {"region_px", v.targets[k].roi_px},
                               {"proposed_px", proposed(s, i, k)}});
        list.push_back({{"name", v.camera},
                        {"width_px", frame ? json(frame->width) : json(nullptr)},
                        {"height_px", frame ? json(frame->height) : json(nullptr)},
                        {"origin_px", v.origin_px},
                        {"mm_per_px", v.mm_per_px},
                        {"along", v.along},
                        {"exposure_s", v.exposure_s},
                        {"clipped", seen.clipped},
                        {"edge_px", seen.edge_px},
                        {"not_found", picture.not_found.empty() ? json(nullptr) : json(picture.not_found)},
                        {"targets", targets}});
    }
    return list;
}

json real_time(const service::BenchState& s) {
    json list = json::array();
    for (const acquisition::RealTimeGrant& g : s.real_time)
        list.push_back({{"what", g.what}, {"refused", g.refused.empty() ? json(nullptr) : json(g.refused)}});
    return list;
}

json switches(const service::BenchState& s) {
    return {{"abort_contact", s.contact ? json(service::word_of(*s.contact)) : json(nullptr)}};
}

json limits(const safety::Limits& l) {
    json all{{"edge_m", 1e-3 * l.edge_mm}};
    for (const safety::LevelRow& row : safety::level_rows)
        all[row.key(&safety::Level::abort)] = (l.*row.level).abort;
    return all;
}

// A section that is null has no members.
void add_published(const service::BenchState& s, json& all) {
    for (const service::Published& row : service::published_quantities()) {
        if (row.json == nullptr) continue;
        const json::json_pointer place{row.json};
        json& section = all.at(place.parent_pointer());
        if (!section.is_null()) section[place.back()] = std::visit(value_of, row.value(s));
    }
}

}  // namespace

const char* word_of(const service::BenchState& state) noexcept {
    if (state.state == run::RunState::idle && state.armed) return row_of(run::RunState::armed).shown;
    if (state.state == run::RunState::run && !state.measuring) return "settling";
    return row_of(state.state).shown;
}

std::string state_json(const service::BenchState& s, const Viewer& viewer) {
    json clocks = json::array();
    for (const service::ClockState& c : s.clocks)
        clocks.push_back({{"name", c.name}, {"ppm", c.ppm}, {"residual_s", c.residual_s}});
    json all{{"type", "state"},
             {"session", session(s, viewer)},
             {"drive", catalogue::asked_json(s.wanted)},
             {"measured", {{"harmonics", harmonics(s)}}},
             {"result", result(s)},
             {"walker", s.walker ? json::object() : json(nullptr)},
             {"outlook", outlook(s)},
             {"progress", progress(s)},
             {"campaign", campaign(s)},
             {"plan_check", plan_check(s)},
             {"plans", s.plans},
             {"gauges", gauges(s)},
             {"clocks", clocks},
             {"losses", losses(s)},
             {"disk", json::object()},
             {"tracking", json::object()},
             {"jitter", {{"bins_s", acquisition::PeriodJitter::ends_s}, {"counts", s.jitter.counts}}},
             {"cameras", cameras(s)},
             {"real_time", real_time(s)},
             {"switches", switches(s)},
             {"limits", limits(s.limits)}};
    add_published(s, all);
    if (!viewer.knows_points) all["points"] = points(s);
    return all.dump(-1, ' ', false, json::error_handler_t::replace);
}

std::shared_ptr<const std::string> StateTexts::of(const std::shared_ptr<const service::BenchState>& state,
                                                  const Viewer& viewer) {
    constexpr std::chrono::milliseconds fresh{33};
    Made& made = made_[(viewer.controls ? 2U : 0U) + (viewer.knows_points ? 1U : 0U)];
    const auto now = access::ServerClock::now();
    const bool same =
        made.of == state || (made.of && now - made.at < fresh && made.of->state == state->state &&
                             made.of->result == state->result && made.of->answered == state->answered);
    if (!same || made.controller != viewer.controller)
        made = {state, viewer.controller, now,
                std::make_shared<const std::string>(state_json(*state, viewer))};
    return made.text;
}

std::string result_json(const service::BenchState& s) {
    const reduction::Reduction& r = *s.result;
    json all = json::parse(report::results_json(r));
    all["measurement"] = origin(s);
    const reduction::Cycle& c = r.cycle;
    all["cycle"] = {{"phase", c.phase}, {"x_m", c.x_m},           {"x_sd_m", c.x_sd_m},
                    {"v_mps", c.v_mps}, {"v_sd_mps", c.v_sd_mps}, {"v_base_mps", c.v_base_mps}};
    return all.dump();
}

std::string event_json(const service::BenchEvent& e, double now_s) {
    return json{{"type", "event"},        {"id", e.id},     {"t_s", e.t_s},
                {"age_s", now_s - e.t_s}, {"kind", e.kind}, {"text", e.text}}
        .dump(-1, ' ', false, json::error_handler_t::replace);
}

}  // namespace shaker::web
