// Which law of friction: blind scenes. A law, its parameters, mu, tilt, push and noise are drawn; an
// independent walker makes the points; the verdict is counted.
//   --count N (22): scenes   --seed N (1): of the first   --jobs N (2): at a time
//   --apart N (1): numbers from one seed to the next; 11 keeps to one law
//   --campaigns N (0): so many whole campaigns by plans/law.toml on simulated benches, instead of points;
//   only laws that a scene file has. Column "distinguishable" is 0 then: nobody decides it beforehand
#include <spdlog/fmt/fmt.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>

#include "daemon/law/verdict.hpp"
#include "tests/bench/option.hpp"
#include "tests/bench/table.hpp"
#include "tests/support/in_parallel.hpp"
#include "tests/support/law/stepped_walker.hpp"
#include "tests/support/law/synthetic_points.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/program.hpp"

namespace {

using namespace shaker;
using law::LawSetting;

constexpr double clearly = 2 * law::decisive;  // difference of scores that noise does not hide

struct Scene {
    const law::Law* law = nullptr;
    LawSetting setting{};
    std::vector<double> parameters{};
    double noise = 1;  // of v_D, over that of a steady walker
};

double drawn(std::string_view parameter, std::mt19937_64& random) {
    const auto uniform = [&](double a, double b) { return std::uniform_real_distribution{a, b}(random); };
    const auto sign = [&] { return uniform(-1, 1) < 0 ? -1 : 1; };
    if (parameter == "c") return uniform(0.5, 6);
    if (parameter == "s_0") return 1e-6 * std::exp(uniform(0, 3));
    if (parameter == "mu_s/mu_k") return uniform(1.1, 1.5);
    if (parameter == "v_s") return 4e-3 * std::exp(uniform(0, 2.7));
    if (parameter == "B") return uniform(0.005, 0.1);
    if (parameter == "mu backwards/forwards") return 1 + sign() * uniform(0.01, 0.1);
    if (parameter == "excess") return sign() * uniform(0.02, 0.1);
    if (parameter == "its time") return 15 * std::exp(uniform(0, 2));
    if (parameter == "slope") return sign() * uniform(0.3, 3);
    return sign() * uniform(0.002, 0.02);  // vertical motion
}

Scene scene_of(std::uint64_t seed) {
    std::mt19937_64 random{seed};
    const auto uniform = [&](double a, double b) { return std::uniform_real_distribution{a, b}(random); };
    Scene s{.law = &law::laws[seed % law::laws.size()]};
    s.setting.friction.law = s.law->friction;
    s.setting.friction.mu_k = uniform(0.08, 0.2);
    s.setting.tilt = uniform(-1e-3, 1e-3);
    s.setting.push = uniform(0.01, 0.1);
    s.noise = std::exp(uniform(0, 2.3));
    for (const law::LawParameter& p : s.law->parameters) {
        s.parameters.push_back(drawn(p.name, random));
        p.set(s.setting, s.parameters.back());
    }
    return s;
}

law::Verdict judged(const std::vector<law::Point>& points, double tilt) {
    return law::judge(points, {}, {tilt, 3e-5});
}

struct Counts {
    int scenes = 0, distinguishable = 0, right = 0, open = 0, wrong = 0, refused = 0;
    int values = 0, within_2 = 0;
};

// What the points without noise say: every law that does not contain the true one is clearly worse.
bool distinguishes(const law::Verdict& v, const law::Law& truth) {
    const auto at = static_cast<std::size_t>(&truth - law::laws.data());
    for (std::size_t i = 0; i < v.fits.size(); ++i) {
        const auto& inside = v.fits[i].law->contains;
        const bool contains = std::ranges::find(inside, truth.name) != inside.end();
        if (i != at && !contains && v.score[i] - v.score[at] < clearly) return false;
    }
    return std::isfinite(v.score[at]);
}

/// [walker] of a scene file; empty for a law that scenes do not have.
std::string walker_text(const Scene& s) {
    const walker::Friction& f = s.setting.friction;
    const double mu = f.mu_k;
    std::string text =
        fmt::format("law = \"{}\"\nmu_k = {}\nmu_s = {}\nviscous_per_s = {}\nbackward_ratio = {}\n",
                    walker::friction_laws.at(static_cast<std::size_t>(f.law)), mu,
                    mu * s.setting.static_ratio, f.viscous, f.backward);
    using enum walker::FrictionLaw;
    if (f.law == logarithmic) text += fmt::format("log_share = {}\n", f.log_share);
    if (f.law == dahl) text += fmt::format("dahl_um = {}\n", 1e6 * f.presliding);
    if (f.law == stribeck) text += fmt::format("stribeck_mps = {}\n", f.stribeck);
    if (s.law->name == "time")
        text += fmt::format("mu_relaxation = {}\nrelaxation_s = {}\n", s.setting.excess, s.setting.excess_s);
    return s.law->name == "place" || s.law->name == "vertical" ? std::string{} : text;
}

/// A campaign on a bench with this walker, its laws as of "shakerd law --json"; null when it failed.
nlohmann::json campaign_of(const Scene& s, std::uint64_t seed, const std::filesystem::path& folder) {
    std::filesystem::create_directories(folder);
    std::ofstream{folder / "scene.toml"} << fmt::format(
        "seed = {}\ntilt_deg = {}\n[accelerometer]\nlowpass_hz = 1000\ntold_low_pass_hz = 1000\n[walker]\n{}",
        seed, s.setting.tilt * 180 / std::numbers::pi, walker_text(s));
    const auto run = test::shakerd(fmt::format("campaign {} --scene scene.toml -o points",
                                               test::source_dir() + "/daemon/campaign/plans/law.toml"),
                                   folder);
    const auto law = test::shakerd("law points --json", folder);
    if (run.status == 0 && law.status == 0) return nlohmann::json::parse(law.out);
    fmt::print(stderr, "seed {}: {}{}\n", seed, run.err, law.err);
    return {};
}

void add_campaign(std::uint64_t seed, const std::filesystem::path& folder,
                  std::map<std::string_view, Counts>& all, std::mutex& guard) {
    const Scene scene = scene_of(seed);
    if (walker_text(scene).empty()) return;
    const nlohmann::json found = campaign_of(scene, seed, folder / std::to_string(seed));
    std::filesystem::remove_all(folder / std::to_string(seed));
    const std::scoped_lock lock{guard};
    Counts& c = all[scene.law->name];
    ++c.scenes;
    if (found.is_null()) return;
    const bool refused = found["refused"],
               chosen = found["chosen"] == std::string{scene.law->name} && !refused;
    const bool named = std::ranges::any_of(found["rivals"],
                                           [&](const auto& r) { return r == std::string{scene.law->name}; });
    const bool judged = std::ranges::any_of(found["laws"], [&](const auto& law) {
        return law["name"] == std::string{scene.law->name} && law["reason"] == "";
    });
    c.refused += refused;
    ++(chosen ? c.right : refused || named || !judged || found["chosen"].is_null() ? c.open : c.wrong);
    if (!chosen)
        fmt::print(stderr, "seed {}: {} {}: {}\n", seed, scene.law->name, fmt::join(scene.parameters, " "),
                   found["sentence"].get<std::string>());
    if (!chosen) return;
    const auto judge = [&](double value, double error, double truth) {
        c.within_2 += std::abs(value - truth) < 2 * error;
        ++c.values;
    };
    for (const auto& law : found["laws"]) {
        if (law["name"] != found["chosen"]) continue;
        judge(law["mu"], law["mu_error"], scene.setting.friction.mu_k);
        for (std::size_t i = 0; i < scene.parameters.size(); ++i)
            judge(law["parameters"][i]["value"], law["parameters"][i]["error"], scene.parameters[i]);
    }
}

void add(std::uint64_t seed, std::map<std::string_view, Counts>& all, std::mutex& guard) {
    const Scene scene = scene_of(seed);
    std::vector<law::Point> points = test::stepped_points(scene.setting, 20'000);
    for (law::Point& p : points) p.v_D.sigma *= scene.noise;
    const bool distinguishable = distinguishes(judged(points, scene.setting.tilt), *scene.law);
    std::mt19937_64 random{seed + 1'000'000};
    test::add_noise(points, random);
    const law::Verdict v =
        judged(points, scene.setting.tilt + 3e-5 * std::normal_distribution<double>{}(random));
    const std::scoped_lock lock{guard};
    Counts& c = all[scene.law->name];
    ++c.scenes;
    c.distinguishable += distinguishable;
    c.refused += v.refused;
    const law::LawFit* chosen = v.chosen ? &v.fits[*v.chosen] : nullptr;
    const bool right = chosen != nullptr && chosen->law == scene.law && !v.refused;
    const bool open = !right && (v.refused || std::ranges::any_of(v.rivals, [&](std::size_t i) {
                                     return v.fits[i].law == scene.law;
                                 }));
    if (distinguishable) ++(right ? c.right : open ? c.open : c.wrong);
    if (distinguishable && !right)
        fmt::print(stderr, "seed {}: {} {}\n{}", seed, scene.law->name, fmt::join(scene.parameters, " "),
                   verdict_text(v));
    if (!right) return;
    const double place = scene.law->name == "place" ? scene.parameters[0] : 0;
    const double mu = scene.setting.friction.mu_k * (1 + place * chosen->setting.middle);
    c.within_2 += std::abs(chosen->mu.value - mu) < 2 * chosen->mu.error;
    ++c.values;
    for (std::size_t i = 0; i < scene.parameters.size(); ++i, ++c.values) {
        const double truth = place != 0 ? place / (1 + place * chosen->setting.middle) : scene.parameters[i];
        c.within_2 += std::abs(chosen->parameters[i].value - truth) < 2 * chosen->parameters[i].error;
    }
}

}  // namespace

int main(int argc, char** argv) {
    const auto option = [&](const char* name, int otherwise) {
        return bench::whole_option(argc, argv, name, otherwise, 1);
    };
    std::map<std::string_view, Counts> all;
    std::mutex guard;
    const auto seed = static_cast<std::uint64_t>(option("--seed", 1));
    const int apart = option("--apart", 1);
    const int campaigns = bench::whole_option(argc, argv, "--campaigns", 0, 0);
    const auto folder = bench::own_folder(argc, argv, "laws");
    test::in_parallel(campaigns > 0 ? campaigns : option("--count", 22), option("--jobs", 2), [&](int i) {
        const std::uint64_t of = seed + static_cast<std::uint64_t>(i * apart);
        campaigns > 0 ? add_campaign(of, folder, all, guard) : add(of, all, guard);
    });
    std::filesystem::remove_all(folder);
    Counts sum;
    for (const auto& [name, c] : all)
        for (int Counts::*count : {&Counts::scenes, &Counts::distinguishable, &Counts::right, &Counts::open,
                                   &Counts::wrong, &Counts::refused, &Counts::values, &Counts::within_2})
            sum.*count += c.*count;
    all["all"] = sum;
    bench::Table table;
    for (const auto& [name, c] : all)
        table.add({{"law", std::string{name}},
                   {"scenes", static_cast<double>(c.scenes)},
                   {"distinguishable", static_cast<double>(c.distinguishable)},
                   {"right", static_cast<double>(c.right)},
                   {"left open", static_cast<double>(c.open)},
                   {"wrong", static_cast<double>(c.wrong)},
                   {"no law describes", static_cast<double>(c.refused)},
                   {"fitted values", static_cast<double>(c.values)},
                   {"within 2 errors", 100.0 * c.within_2 / std::max(1, c.values), "%"}});
    table.print(argc, argv);
    return sum.wrong > 0 ? 1 : 0;
}
