// Which law of friction: blind scenes. A law, its parameters, mu, tilt, push and noise are drawn; an
// independent walker makes the points; the verdict is counted.
//   --count N (22): scenes   --seed N (1): of the first   --jobs N (2): at a time
//   --apart N (1): numbers from one seed to the next; 11 keeps to one law
#include <spdlog/fmt/fmt.h>

#include <cmath>
#include <map>
#include <mutex>
#include <numbers>
#include <random>

#include "daemon/law/verdict.hpp"
#include "tests/bench/option.hpp"
#include "tests/bench/table.hpp"
#include "tests/support/in_parallel.hpp"
#include "tests/support/law/stepped_walker.hpp"
#include "tests/support/law/synthetic_points.hpp"

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
    test::in_parallel(option("--count", 22), option("--jobs", 2),
                      [&](int i) { add(seed + static_cast<std::uint64_t>(i * apart), all, guard); });
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
