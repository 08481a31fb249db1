#include "daemon/campaign/lead/plans.hpp"

#include <spdlog/fmt/fmt.h>
#include <spdlog/fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <system_error>

#include "daemon/run/run_setup.hpp"
#include "daemon/run/sequence.hpp"
#include "drivers/errors.hpp"

namespace shaker::campaign {

namespace {

double walker_m(const View& view) {
    double mm = 0;
    for (const Target& t : view.targets)
        if (t.name == "walker") mm = std::max(t.diameter_mm, t.width_mm);
    return 1e-3 * mm;
}

}  // namespace

namespace {
constexpr std::uintmax_t longest_plan = 64 * 1024;  // bytes
}

std::vector<std::string> plans_in(const std::filesystem::path& folder) {
    std::vector<std::string> names;
    std::error_code gone;
    for (std::filesystem::directory_iterator at{folder, gone}, end; !gone && at != end; at.increment(gone)) {
        std::error_code no_file;
        const std::filesystem::path& file = at->path();
        if (file.extension() == ".toml" && at->is_regular_file(no_file))
            names.push_back(file.stem().string());
        if (names.size() == most_plans) break;
    }
    std::ranges::sort(names);
    return names;
}

std::string plan_text(const std::filesystem::path& folder, const std::string& name) {
    const std::vector<std::string> known = plans_in(folder);
    if (std::ranges::find(known, name) == known.end())
        throw InputError{fmt::format(
            "plan \"{}\": there is no such plan in {}; {}", name, folder.string(),
            known.empty() ? std::string{"it has none"} : fmt::format("it has {}", fmt::join(known, ", ")))};
    const std::filesystem::path file = folder / (name + ".toml");
    std::error_code unknown_size;
    if (const auto size = std::filesystem::file_size(file, unknown_size); unknown_size || size > longest_plan)
        throw InputError{
            fmt::format("plan \"{}\": {} bytes; at most {} are allowed", name, size, longest_plan)};
    std::ifstream in{file};
    if (!in) throw InputError{fmt::format("plan \"{}\": {} cannot be read", name, file.string())};
    return {std::istreambuf_iterator<char>{in}, {}};
}

std::string text_of(const Scan& s) {
    const std::string range = fmt::format("{{from = {}, to = {}, steps = {}}}", s.from, s.to, s.steps);
    return fmt::format(
        "title = \"scan of {}\"\n[[series]]\nname = \"scan\"\ngamma = {}\nphi = {}\nrho = {}\nfrequency = "
        "{}\n"
        "periods = {}\nrepeats = {}\n",
        s.phi ? "phi" : "gamma", s.phi ? fmt::to_string(s.rest.gamma) : range,
        s.phi ? range : fmt::to_string(s.rest.phi), s.rest.rho, s.rest.frequency, s.periods, s.repeats);
}

std::map<double, double> most_return_gamma(const std::vector<Point>& points, const bench::Bench& bench) {
    std::map<double, double> most;
    for (const Point& p : points) {
        const double frequency = p.asked.drive.frequency;
        if (most.contains(frequency)) continue;
        Drive back = ReturnDrives{{}, {}}.at(1, frequency);
        back.gamma = 1;
        double& gamma = most.try_emplace(frequency, INFINITY).first->second;
        try {
            for (const safety::Demand& d : run::run_demands(bench, back, run::limits_of_run(bench.limits)))
                gamma = std::min(gamma, run::usable_drive * d.limit / d.value);
        } catch (const InputError&) {
            // The data sheet ends below the second harmonic. A plan of one harmonic needs no return.
        }
    }
    return most;
}

CheckSettings check_settings(const Plan& plan, const std::vector<Point>& points, const bench::Bench& bench) {
    std::map<std::vector<double>, double> swings;  // m, by drive
    for (const Point& p : points)
        swings.try_emplace(numbers_of(p.asked.drive),
                           safety::largest_displacement(harmonics(p.asked.drive), p.asked.drive.frequency));
    return {.way = {.walker = walker_m(bench.rig.cameras.front()->view()),
                    .edge = 1e-3 * bench.limits.edge_mm,
                    .margin = 1e-3 * plan.edge_margin_mm},
            .timing = {.most_return_gamma = most_return_gamma(points, bench)},
            .gravity = bench.gravity,
            .swing = [swings](const Drive& drive) { return swings.at(numbers_of(drive)); }};
}

}  // namespace shaker::campaign
