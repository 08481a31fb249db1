#include "daemon/remote/web/law_answer.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "daemon/law/law_curve.hpp"

namespace shaker::web {

namespace {

using nlohmann::json;

constexpr std::size_t gammas = 49, phis = 73;  // values of a curve
constexpr double least_gamma = 3 * paper_g;    // end of the curve against gamma, m/s^2

json values_json(const law::LawValues& v) { return {{"at_mu", v.at_mu}, {"low", v.low}, {"high", v.high}}; }

json curve_json(const char* x, const law::LawCurve& curve) {
    return {{x, curve.x},
            {"exact_mps", values_json(curve.exact)},
            {"closed_form_mps", values_json(curve.closed_form)}};
}

}  // namespace

bool LawAnswer::Asked::same(const Asked& other) const {
    return service::same(drive, other.drive) && mu.value == other.mu.value && mu.sigma == other.mu.sigma &&
           g == other.g && to == other.to;
}

// The curve covers twice the set-point and all points, in whole steps of the least curve.
LawAnswer::Asked LawAnswer::asked_of(const service::BenchState& state) {
    double most = 2 * state.wanted.gamma;
    for (const reduction::DrivenPoint& p : state.points) most = std::max(most, 1.1 * p.gamma.value);
    return {state.wanted, state.mu, state.facts ? state.facts->gravity : paper_g,
            least_gamma * std::max(1.0, std::ceil(most / least_gamma))};
}

std::string LawAnswer::computed(const Asked& asked) {
    const law::LawCurve gamma = law::against_gamma(asked.drive, asked.to, gammas, asked.mu, asked.g);
    const law::LawCurve phi = law::against_phi(asked.drive, phis, asked.mu, asked.g);
    return json{{"mu", asked.mu.value},
                {"sigma", asked.mu.sigma},
                {"gamma_mps2", asked.drive.gamma},
                {"phi_rad", asked.drive.phi},
                {"gamma", curve_json("gamma_mps2", gamma)},
                {"phi", curve_json("phi_rad", phi)}}
        .dump();
}

std::optional<std::string> LawAnswer::of(const service::BenchState& state) {
    if (!std::isfinite(state.mu.value)) return R"({"mu":null})";
    if (under_way_.valid()) {
        if (!is_ready(under_way_)) return std::nullopt;
        text_ = under_way_.get();
    }
    const Asked asked = asked_of(state);
    if (!text_.empty() && asked.same(asked_)) return text_;
    asked_ = asked;
    text_.clear();
    under_way_ = beside_->run([asked] { return computed(asked); });
    return std::nullopt;
}

}  // namespace shaker::web
