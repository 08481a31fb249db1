#include <spdlog/fmt/fmt.h>

#include <numbers>
#include <random>
#include <utility>

#include "daemon/campaign/plan.hpp"
#include "drivers/errors.hpp"

namespace shaker::campaign {

namespace {

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

std::size_t count(const Series& s) {
    std::size_t n = static_cast<std::size_t>(s.repeats);
    if (s.order == Order::mirror || s.order == Order::up_down) n *= 2;
    for (const std::size_t values :
         {s.frequency.size(), s.overtones.size(), s.rho.size(), s.gamma.size(), s.phi.size()})
        n = values > most_points || n > most_points ? most_points + 1 : n * values;
    return n;
}

}  // namespace

Drive mirror_partner(const Drive& drive) {
    Drive partner = drive;
    partner.phi += drive.phi < std::numbers::pi ? std::numbers::pi : -std::numbers::pi;
    for (std::size_t i = 1; i < partner.overtones.size(); i += 2)  // harmonics 4, 6 and 8
        partner.overtones[i] = -partner.overtones[i];
    return partner;
}

std::vector<Point> schedule(const Plan& plan) {
    std::size_t total = 0;
    for (const Series& s : plan.series) {
        total += count(s);
        if (total > most_points)
            throw InputError{
                fmt::format("{}:{}: series \"{}\": the plan has more than {} points; allowed are {}",
                            plan.file, s.line, s.name, most_points, most_points)};
    }
    std::vector<Point> points;
    points.reserve(total);
    for (const Series& s : plan.series) append(s, points);
    return points;
}

}  // namespace shaker::campaign
