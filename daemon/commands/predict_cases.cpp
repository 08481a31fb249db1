#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <string_view>

#include "daemon/commands/predict.hpp"
#include "drivers/errors.hpp"
#include "drivers/walker/no_stick.hpp"
#include "drivers/walker/steady_state.hpp"

namespace shaker::commands {

namespace {

using Json = nlohmann::json;

/// One object of the file with its location, for error messages.
class Place {
public:
    Place(const Json& object, std::string where) : object_{object}, where_{std::move(where)} {
        if (!object_.is_object()) fail("must be an object");
    }
    [[noreturn]] void fail(const std::string& why) const { throw InputError{where_ + ": " + why}; }
    [[nodiscard]] const std::string& where() const noexcept { return where_; }
    [[nodiscard]] bool has(const char* key) const { return object_.contains(key); }

    [[nodiscard]] const Json& at(const char* key) const {
        if (!has(key)) fail(fmt::format("key '{}' is missing", key));
        return object_.at(key);
    }
    [[nodiscard]] double number(const char* key) const {
        const Json& value = at(key);
        if (!value.is_number()) fail(fmt::format("{} is {}; it must be a number", key, shown(value)));
        const auto x = value.get<double>();
        if (!std::isfinite(x)) fail(fmt::format("{} is not finite", key));
        return x;
    }
    [[nodiscard]] double number(const char* key, double low, double high) const {
        const double x = number(key);
        if (!(x >= low && x <= high)) fail(fmt::format("{} is {}; allowed is {} to {}", key, x, low, high));
        return x;
    }
    [[nodiscard]] std::string text(const char* key) const {
        const Json& value = at(key);
        if (!value.is_string()) fail(fmt::format("{} is {}; it must be a string", key, shown(value)));
        return value.get<std::string>();
    }
    [[nodiscard]] const Json& list(const char* key) const {
        const Json& value = at(key);
        if (!value.is_array()) fail(fmt::format("{} is {}; it must be a list", key, shown(value)));
        return value;
    }
    void allow_only(std::initializer_list<std::string_view> keys) const {
        for (const auto& item : object_.items()) {
            if (std::find(keys.begin(), keys.end(), item.key()) != keys.end()) continue;
            fail(fmt::format("key '{}' is unknown; known are {}", item.key(), fmt::join(keys, ", ")));
        }
    }

private:
    static std::string shown(const Json& value) {
        const std::string text = value.dump(-1, ' ', false, Json::error_handler_t::replace);
        return text.size() <= 40 ? text : text.substr(0, 40) + "...";
    }

    const Json& object_;
    std::string where_;
};

Harmonics<Acceleration> harmonics_at(const Place& params, const char* key) {
    Harmonics<Acceleration> h;
    int index = 0;
    for (const Json& entry : params.list(key)) {
        const Place term{entry, fmt::format("{}: {}[{}]", params.where(), key, index++)};
        term.allow_only({"q", "a", "phase"});
        const double q = term.number("q", 1, max_harmonics);
        if (q != std::floor(q))
            term.fail(fmt::format("q is {}; it must be a whole number, 1 to {}", q, max_harmonics));
        const double a = term.number("a", -1e6, 1e6);
        h.at(static_cast<int>(q)) += a * std::polar(1.0, term.number("phase"));
    }
    return h;
}

walker::WalkerSetting setting_at(const Place& params) {
    params.allow_only({"f_hz", "g", "mu_k", "mu_s", "tilt_deg", "base_accel", "vertical_accel", "v_start",
                       "law", "phases", "viscous", "backward", "log_share", "log_velocity", "presliding",
                       "stribeck"});
    walker::WalkerSetting s;
    s.frequency = params.number("f_hz", 1e-3, 1e5);
    s.g = params.number("g", 1e-3, 1e3);
    s.friction.mu_k = params.number("mu_k", 0, 100);
    s.friction.mu_s = params.number("mu_s", 0, 100);
    if (s.friction.mu_s < s.friction.mu_k) {
        params.fail(
            fmt::format("mu_s is {}; allowed is mu_k = {} or more", s.friction.mu_s, s.friction.mu_k));
    }
    if (params.has("law")) {
        const std::string law = params.text("law");
        const auto* known = std::ranges::find(walker::friction_laws, law);
        if (known == walker::friction_laws.end())
            params.fail(
                fmt::format("law is \"{}\"; known are {}", law, fmt::join(walker::friction_laws, ", ")));
        s.friction.law = static_cast<walker::FrictionLaw>(known - walker::friction_laws.begin());
    }
    const auto optional = [&](const char* key, double& value, Range allowed) {
        if (params.has(key)) value = params.number(key, allowed.min, allowed.max);
    };
    optional("viscous", s.friction.viscous, {0, 1e4});
    optional("backward", s.friction.backward, {0.1, 10});
    optional("log_share", s.friction.log_share, {0, 10});
    optional("log_velocity", s.friction.log_velocity, {1e-6, 10});
    optional("presliding", s.friction.presliding, {1e-8, 1e-3});
    optional("stribeck", s.friction.stribeck, {1e-5, 10});
    s.tilt = params.number("tilt_deg", -89, 89) * std::numbers::pi / 180;
    s.base = harmonics_at(params, "base_accel");
    s.vertical = harmonics_at(params, "vertical_accel");
    return s;
}

/// Result of `compute`. Its InputError gets the names `keys`, the only possible cause after setting_at().
template <class Compute>
auto naming(const Place& params, const char* keys, Compute compute) {
    try {
        return compute();
    } catch (const InputError& error) {
        params.fail(fmt::format("{}: {}", keys, error.what()));
    }
}

/// The settled motion, and D of the first periods from v_start (m/s).
struct Motion {
    walker::SteadyState settled;
    std::array<double, 5> first{};  // m
};

Motion motion_of(const walker::WalkerSetting& setting, double v_start) {
    Motion m;
    const auto begin = [&](auto walker) {
        for (double& D : m.first) D = walker.advance_period();
    };
    if (setting.friction.closed_form()) {  // exact
        const walker::WalkerLaw law{setting};
        m.settled = settle(law, v_start);
        begin(walker::Walker{law, v_start});
    } else {
        begin(walker::IntegratedWalker{setting, v_start});
        walker::IntegratedWalker walker{setting, v_start};
        walker::WarmStart start;
        start.v = v_start;
        m.settled = settle_quickly(walker, start);
    }
    return m;
}

/// The settled v at t/T = i/count from v0, the settled velocity at phase 0, m/s.
Json velocities(const walker::WalkerSetting& setting, double v0, int count) {
    walker::IntegratedWalker walker{setting, v0};
    if (!setting.friction.closed_form()) {  // v0 is not all of its state
        walker::WarmStart start;
        start.v = v0;
        settle_quickly(walker, start);
    }
    walker.observe(static_cast<std::size_t>(count));
    walker.advance_period();
    const TrigPolynomial base = base_velocity(setting);
    Json list = Json::array();
    for (int i = 0; const double v_R : walker.relative()) list.push_back(v_R + base(two_pi * i++ / count));
    return list;
}

Json answer(const Place& params) {
    const walker::WalkerSetting setting = setting_at(params);
    const double v_start = params.has("v_start") ? params.number("v_start", -1e4, 1e4) : 0;
    naming(params, "vertical_accel", [&] { return checked(setting); });
    const auto [s, first] = naming(params, "tilt_deg, mu_k", [&] { return motion_of(setting, v_start); });
    const double eta = std::abs(s.v_D) / walker::v_rms(setting.base, setting.frequency);
    Json events = Json::array();
    for (const walker::WalkerEvent& e : s.events) {
        events.push_back({e.phase, static_cast<int>(e.from), static_cast<int>(e.to)});
    }
    Json found{{"v_D", s.v_D},
               {"D", s.D},
               {"eta", std::isfinite(eta) ? Json(eta) : Json()},
               {"v_at_t0", s.v0},
               {"state_at_t0", static_cast<int>(s.contact0)},
               {"events", events},
               {"stick_fraction", s.rest_fraction},
               {"startup_D", first},
               {"periods_to_converge", s.periods},
               {"contraction_per_period", s.contraction}};
    if (params.has("phases"))
        found["v"] = velocities(setting, s.v0, static_cast<int>(params.number("phases", 2, 1e5)));
    return found;
}

Json parsed(const std::filesystem::path& file) {
    std::ifstream in{file};
    if (!in) throw InputError{fmt::format("{}: cannot be opened", file.string())};
    try {
        return Json::parse(in);
    } catch (const Json::exception& error) {
        throw InputError{fmt::format("{}: is not JSON: {}", file.string(), error.what())};
    }
}

}  // namespace

std::string predict_cases(const std::filesystem::path& file) {
    const Json content = parsed(file);
    const Place top{content, file.string()};
    nlohmann::ordered_json answers = nlohmann::ordered_json::object();
    int index = 0;
    for (const Json& entry : top.list("cases")) {
        const Place numbered{entry, fmt::format("{}: case {}", file.string(), index++)};
        const std::string name = numbered.text("name");
        const Place named{entry, fmt::format("{}: case '{}'", file.string(), name)};
        if (answers.contains(name)) named.fail("the name appears twice");
        answers[name] = answer(Place{named.at("params"), named.where() + ": params"});
    }
    return answers.dump(1) + "\n";
}

}  // namespace shaker::commands
