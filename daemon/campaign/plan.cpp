#include "daemon/campaign/plan.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>
#include <span>
#include <utility>

#include "drivers/errors.hpp"
#include "drivers/settings_table.hpp"

namespace shaker::campaign {

namespace {

constexpr std::span<const PointField> all_fields{point_fields};
constexpr Range frictions{1e-3, 10}, margins_mm{0, 1000}, targets_percent{1e-3, 50};

bool same_angle(double a, double b) { return std::abs(std::remainder(a - b, two_pi)) < 1e-9; }

std::vector<double> range_of(SettingsTable range, const PointField& field) {
    const double from = range.quantity("from", field.dimension, field.allowed),
                 to = range.quantity("to", field.dimension, field.allowed);
    const int steps = range.integer("steps", 1, most_steps, 0);
    if (steps == 0) range.fail("steps", fmt::format("missing; expected a whole number, 1 to {}", most_steps));
    range.finish();
    std::vector<double> values;
    for (int i = 0; i <= steps; ++i) values.push_back(std::lerp(from, to, static_cast<double>(i) / steps));
    return values;
}

// A value, a list or a range {from, to, steps}.
std::vector<double> values_of(SettingsTable& table, const PointField& field, double otherwise) {
    if (!table.has(field.name)) return {otherwise};
    std::vector<double> values = table.is_table(field.name)
                                     ? range_of(table.table(field.name), field)
                                     : table.quantities(field.name, field.dimension, field.allowed);
    for (auto v = values.begin(); v != values.end(); ++v)
        if (std::find(values.begin(), v, *v) != v)
            table.fail(field.name,
                       fmt::format("{} is given twice; repeats = 2 measures each point twice", *v));
    return values;
}

void read_measuring(SettingsTable& table, PointSettings& point) {
    if (table.has("periods") && table.has("precision"))
        table.fail("precision", "excludes periods; give one of the two");
    for (const PointField& field : all_fields.subspan(drive_fields)) {
        if (!table.has(field.name)) continue;
        const auto least = static_cast<int>(field.allowed.min), most = static_cast<int>(field.allowed.max);
        field.set(point, field.whole() ? table.integer(field.name, least, most, 0)
                                       : table.quantity(field.name, field.dimension, field.allowed));
    }
    if (table.has("periods")) point.precision = 0;
    for (const char* key : {"least_periods", "most_periods"})
        if (table.has(key) && point.precision == 0) table.fail(key, "needs a precision, which is missing");
    if (point.precision > 0 && point.least_periods > point.most_periods)
        table.fail(
            table.has("least_periods") ? "least_periods" : "most_periods",
            fmt::format("least_periods {} exceeds most_periods {}", point.least_periods, point.most_periods));
}

std::vector<Overtones> read_overtones(SettingsTable& table) {
    if (!table.has("harmonics")) return {{}};
    std::vector<Overtones> sets;
    for (std::vector<SettingsTable>& set : table.lists_of_tables("harmonics")) {
        Overtones& overtones = sets.emplace_back();
        for (SettingsTable& harmonic : set) {
            const int n = harmonic.integer("n", 3, most_driven, 0);
            if (n == 0) harmonic.fail("n", fmt::format("missing; 3 to {} is allowed", most_driven));
            std::complex<double>& share = overtones.at(static_cast<std::size_t>(n - 3));
            if (share != 0.0) harmonic.fail("n", fmt::format("harmonic {} is given twice", n));
            share = std::polar(harmonic.quantity("share", Dimension::ratio, {1e-9, drive_limits.share.max}),
                               harmonic.quantity("phase", Dimension::angle, drive_limits.phi, 0));
            harmonic.finish();
        }
    }
    if (sets.empty()) table.fail("harmonics", "expected at least one set; [] is the set without any");
    return sets;
}

void refuse_mirror_partners(const SettingsTable& table, const std::vector<double>& phi) {
    for (const double a : phi)
        for (const double b : phi)
            if (b > a && same_angle(b, a + std::numbers::pi))
                table.fail(
                    "phi",
                    fmt::format("{:.6g} rad is the mirror partner of {:.6g} rad, which order \"mirror\" "
                                "adds by itself; leave it out",
                                b, a));
}

Series read_series(SettingsTable& table, std::size_t number, const PointSettings& defaults) {
    Series s{
        .name = table.text("name", fmt::format("{}", number)), .settings = defaults, .line = table.line("")};
    const auto values = [&](std::string_view name) {
        return values_of(table, point_field(name), point_field(name).in(defaults));
    };
    s.gamma = values("gamma");
    s.phi = values("phi");
    s.rho = values("rho");
    s.frequency = values("frequency");
    if (table.has("gamma")) s.gamma_line = table.line("gamma");
    s.overtones = read_overtones(table);
    read_measuring(table, s.settings);
    s.order = static_cast<Order>(table.choice("order", {"listed", "mirror", "random", "up_down"}, 0));
    s.repeats = table.integer("repeats", 1, most_repeats, 1);
    if (table.has("seed") && s.order != Order::random) table.fail("seed", "needs order = \"random\"");
    s.seed = static_cast<std::uint64_t>(table.integer("seed", 0, std::numeric_limits<int>::max(), 1));
    if (s.order == Order::mirror) refuse_mirror_partners(table, s.phi);
    table.finish();
    return s;
}

// "mu 0.2 %": relative standard error of mu at which the campaign ends.
double read_target(SettingsTable& root) {
    if (!root.has("stop_at")) return 0;
    const std::string words = root.text("stop_at");
    double percent = 0;
    int used = 0;
    if (std::sscanf(words.c_str(), "mu %lf %%%n", &percent, &used) != 1 ||
        static_cast<std::size_t>(used) != words.size())
        root.fail("stop_at", fmt::format("\"{}\"; expected \"mu X %\", for example \"mu 0.2 %\"", words));
    if (!(percent >= targets_percent.min && percent <= targets_percent.max))
        root.fail("stop_at", fmt::format("{:g} %; {:g} to {:g} % is allowed", percent, targets_percent.min,
                                         targets_percent.max));
    return percent / 100;
}

Plan read(SettingsTable root, const std::string& file) {
    Plan plan{.file = file, .title = root.text("title", file)};
    plan.mu = root.number("mu", frictions, plan.mu);
    plan.mu_target = read_target(root);
    plan.edge_margin_mm = root.number("edge_margin_mm", margins_mm, plan.edge_margin_mm);
    SettingsTable point = root.table("point");
    PointSettings defaults;
    for (const PointField& field : all_fields.first(drive_fields))
        field.set(defaults, point.quantity(field.name, field.dimension, field.allowed, field.in(defaults)));
    read_measuring(point, defaults);
    point.finish();
    std::vector<SettingsTable> tables = root.tables("series");
    if (tables.empty()) root.fail("series", "missing; expected at least one table [[series]]");
    for (SettingsTable& table : tables) {
        Series s = read_series(table, plan.series.size() + 1, defaults);
        if (std::ranges::find(plan.series, s.name, &Series::name) != plan.series.end())
            table.fail("name", fmt::format("two series have the name \"{}\"", s.name));
        if (s.gamma_line == 0) s.gamma_line = point.has("gamma") ? point.line("gamma") : s.line;
        plan.series.push_back(std::move(s));
    }
    root.finish();
    return plan;
}

std::vector<Drive> product(const Series& s) {
    std::vector<Drive> drives;
    for (const double frequency : s.frequency)
        for (const Overtones& overtones : s.overtones)
            for (const double rho : s.rho)
                for (const double gamma : s.gamma)
                    for (const double phi : s.phi) drives.push_back({frequency, gamma, rho, phi, overtones});
    return drives;
}

void shuffle(std::vector<Drive>& drives, std::mt19937_64& random) {
    for (std::size_t i = drives.size(); i > 1; --i) std::swap(drives[i - 1], drives[random() % i]);
}

// Appends the points of one series. Points of a pair follow each other.
void append(const Series& s, std::vector<Point>& points) {
    std::vector<Drive> drives = product(s);
    std::mt19937_64 random{s.seed};
    const auto add = [&](const Drive& drive, int repeat, int partner = 0) {
        Point p{.id = static_cast<int>(points.size()) + 1,
                .series = s.name,
                .asked = s.settings,
                .repeat = repeat,
                .partner = partner == 0 ? 0 : static_cast<int>(points.size()) + 1 + partner};
        p.asked.drive = drive;
        points.push_back(std::move(p));
    };
    for (int repeat = 1; repeat <= s.repeats; ++repeat) {
        if (s.order == Order::random) shuffle(drives, random);
        for (const Drive& drive : drives) {
            add(drive, s.order == Order::up_down ? 2 * repeat - 1 : repeat, s.order == Order::mirror ? 1 : 0);
            if (s.order == Order::mirror) add(mirror_partner(drive), repeat, -1);
        }
        if (s.order == Order::up_down)
            for (auto drive = drives.rbegin(); drive != drives.rend(); ++drive) add(*drive, 2 * repeat);
    }
}

// Or more than most_stored_points.
std::size_t count(const Series& s) {
    std::size_t n = static_cast<std::size_t>(s.repeats);
    if (s.order == Order::mirror || s.order == Order::up_down) n *= 2;
    for (const std::size_t values :
         {s.frequency.size(), s.overtones.size(), s.rho.size(), s.gamma.size(), s.phi.size()})
        n = std::max(values, n) > most_stored_points ? most_stored_points + 1 : n * values;
    return n;
}

}  // namespace

Plan read_plan(const std::filesystem::path& file) {
    return read(SettingsTable::from_file(file), file.string());
}

Plan parse_plan(std::string_view text, const std::string& file_name) {
    return read(SettingsTable::from_text(text, file_name), file_name);
}

Drive mirror_partner(const Drive& drive) {
    Drive partner = drive;
    partner.phi += drive.phi < std::numbers::pi ? std::numbers::pi : -std::numbers::pi;
    for (std::size_t i = 1; i < partner.overtones.size(); i += 2)  // harmonics 4, 6 and 8
        partner.overtones[i] = -partner.overtones[i];
    return partner;
}

std::vector<Point> schedule(const Plan& plan, std::size_t most) {
    std::size_t total = 0;
    for (const Series& s : plan.series) {
        total += count(s);
        if (total > most)
            throw InputError{
                fmt::format("{}:{}: series \"{}\": the plan has more than {} points; allowed are {}",
                            plan.file, s.line, s.name, most, most)};
    }
    std::vector<Point> points;
    points.reserve(total);
    for (const Series& s : plan.series) append(s, points);
    return points;
}

}  // namespace shaker::campaign
